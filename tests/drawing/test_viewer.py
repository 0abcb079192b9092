"""The viewer's page: nothing to load, and in headless Chromium it shows what the design does."""

from __future__ import annotations

import base64
import dataclasses
import json
import re
import shutil
import subprocess
from collections.abc import Callable
from html import escape
from pathlib import Path

import numpy as np
import pytest
from PIL import Image

from origami_lab.drawing.scene import TargetSurface
from origami_lab.drawing.viewer import viewer_page, viewer_script, write_viewer
from origami_lab.fold_format.writer import as_fold_file
from tests.known_designs import closed_forms as designs

CHROMIUM = next(filter(None, map(shutil.which, ("chromium", "chromium-browser", "google-chrome"))), None)
in_chromium = pytest.mark.skipif(CHROMIUM is None, reason="there is no Chromium to open the page in")
FLAGS = [
    *("--headless", "--no-sandbox", "--disable-gpu", "--disable-quic", "--no-first-run", "--hide-scrollbars"),
    *("--disable-background-networking", "--disable-component-update", "--disable-sync", "--enable-logging=stderr"),
    *("--use-gl=angle", "--use-angle=swiftshader", "--enable-unsafe-swiftshader", "--virtual-time-budget=3000"),
]
SIZE = 1000, 640
FRAMES = """requestAnimationFrame = (draw) => setTimeout(() => draw(performance.now()), 16);
cancelAnimationFrame = clearTimeout;"""
"""Without a window Chromium's virtual time goes on, but hardly any frame is drawn."""


def page(path: Path, script: str = "", target: TargetSurface | None = None) -> Path:
    """The pyramid's page, with a script of the test's at its end."""
    write_viewer(as_fold_file(designs.pyramid()), path, target)
    text = path.read_text()
    text = text.replace("</head>", f"<script>{FRAMES}</script></head>")
    path.write_text(text.replace("</body>", f"<script>{script}</script></body>"))
    return path


def visit(path: Path, *flags: str) -> str:
    """What Chromium prints; whatever is said on the console but for remarks of the software renderer is an error."""
    assert CHROMIUM is not None
    profile = path.with_suffix(".profile")
    command = [CHROMIUM, *FLAGS, f"--user-data-dir={profile}", f"--window-size={SIZE[0]},{SIZE[1]}", *flags]
    done = subprocess.run([*command, path.as_uri()], capture_output=True, text=True, timeout=120, check=False)
    shutil.rmtree(profile, ignore_errors=True)
    said = [line for line in done.stderr.splitlines() if "CONSOLE" in line and "GL Driver Message" not in line]
    assert not said
    return done.stdout


def anything(pixels: np.ndarray) -> bool:
    """Whether there is more than one colour."""
    return bool((pixels != pixels[0, 0]).any())


def photograph(path: Path, *flags: str, until: Callable[[np.ndarray], bool] = anything) -> np.ndarray:
    """(H, W, 3) what the window shows, taken again until it shows what is waited for, or for good."""
    picture = path.with_suffix(".png")
    for _ in range(12):  # on a busy machine it is taken before a frame within the page is drawn at all
        visit(path, f"--screenshot={picture}", *flags)
        with Image.open(picture) as image:
            pixels = np.array(image.convert("RGB")).astype(int)
        if until(pixels):
            break
    return pixels


def warm(picture: np.ndarray) -> np.ndarray:
    """(H, W) where the front of the paper is seen, whatever the light: orange."""
    red, green, blue = np.moveaxis(picture, -1, 0)
    return (red > 150) & (red - blue > 90) & (green - blue > 30) & (red > green)


def cold(picture: np.ndarray) -> np.ndarray:
    """(H, W) where its back is seen: a greyish blue."""
    red, green, blue = np.moveaxis(picture, -1, 0)
    return (blue - red > 40) & (blue > green) & (green > red) & (red > 50)


