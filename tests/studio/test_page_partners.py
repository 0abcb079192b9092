"""Partners, measures and files on the page, by clicks: what is offered is taken or left, what is written is on disk."""

from __future__ import annotations

from io import BytesIO
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from origami_lab.cli import main
from origami_lab.game import Extend
from tests.known_designs.game_moves import cube, pyramid
from tests.studio.driving import CHROMIUM, FIRST_SECONDS, Page, Server, browser_page, wait_for

pytest.importorskip("starlette", reason="needs the extra studio")
pytest.importorskip("playwright.sync_api")

pytestmark = [
    pytest.mark.slow,
    pytest.mark.skipif(CHROMIUM is None, reason="there is no Chromium to open the page in"),
]
OPTIMUM = -0.0023
"""Of the cube (docs/how-it-works.md)."""


def ask(page: Page, task: str) -> None:
    """Have a partner work until it has ended."""
    page.tab.select_option("#budget", "20000")
    before = page.text("working")
    page.tab.click(f"[data-task={task}], #{task}")
    wait_for(lambda: page.text("working") != before, FIRST_SECONDS)
    wait_for(lambda: page.tab.is_hidden("#stop"), FIRST_SECONDS)


def ghosts(page: Page) -> int:
    """Creases of a proposal that are drawn on the board."""
    return int(page.tab.locator("#board .over line.ghost").count())


@pytest.fixture
def box(page: Page) -> Page:
    """The cube without its lid."""
    page.begin("cube")
    page.play(cube()[1][:2])
    assert page.value() == -1.0002
    return page


def test_suggestions_are_ghosts_with_their_value_and_one_is_taken(box: Page) -> None:
    ask(box, "suggest")
    texts = box.tab.locator("#proposals button").all_inner_texts()
    assert 1 <= len(texts) <= 5
    assert len(set(texts)) == len(texts)
    assert all("→ −" in text for text in texts)
    for number in range(len(texts)):
        box.tab.locator("#proposals button").nth(number).click()
        assert ghosts(box) > 0
        box.says("besideTitle", texts[number].partition(" →")[0])
    box.press("take")
    assert box.state()["undo"] == 3
    assert box.tab.is_hidden("#proposals button")
    assert box.tab.is_hidden("#beside")
    box.press("undo")
    assert box.value() == -1.0002


def test_what_finishes_it_is_left_or_taken(box: Page) -> None:
    ask(box, "finish")
    box.says("besideTitle", "finish: return")
    assert ghosts(box) > 0
    box.tab.click("#leaveIt")
    wait_for(lambda: box.tab.is_hidden("#beside"))
    assert ghosts(box) == 0
    assert (box.value(), box.state()["undo"]) == (-1.0002, 2)
    ask(box, "finish")
    box.press("take")
    assert box.value() == OPTIMUM
    ask(box, "improve")  # there is nothing better
    assert "nothing better was found" in box.text("working")
    assert box.tab.is_hidden("#beside")


def test_a_region_is_grown_anew(box: Page) -> None:
    ask_for_nothing = box.tab.locator("[data-task=repair]")
    with box.answered():
        ask_for_nothing.click()
    assert "select a region" in box.text("status")
    box.play([cube()[1][2], Extend((-3, 1), -1, (-2, 2), (-4, 1), (-3, 3))])  # a lid that does not fit
    worse = box.value()
    assert worse < OPTIMUM
    box.use("region")
    box.tab.mouse.click(*box.where((-3, 1)))
    assert "4 selected" in box.text("next")  # with its images
    ask(box, "repair")
    box.press("take")
    assert box.value() == OPTIMUM


def test_two_designs_side_by_side(box: Page) -> None:
    box.tab.click("#compare")
    box.says("besideTitle", "kept for comparison: return −1.0002")
    box.press("undo")
    assert box.value() == -2.0
    assert "−1.0002" in box.text("besideTitle")
    assert box.tab.locator("canvas").count() == 2
    sizes = [canvas.bounding_box() for canvas in box.tab.locator("canvas").all()]
    assert all(size is not None and size["width"] > 100 and size["height"] > 100 for size in sizes)
    box.tab.click("#compare")
    assert box.tab.is_hidden("#beside")


