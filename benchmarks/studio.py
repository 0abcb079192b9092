"""How fluent is the studio? ``python -m benchmarks.studio [--out benchmarks/studio.md] [--clicks N]``

The page in Chromium, driven as the tests drive it: from its address to a board that can be played on, a place that is
pointed at to its answer, a frame of the slider's script. ``--clicks`` has N runs of 200 random clicks and keys instead.
"""

from __future__ import annotations

import argparse
import math
import os
import platform
import statistics
import tempfile
import time
from pathlib import Path

import numpy as np
from playwright.sync_api import Browser, sync_playwright

from benchmarks import write_report
from origami_lab.fold_format import write_fold
from origami_lab.studio.design_board import DesignBoard, Refused
from origami_lab.studio.opening import open_settings
from tests.studio.driving import CHROMIUM, FLAGS, Page, browser_page, studio
from tests.studio.random_clicks import random_clicks

VERTICES = 150
POINTS = 16
FRAMES = 40
"""Places that are pointed at, and frames of the slider."""
OPENINGS = 2
TASKS = ("pyramid", "cube", "bowl", "bucket", "shelf", "table", "chair", "face", "packaging", "bowl")

_POINT = """(at) => new Promise((done) => {
  const [x, y] = studioWhere(at), svg = document.querySelector('#board svg.over'), began = performance.now();
  const seen = new MutationObserver(() => { if (document.querySelector('.cursor.legal, .cursor.illegal')) {
    seen.disconnect(); done(performance.now() - began); } });
  seen.observe(svg, {subtree: true, childList: true, attributes: true});
  svg.dispatchEvent(new PointerEvent('pointermove', {clientX: x, clientY: y, bubbles: true}));
})"""
_FRAME = """(part) => { const slider = document.getElementById('slider'), began = performance.now();
  slider.value = part * 170; slider.dispatchEvent(new Event('input')); return performance.now() - began; }"""


def big_design(folder: Path) -> list[str]:
    """A random design of at least so many vertices, as words for the command."""
    settings = ["target=bowl", "symmetry=none", "max_crease_length=2.9", "start.size=2"]
    opened = open_settings(settings)
    game, rng = opened.game, np.random.default_rng(0)
    board = DesignBoard(game, opened.objective)
    board.place_start(0, 1)
    while int(board.states["n_vertices"][0]) < VERTICES:
        try:
            leaves = [at for at, reason in board.leaves() if reason is None]
            board.select(leaves[int(rng.integers(len(leaves)))], int(rng.choice([-1, 1])))
            while board.phase > 1:
                places = board.places()
                if not places:
                    break
                board.place(places[int(rng.integers(len(places)))][0])
        except Refused:
            pass
        board.back_to_step()
    angle = int(board.states["reach"][0]) - 1
    facts = {"task": "bowl", "board": game.board_fact, "driving_angle": math.degrees(game.angles[angle])}
    write_fold(folder / "big.fold", game.design(board.actions, angle, facts))
    return [str(folder / "big.fold"), *settings]


def opening(browser: Browser, folder: Path) -> list[str]:
    """From the command to the address, and from the address to a board."""
    rows = []
    began = time.perf_counter()
    with studio(folder, "target=bowl") as server:
        command = time.perf_counter() - began
        seconds = []
        for _ in range(OPENINGS):
            tab = browser_page(browser)
            began = time.perf_counter()
            Page(tab, server.address).is_open()
            seconds.append(time.perf_counter() - began)
            tab.context.close()
    print(f"command {command:.1f} s", flush=True)
    rows.append(f"| `origami-lab studio target=bowl`, until its address is printed | {command:.1f} s | |")
    rows.append(
        f"| its address in a browser, until the board can be played on | {statistics.median(seconds):.2f} s | 3 s |"
    )
    with studio(folder, name="gallery") as server:
        tab = browser_page(browser)
        page = Page(tab, server.address)
        tab.wait_for_selector("[data-open]")
        time.sleep(5)  # it loads what it needs meanwhile, as somebody reads the gallery
        began = time.perf_counter()
        page.begin("bowl")
        chosen = time.perf_counter() - began
        tab.context.close()
    rows.append(f"| a task of the gallery, until the board can be played on | {chosen:.2f} s | 3 s |")
    return rows