def test_the_page_loads_nothing_and_holds_the_design(tmp_path: Path) -> None:
    design = designs.degree_four()
    vertices, faces = designs.pyramid_mesh()
    write_viewer(as_fold_file(design), tmp_path / "a.html", TargetSurface(vertices, faces))
    text = (tmp_path / "a.html").read_text()
    assert len(text.encode()) < 1_500_000
    before, _, rest = text.partition('<script id="design" type="application/json">')
    document, _, after = rest.partition("</script>")
    frame = before + after[: after.index("<script>")]
    assert not re.search(r"\bsrc=|@import|url\(", frame)
    assert re.findall(r'href="([^"]*)"', frame) == ["data:,"]
    assert "The MIT License" in after
    assert "three.js authors" in after
    assert not re.search(r"\bimport\(|fetch\([\"']http|importScripts", after)
    data = json.loads(document)
    assert np.allclose(data["vertices"], design.vertices, atol=1e-5)
    assert data["edges"] == design.edges.tolist()
    assert data["modes"] == design.modes.tolist()
    assert data["best"] == pytest.approx(np.degrees(design.driving_angles[design.best]), abs=1e-5)
    assert [state["at"] for state in data["states"]] == pytest.approx([0, *np.degrees(design.driving_angles)], abs=1e-5)
    for state, points, angles in zip(data["states"][1:], design.folded, design.fold_angles, strict=True):
        assert np.allclose(np.reshape(state["coords"], (-1, 3)), points, atol=1e-5)
        assert np.allclose(np.radians(state["folds"]), np.where(design.boundary, 0, angles), atol=1e-4)
    for panel, sides in zip(design.panels, data["sides"], strict=True):
        assert {v for e in sides for v in design.edges[e]} == set(panel)
        assert len(sides) == len(panel)
    packed = {key: base64.b64decode(value) for key, value in data["target"].items()}
    corners = np.frombuffer(packed["vertices"], "<f4").reshape(-1, 3)[np.frombuffer(packed["faces"], "<u4")]
    assert np.allclose(corners.reshape(-1, 3, 3), vertices[faces], atol=1e-6)


def test_a_title_is_only_text(tmp_path: Path) -> None:
    title = "</script><script>alert(1)</script> @STYLE@ <!-- & é"
    fold = dataclasses.replace(as_fold_file(designs.single_valley()), title=title, metadata={"return": "<b>"})
    write_viewer(fold, tmp_path / "a.html")
    text = (tmp_path / "a.html").read_text()
    assert text.count("alert(1)") == 2  # in the head and in the heading
    assert text.count(escape(title)) == 2
    assert text.count("<script") == 2


def test_a_huge_target_is_left_out(tmp_path: Path) -> None:
    faces = np.tile(np.arange(3), (50_001, 1))
    target = TargetSurface(np.eye(3), faces)
    write_viewer(as_fold_file(designs.single_valley()), tmp_path / "a.html", target)
    assert '"target":null' in (tmp_path / "a.html").read_text()


@in_chromium
@pytest.mark.slow
def test_the_slider_moves_the_sheet(tmp_path: Path) -> None:
    move = "const s = document.getElementById('slider'); s.value = {}; s.dispatchEvent(new Event('input'));"
    best = photograph(page(tmp_path / "best.html"))
    flat = photograph(page(tmp_path / "flat.html", move.format(0)))
    address = page(tmp_path / "address.html", "location.hash = 'angle=0';")
    also_flat = photograph(address)
    half = int(0.42 * SIZE[0])  # the pattern is on the left
    assert warm(flat)[:, half:].mean() > 0.05
    assert warm(flat)[60:-90, half:].mean() > 10 * cold(flat)[60:-90, half:].mean()  # the front, and blue creases
    assert cold(best)[60:-90, half:].mean() > 10 * warm(best)[60:-90, half:].mean()  # the pyramid's outside is the back
    moved = np.abs(best - flat).max(axis=2) > 30
    assert moved[60:-90, half:].mean() > 0.03
    assert moved[60:-90, : half - 30].mean() < 0.001  # the pattern stays
    assert (np.abs(also_flat - flat).max(axis=2) > 30).mean() < 0.001