def red_pixels(page: Page) -> int:
    from PIL import Image

    page.tab.wait_for_timeout(200)  # a frame
    picture = np.asarray(Image.open(BytesIO(page.tab.locator("#sheet").screenshot())).convert("RGB")).astype(int)
    return int((picture[..., 0] > picture[..., 1:].max(axis=2) + 40).sum())


def test_where_panels_collide_is_on_the_slider_and_marked_on_both_sides(box: Page) -> None:
    box.says("motion", "folds to 90.0°, where panels first collide")
    assert box.tab.get_attribute("#zone", "data-ends") == "collides"
    assert float(box.tab.evaluate("zone.style.getPropertyValue('--reach')")) == pytest.approx(0.5, abs=0.001)
    marks = box.tab.locator("#board .meeting polygon, #board polygon.meeting")
    assert marks.count() == 0
    before = red_pixels(box)
    box.tab.click("#toEnd")
    assert marks.count() == 4  # the walls, beyond 90°
    assert red_pixels(box) > before + 500
    box.tab.click("#best")  # the same angle, chosen for its return
    assert marks.count() == 0
    assert red_pixels(box) < before + 500


def test_measures_and_a_certificate(box: Page) -> None:
    ask(box, "measure")
    figures = box.says("figures", "narrowest panel")
    for word in ("vertex −1.0002", "surface", "sampled", "smallest angle 45.0°", "target furthest away by 1.0"):
        assert word in figures
    assert box.tab.locator("#board .furthest").count() > 0
    ask(box, "certify")
    assert box.says("status", "certified: no panels cross")


def test_polish_simplify_and_export_write_beside_and_the_board_stays(page: Page, gallery: Server) -> None:
    page.begin("pyramid")
    page.play(pyramid()[1][:-1])
    before = page.value(), page.state()["revision"], page.state()["undo"]
    page.tab.click("[data-task=polish]")
    wait_for(lambda: "polished.fold" in page.text("working"), FIRST_SECONDS)
    [run] = [path for path in Path(gallery.folder / "out").iterdir() if path.name.startswith("pyramid")]
    ask(page, "simplify")
    assert "simplified.fold" in page.text("working")
    for name in ("polished.fold", "simplified.fold"):
        assert main(["verify", str(run / "seed=0" / name)]) in (0, 3)  # not refuted
    page.tab.select_option("#format", "svg")
    with page.tab.expect_download() as download:
        page.tab.click("#export")
    name = download.value.suggested_filename
    assert Path(download.value.path()).read_bytes() == (run / "seed=0" / name).read_bytes()
    assert name.endswith(".svg")
    page.says("status", name)
    assert page.text("save") == "Save"
    assert (page.value(), page.state()["revision"], page.state()["undo"]) == before


def test_it_warns_before_unsaved_work_is_left(browser: Any, gallery: Server) -> None:
    tab = browser_page(browser)
    page = Page(tab, gallery.address)
    page.begin("cube")
    asked: list[str] = []

    def hear(dialog: Any) -> None:
        asked.append(dialog.type)
        dialog.dismiss()

    tab.on("dialog", hear)
    page.play(cube()[1][:2])
    assert page.text("save") == "Save •"
    tab.close(run_before_unload=True)
    wait_for(lambda: (tab.wait_for_timeout(50), asked)[1])
    assert asked == ["beforeunload"]
    assert page.value() == -1.0002  # it is still there
    tab.click("#save")
    page.says("status", "saved in")
    wait_for(lambda: page.text("save") == "Save")
    assert page.errors == []
    with tab.expect_event("close"):
        tab.close(run_before_unload=True)
    assert asked == ["beforeunload"]
    tab.context.close()
