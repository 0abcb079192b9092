"""A person who presses whatever there is."""

from __future__ import annotations

from contextlib import suppress

import numpy as np

from tests.studio.driving import Page

KEYS = "vvvupsdmgr"
BUTTONS = (
    *("undo", "redo", "back", "end", "compare", "home", "best", "toEnd", "play", "take", "leaveIt", "stop"),
    *("measure", "certify", "save", "export"),
)


def random_clicks(page: Page, rng: np.random.Generator, count: int) -> None:
    """Click on the board, press keys and buttons, and ask partners, at random; nothing is waited for."""
    tab = page.tab
    tab.on("dialog", lambda dialog: dialog.dismiss())
    half = tab.evaluate("studioHalf()")
    tab.select_option("#budget", "20000")
    for _ in range(count):
        what = rng.random()
        if what < 0.35:  # where it may go on
            places = tab.evaluate("studioOffered()")
            at = places[int(rng.integers(len(places)))] if places else (0, 0)
            tab.mouse.click(*page.where((at[0], at[1])))
        elif what < 0.6:
            at = int(rng.integers(-half[0], half[0] + 1)), int(rng.integers(-half[1], half[1] + 1))
            tab.mouse.click(*page.where(at))
        elif what < 0.75:
            tab.keyboard.press(str(rng.choice(list(KEYS))))
        elif what < 0.8:
            tab.keyboard.press(str(rng.choice(["Escape", "ArrowUp", "ArrowLeft", "Enter", "Delete"])))
        elif what < 0.95:
            button = tab.locator(f"#{rng.choice(BUTTONS)}")
            if button.is_visible() and button.is_enabled():
                with suppress(Exception):  # it is gone meanwhile
                    button.click(timeout=500)
        else:
            task = tab.locator(f"[data-task={rng.choice(['suggest', 'finish', 'improve', 'repair'])}]")
            if task.is_enabled():
                with suppress(Exception):
                    task.click(timeout=500)
