"""The page in Chromium, by clicks and keys: known designs, refusals, partners, tabs, and what is on disk afterwards."""

from __future__ import annotations

import json
import os
import signal
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from origami_lab.cli import main
from tests.known_designs.game_moves import cube, pyramid
from tests.studio.driving import CHROMIUM, FIRST_SECONDS, Page, Server, browser_page, studio, wait_for
from tests.studio.random_clicks import random_clicks

pytest.importorskip("starlette", reason="needs the extra studio")
pytest.importorskip("playwright.sync_api")

pytestmark = [
    pytest.mark.slow,
    pytest.mark.skipif(CHROMIUM is None, reason="there is no Chromium to open the page in"),
]


def test_the_pyramid_and_the_cube_by_clicks(page: Page) -> None:
    """Their exact scores (docs/how-it-works.md)."""
    page.begin("pyramid")
    page.play(pyramid()[1][:-1])
    assert page.value() == -0.0799
    assert page.says("motion", "109.4")
    with page.answered():
        page.tab.keyboard.press("t")
    assert "ended" in page.text("next")
    page.tab.click("#leave")  # to the gallery: it is not saved, which the page asks about; nobody says yes
    assert page.tab.is_visible("#studio")
    page.tab.once("dialog", lambda dialog: dialog.accept())
    page.tab.click("#leave")
    page.begin("cube")
    page.play(cube()[1][:-1])
    assert page.value() == -0.0023
    assert (page.text("fact-panels"), page.text("fact-creases")) == ("23", "30")


def test_an_illegal_place_is_refused_with_its_reason(page: Page) -> None:
    page.begin("cube")
    page.click((1, 1))  # any image of a leaf will do
    before = page.state()
    assert before["phase"] == "first"
    for at, says in (((0, 0), "outside of the sheet"), ((-1, 4), "max_crease_length = 2"), ((-1, 2), None)):
        page.point(at)
        if says is not None:
            page.says("tip", says)
            page.click(at)
            assert says in page.text("status")
            assert page.state()["children"] == before["children"]
        else:
            wait_for(lambda: page.tab.is_hidden("#tip"))
    page.tab.keyboard.press("Escape")
    wait_for(lambda: page.state()["phase"] == "leaf")


def test_undo_to_the_start_and_redo_to_the_end_by_keys(page: Page) -> None:
    def shown() -> Any:
        return page.tab.evaluate("[...document.querySelectorAll('.sheet *, .lit *')].map((e) => e.outerHTML).join('')")

    page.begin("cube")
    page.play(cube()[1][:-1])
    seen = [(shown(), page.text("facts"))]
    for _ in range(3):
        with page.answered():
            page.tab.keyboard.press("u")
        page.tab.mouse.move(5, 5)
        seen.append((shown(), page.text("facts")))
    for k in (2, 1, 0):
        with page.answered():
            page.tab.keyboard.press("Control+Shift+Z")
        assert page.text("facts") == seen[k][1]
        assert len(shown()) > 0
    assert page.tab.is_disabled("#redo")
    assert page.value() == -0.0023


def test_keys_alone_play_and_tools_edit(page: Page) -> None:
    page.begin("cube")
    page.tab.focus("#board")
    for key in ("ArrowLeft", "ArrowUp", "Enter"):  # from the middle to the leaf (−1, 1)
        page.tab.keyboard.press(key)
    wait_for(lambda: page.state()["phase"] == "first")
    for key in ("ArrowUp", "ArrowUp", "Enter"):
        page.tab.keyboard.press(key)
    wait_for(lambda: page.state()["children"] == [[-1, 3]])
    page.click((-3, 1))
    page.click((-2, 2))
    assert page.value() == -1.0002
    page.use("move")
    page.point((-2, 2))
    page.tab.mouse.down()
    page.tab.mouse.move(*page.where((-3, 3)))
    with page.answered():
        page.tab.mouse.up()
    assert "no longer legal" in page.text("status")  # it is longer than max_crease_length
    assert page.state()["vertices"] == 4
    page.press("undo")
    page.use("cut")
    page.click((1, -1))
    assert "1 move cut off" in page.text("status")
    page.press("undo")
    assert page.value() == -1.0002