@in_chromium
@pytest.mark.slow
def test_what_it_says(tmp_path: Path) -> None:
    script = """
    const said = [], get = (id) => document.getElementById(id);
    const note = () => said.push(get('angle').textContent + ' | ' + get('said').textContent);
    const point = (kind, index) => document.querySelectorAll(`[data-kind=${kind}][data-index="${index}"]`).forEach(
      (one) => one.dispatchEvent(new PointerEvent('pointermove', {bubbles: true})));
    note();
    get('slider').value = 90; get('slider').dispatchEvent(new Event('input'));
    point('vertex', 0); note(); point('vertex', 4); note(); point('edge', EDGE); note(); point('panel', 0); note();
    const canvas = document.querySelector('#sheet canvas'), box = canvas.getBoundingClientRect();
    for (let x = 0.02; x < 1; x += 0.04) for (let y = 0.02; y < 1; y += 0.04) {
      const at = {clientX: box.left + x * box.width, clientY: box.top + y * box.height, pointerType: 'mouse'};
      canvas.dispatchEvent(new PointerEvent('pointermove', at));
      said.push('3d ' + get('said').textContent);
    }
    get('play').click();
    setTimeout(note, 900);
    setTimeout(() => { note(); get('play').click(); note(); }, 2000);
    setTimeout(() => { note(); const made = document.createElement('pre'); made.id = 'notes';
      made.textContent = JSON.stringify(said); document.body.append(made); }, 2400);
    """
    design = designs.pyramid()
    edge = next(k for k, (u, v) in enumerate(design.edges) if (u, v) == (0, 1))
    text = visit(page(tmp_path / "a.html", script.replace("EDGE", str(edge))), "--dump-dom")
    notes = json.loads(re.findall(r'<pre id="notes">(.*?)</pre>', text, re.DOTALL)[0])
    degrees = np.degrees(design.driving_angles)
    first, *about, top, down, stopped, after = [note for note in notes if not note.startswith("3d ")]
    assert first.startswith(f"{degrees[5]:.1f}° | Drag to turn")
    # the states are 18° apart: the nearest to 90° is shown, as it is
    at = f"{degrees[4]:.1f}° | "
    assert about == [
        at + "vertex 0 at (1, 1) · rigid body mode M = −1",
        at + "vertex 4 at (0, 4) · a leaf, not extended",
        at + f"valley driven crease 0–1 · fold angle {degrees[4]:.1f}°",
        at + "panel 0 · fold angles at its creases " + ", ".join([f"{degrees[4]:.1f}°"] * 4),
    ]
    found = {note.split()[1] for note in notes if note.startswith("3d ")}
    assert {"panel", "Drag"} <= found <= {"panel", "Drag", "vertex", "valley", "mountain", "boundary"}
    # it plays on, up to the best state, where it stays a moment, and down again until it is stopped
    assert top.startswith(f"{degrees[5]:.1f}° | ")
    assert down.split("°")[0] in {f"{angle:.1f}" for angle in degrees[2:5]}
    assert down == stopped == after


@in_chromium
@pytest.mark.slow
def test_on_a_phone_in_the_frame_of_an_artifact_pane(tmp_path: Path) -> None:
    """MLflow shows pages in a frame of another origin, which may run scripts and nothing else."""
    inner = page(tmp_path / "inner.html").read_text()
    frame = f'<iframe sandbox="allow-scripts" width="360" height="620" style="border:0" srcdoc="{escape(inner)}">'
    (tmp_path / "a.html").write_text(f'<!doctype html><body style="margin:0">{frame}</iframe>')
    picture = photograph(tmp_path / "a.html")
    assert (picture[:, 362:] == 255).all()  # nothing beside the frame
    sheet, pattern = picture[90:300, :360], picture[330:520, :360]
    assert cold(sheet).mean() > 0.02  # the sheet above
    paper = (np.abs(pattern - [253, 246, 233]).max(axis=2) < 3).mean()
    assert paper > 0.05  # and the pattern below


@in_chromium
@pytest.mark.slow
def test_pages_that_share_the_script(tmp_path: Path) -> None:
    (tmp_path / "viewer.js").write_text(viewer_script(), encoding="utf-8")
    fold = as_fold_file(designs.pyramid())
    text = viewer_page(fold, script="viewer.js")
    assert len(text) < 40_000
    file = tmp_path / "a.html"
    file.write_text(text.replace("</head>", f"<script>{FRAMES}</script></head>"), encoding="utf-8")
    half = int(0.42 * SIZE[0])
    seen = photograph(file, until=lambda picture: cold(picture)[60:-90, half:].mean() > 0.02)
    assert cold(seen)[60:-90, half:].mean() > 0.02
