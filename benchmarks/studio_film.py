"""The film of the studio's documentation: ``python -m benchmarks.studio_film docs/images/studio.gif``.

A bowl designed together on the real page: a start and an extension by hand, a suggestion that is taken, an improvement
that is watched, stopped and taken, and the fold.
"""

from __future__ import annotations

import sys
import tempfile
import time
from io import BytesIO
from pathlib import Path
from typing import Any

from PIL import Image
from playwright.sync_api import sync_playwright

from tests.studio.driving import CHROMIUM, FLAGS, Page, browser_page, studio, wait_for

SIZE = {"width": 1180, "height": 790}
WIDTH = 880
COLOURS = 240
WATCHED = 20.0
"""Seconds for which an improvement is watched."""
MODE = 1
"""Rigid body mode of the extension by hand."""


class Film:
    """Frames of a tab, each with how long it stays, in seconds."""

    def __init__(self, tab: Any) -> None:
        self.tab = tab
        self.frames: list[tuple[Image.Image, float]] = []

    def shoot(self, seconds: float = 0.6) -> None:
        self.tab.evaluate("scrollTo(0, 0)")
        with Image.open(BytesIO(self.tab.screenshot())) as picture:
            size = WIDTH, round(picture.height * WIDTH / picture.width)
            self.frames.append((picture.convert("RGB").resize(size, Image.Resampling.LANCZOS), seconds))

    def save(self, path: Path) -> None:
        """One palette for all frames, so that what stays the same costs nothing."""
        frames = [picture for picture, _ in self.frames]
        width, height = frames[0].size
        all_of_them = Image.new("RGB", (width, height * len(frames)))
        for k, picture in enumerate(frames):
            all_of_them.paste(picture, (0, height * k))
        palette = all_of_them.quantize(COLOURS, dither=Image.Dither.NONE)
        pictures = [picture.quantize(palette=palette, dither=Image.Dither.NONE) for picture in frames]
        durations = [round(1000 * seconds) for _, seconds in self.frames]
        pictures[0].save(path, save_all=True, append_images=pictures[1:], duration=durations, loop=0, optimize=True)


def design(page: Page, film: Film) -> None:
    tab = page.tab
    film.shoot(1.2)
    page.point((2, 2))
    page.click((2, 2))
    film.shoot(1.0)
    page.turn(MODE)
    for at in ((2, 2), None, None):
        offered = tab.evaluate("studioOffered()")
        found = at or (offered[len(offered) // 2][0], offered[len(offered) // 2][1])
        page.point(found)
        tab.wait_for_timeout(400)
        film.shoot(0.8)
        page.click(found)
    tab.mouse.move(5, 400)
    tab.wait_for_timeout(400)
    film.shoot(1.0)
    tab.click("[data-task=suggest]")
    wait_for(lambda: "leads to" in page.text("besideTitle"), 300)
    tab.locator("#proposals button", has_text="extend").first.click()
    tab.wait_for_timeout(800)
    film.shoot(1.8)
    page.press("take")
    tab.wait_for_timeout(400)
    film.shoot(1.0)
    tab.select_option("#budget", "5000000")
    tab.click("[data-task=improve]")
    wait_for(lambda: "improve: return" in page.text("besideTitle"), 300)
    seen, ends = "", time.monotonic() + WATCHED
    while time.monotonic() < ends:
        if (title := page.text("besideTitle")) != seen:
            seen = title
            film.shoot(0.7)
        tab.wait_for_timeout(50)
    film.shoot(1.2)
    tab.click("#stop")
    wait_for(lambda: tab.is_hidden("#stop"))
    page.press("take")
    tab.wait_for_timeout(400)
    film.shoot(1.2)
    most = float(tab.evaluate("parseFloat(document.getElementById('angle').textContent)"))
    for part in (0, 0.2, 0.4, 0.6, 0.8, 1):
        tab.evaluate(f"slider.value = {part * most}; slider.dispatchEvent(new Event('input'))")
        tab.wait_for_timeout(120)
        film.shoot(0.18 if part < 1 else 1.2)
    tab.click("#best")
    tab.wait_for_timeout(200)
    film.shoot(2.5)


def main() -> None:
    with tempfile.TemporaryDirectory() as place, sync_playwright() as driver:
        browser = driver.chromium.launch(executable_path=CHROMIUM, args=FLAGS)
        with studio(Path(place), "target=bowl") as server:
            page = Page(browser_page(browser, viewport=SIZE), server.address)
            page.is_open()
            film = Film(page.tab)
            design(page, film)
            assert page.errors == [], page.errors
            film.save(Path(sys.argv[1]))
        browser.close()


if __name__ == "__main__":
    main()