def test_the_slider_folds_the_sheet_and_the_page_is_usable_by_touch(browser: Any, gallery: Server) -> None:
    tab = browser_page(browser, viewport={"width": 390, "height": 800}, has_touch=True, color_scheme="dark")
    page = Page(tab, gallery.address)
    tab.tap("[data-open=cube]")
    page.is_open()
    for at in ((-1, 1), (-1, 3), (-3, 1), (-2, 2)):
        with page.answered():
            tab.touchscreen.tap(*page.where(at))
    assert page.value() == -1.0002
    tab.select_option("#budget", "20000")
    tab.tap("[data-task=suggest]")
    wait_for(lambda: tab.locator("#proposals button").count() > 0, FIRST_SECONDS)
    tab.tap("#proposals li:last-child button")
    with page.answered():
        tab.tap("#take")
    assert page.state()["undo"] == 3
    with page.answered():
        tab.tap("#undo")
    for degrees, says in (("0", "0.0°"), ("45", "45.0°"), ("170", "90.0°")):  # no further than it folds
        tab.evaluate(f"slider.value = {degrees}; slider.dispatchEvent(new Event('input'))")
        assert page.text("angle") == says
    assert tab.evaluate("document.documentElement.scrollWidth") <= 390
    assert page.errors == []
    tab.context.close()


@pytest.fixture(scope="module")
def designed(browser: Any, tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A bowl that was improved, stopped, taken and saved; the server was killed afterwards."""
    folder = tmp_path_factory.mktemp("bowl")
    with studio(folder, "target=bowl") as server:
        tab = browser_page(browser)
        page = Page(tab, server.address)
        page.is_open()
        page.click((2, 2))
        tab.select_option("#budget", "5000000")
        tab.click("[data-task=improve]")
        wait_for(lambda: "improve: return" in page.text("besideTitle"), FIRST_SECONDS)
        first = page.value()
        page.point((-3, 3))  # the page answers meanwhile
        tab.click("#stop")
        wait_for(lambda: tab.is_hidden("#stop"))
        page.press("take")
        better = page.value()
        assert better > first
        assert not list(folder.glob("out/*"))
        tab.click("#save")
        page.says("status", "saved in")
        wait_for(lambda: page.text("save") == "Save")
        assert page.errors == []
        os.kill(server.process.pid, signal.SIGKILL)
        wait_for(lambda: tab.is_visible("#over"))
        assert "ended" in page.text("over")
        tab.context.close()
    (folder / "value.txt").write_text(str(better), encoding="utf-8")
    return folder


def test_improve_stop_take_save_and_verify(designed: Path) -> None:
    [run] = (designed / "out").iterdir()
    assert run.name == "bowl-1"
    assert main(["verify", str(run / "seed=0/best.fold")]) in (0, 3)  # not refuted
    shown = float((designed / "value.txt").read_text())
    assert json.loads((run / "summary.json").read_text())["best"]["return"] == pytest.approx(shown, abs=1e-4)
    history = json.loads((run / "seed=0/history.json").read_text())
    assert [entry["partner"] for entry in history if "partner" in entry] == ["improve"]
    assert [entry["step"] for entry in history if "step" in entry][-1] == "partner's design"


def test_what_was_saved_is_opened_again(designed: Path, browser: Any, tmp_path: Path) -> None:
    with studio(tmp_path, str(designed / "out/bowl-1/seed=0")) as server:
        tab = browser_page(browser)
        page = Page(tab, server.address)
        page.is_open()
        assert page.value() == float((designed / "value.txt").read_text())
        assert page.text("save") == "Save"
        page.press("undo")  # to an empty board
        page.press("redo")
        assert page.value() == float((designed / "value.txt").read_text())
        assert page.errors == []
        tab.context.close()


def test_two_tabs_have_a_design_each(browser: Any, gallery: Server) -> None:
    one, two = (Page(browser_page(browser), gallery.address) for _ in range(2))
    one.begin("cube")
    two.begin("pyramid")
    one.play(cube()[1][:2])
    two.play(pyramid()[1][:-1])
    assert (one.value(), two.value()) == (-1.0002, -0.0799)
    one.press("undo")
    assert (one.text("fact-panels"), two.value()) == ("1", -0.0799)
    for page in (one, two):
        assert page.errors == []
        page.tab.context.close()


@pytest.mark.parametrize("seed", range(3))
def test_random_clicks_and_keys(seed: int, browser: Any, gallery: Server) -> None:
    """More of them by `python -m benchmarks.studio --clicks 10`."""
    tab = browser_page(browser)
    page = Page(tab, gallery.address)
    page.begin(("pyramid", "bowl", "shelf")[seed])
    random_clicks(page, np.random.default_rng(seed), 200)
    with page.answered():  # it still plays
        page.tab.keyboard.press("u")
    assert page.errors == []
    assert "Traceback" not in gallery.log
    tab.context.close()