def pointing(browser: Browser, folder: Path) -> list[str]:
    """Answers to places, and frames, with many vertices on the board."""
    with studio(folder, *big_design(folder), name="big") as server:
        tab = browser_page(browser, viewport={"width": 1400, "height": 900})
        page = Page(tab, server.address)
        page.is_open()
        time.sleep(6)  # the partner's process has loaded
        vertices = page.state()["vertices"]
        found: dict[str, list[float]] = {"leaf": [], "first": [], "second": [], "third": []}
        rng = np.random.default_rng(0)
        tries = 0
        while min(map(len, found.values())) < POINTS // 4 and tries < 60 * POINTS:
            tries += 1
            state = page.state()
            offered = tab.evaluate("studioOffered()")
            phase = state["phase"]
            if not offered or (phase == "leaf" and state["ended"]):
                page.press("back" if state["selected"] else "undo")
                continue
            at = offered[int(rng.integers(len(offered)))]
            tab.evaluate("document.querySelector('#board svg.over').dispatchEvent(new PointerEvent('pointerleave'))")
            found[phase].append(tab.evaluate(_POINT, at))
            if phase == "third":  # and back, so that the board stays as it is
                page.press("back")
                page.press("back")
                if page.state()["selected"]:
                    page.press("back")
            else:
                page.turn(int(rng.choice([-1, 1])))
                page.click((at[0], at[1]))
        # the fold at rest: no places and no ghost
        while page.state()["selected"]:
            page.press("back")
        print({phase: len(times) for phase, times in found.items()}, flush=True)
        frames = [tab.evaluate(_FRAME, part) for part in np.linspace(0, 1, FRAMES)]
        errors = page.errors
        tab.context.close()
    assert not errors, errors
    names = {
        "leaf": "a leaf",
        "first": "a first crease",
        "second": "a second one",
        "third": "a middle one, with its fold",
    }
    rows = [
        f"| pointing at {names[phase]}, {vertices} vertices: median of {len(times)} (largest) "
        f"| {statistics.median(times):.1f} ms ({max(times):.0f}) | 50 ms |"
        for phase, times in found.items()
        if times
    ]
    frame = f"{statistics.median(frames):.1f} ms ({max(frames):.0f})"
    return [*rows, f"| a frame of the slider, {vertices} vertices: median of {FRAMES} (largest) | {frame} | 15 ms |"]


def clicks(browser: Browser, folder: Path, runs: int) -> None:
    """Runs of random clicks; what is said on the console or by the server is an error."""
    with studio(folder) as server:
        for seed in range(runs):
            page = Page(browser_page(browser), server.address)
            page.begin(TASKS[seed % len(TASKS)])
            random_clicks(page, np.random.default_rng(seed), 200)
            assert page.errors == [], (seed, page.errors)
            assert "Traceback" not in server.log, server.log
            page.tab.context.close()
            print(f"{TASKS[seed % len(TASKS)]}, seed {seed}: 200 clicks and keys, no error", flush=True)


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--out", type=Path)
    parser.add_argument("--clicks", type=int)
    given = parser.parse_args()
    with tempfile.TemporaryDirectory() as place, sync_playwright() as driver:
        browser = driver.chromium.launch(executable_path=CHROMIUM, args=FLAGS)
        folder = Path(place)
        if given.clicks:
            clicks(browser, folder, given.clicks)
            return
        rows = [*opening(browser, folder), *pointing(browser, folder)]
        load = os.getloadavg()[0]
        browser.close()
    machine = f"{platform.machine()}, {os.cpu_count()} cores with a load of {load:.1f}"
    lines = [
        "# The studio's page",
        "",
        "`python -m benchmarks.studio --out benchmarks/studio.md`; with `--clicks 10` it has ten runs of 200 random",
        "clicks and keys instead, which must leave no error in the console and none on the server.",
        "",
        f"{machine}, Chromium with a software renderer; kernels compiled and cached.",
        "",
        "| | measured | asked for |",
        "|---|---|---|",
        *rows,
    ]
    print("\n".join(lines))
    write_report(lines, given.out)


if __name__ == "__main__":
    main()
