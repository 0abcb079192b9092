"""What a design is in a notebook: a frame that needs nothing, and in headless Chromium shows sheet and pattern."""

from __future__ import annotations

import re
from html import escape, unescape
from pathlib import Path

import pytest

import origami_lab
from origami_lab.drawing.scene import TargetSurface
from origami_lab.drawing.viewer import viewer_page
from origami_lab.errors import InputError
from origami_lab.fold_format.writer import read_fold, write_fold
from tests.drawing.test_viewer import FRAMES, SIZE, cold, in_chromium, photograph, warm
from tests.known_designs import closed_forms as designs


def page_of(html: str) -> str:
    """The page inside the frame."""
    [page] = re.findall(r'srcdoc="([^"]*)"', html)
    return unescape(page)


def test_the_frame_holds_the_viewer(tmp_path: Path) -> None:
    design = designs.pyramid()
    write_fold(tmp_path / "a.fold", design)
    fold = read_fold(tmp_path / "a.fold")
    html = origami_lab.show(fold)._repr_html_()
    assert page_of(html) == viewer_page(fold)
    assert re.findall(r"<(/?\w+)", html) == ["iframe", "/iframe"]
    assert 'sandbox="allow-scripts"' in html  # and not allow-same-origin
    for source in (design, tmp_path / "a.fold"):
        assert origami_lab.show(source)._repr_html_() == html
    target = TargetSurface(*designs.pyramid_mesh())
    html = origami_lab.show(design, target, height=333)._repr_html_()
    assert page_of(html) == viewer_page(fold, target)
    assert "height:333px" in html
    with pytest.raises(InputError):
        origami_lab.show(tmp_path / "none.fold")


@in_chromium
@pytest.mark.slow
def test_it_shows_itself(tmp_path: Path) -> None:
    html = origami_lab.show(designs.pyramid(), height=SIZE[1] - 60)._repr_html_()
    html = html.replace(escape("</head>"), escape(f"<script>{FRAMES}</script></head>"))
    (tmp_path / "cell.html").write_text(f"<!doctype html><meta charset=utf-8><body>{html}", encoding="utf-8")
    half = SIZE[0] // 2
    picture = photograph(tmp_path / "cell.html", until=lambda seen: cold(seen)[60:-90, half:].mean() > 0.02)
    assert cold(picture)[60:-90, half:].mean() > 0.02  # the pyramid's outside is the back of the paper
    pattern = picture[60:-90, :half]
    red, blue = pattern[..., 0] - pattern[..., 2], pattern[..., 2] - pattern[..., 0]
    assert (red > 100).sum() + (blue > 100).sum() > 300  # its creases
    assert not warm(picture)[60:-90, :half].mean() > 0.02
