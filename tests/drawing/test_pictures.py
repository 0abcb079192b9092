"""Pictures: the right size, not blank, showing what they must, the same bytes every time."""

from __future__ import annotations

import dataclasses
from pathlib import Path

import numpy as np
import pytest
import trimesh
from matplotlib.collections import LineCollection
from numpy.typing import NDArray
from PIL import Image

from origami_lab.drawing import TargetSurface, draw_folded, draw_motion, draw_pattern, folded_picture, read_target
from origami_lab.drawing.motion_gif import steps
from origami_lab.drawing.pattern_picture import pattern_figure
from origami_lab.errors import InputError
from origami_lab.fold_format.writer import FoldFile, read_fold, write_fold
from origami_lab.game.crease_pattern import CreasePattern
from tests.known_designs import closed_forms as designs

SIZE = 240


def on_disk(design: CreasePattern, folder: Path) -> FoldFile:
    write_fold(folder / "best.fold", design)
    return read_fold(folder / "best.fold")


def pixels(path: Path) -> NDArray[np.int64]:
    with Image.open(path) as image:
        return np.asarray(image.convert("RGB"), dtype=np.int64)


def like(image: NDArray[np.int64], colour: tuple[int, int, int], within: int = 30) -> NDArray[np.bool_]:
    """Pixels close to a colour."""
    return np.asarray(np.abs(image - np.array(colour)).max(axis=-1) <= within)


def hue(image: NDArray[np.int64], channel: int) -> NDArray[np.bool_]:
    """Pixels in which one channel clearly leads."""
    others = np.delete(image, channel, axis=-1).max(axis=-1)
    return np.asarray(image[..., channel] > others + 25)


def test_pattern(tmp_path: Path) -> None:
    fold = on_disk(designs.pyramid(), tmp_path)
    draw_pattern(fold, tmp_path / "pattern.png")
    image = pixels(tmp_path / "pattern.png")
    assert image.shape == (900, 900, 3)
    plain = image[60:800]  # without title and legend
    assert like(plain, (214, 40, 40)).sum() > 400  # mountains
    assert like(plain, (29, 95, 209)).sum() > 2000  # valleys, half of them driven and so thicker
    assert like(plain, (21, 22, 28)).sum() > 1500  # boundary
    assert like(plain, (198, 216, 248), 6).sum() > 3000  # the glow of the driven creases
    only_valley = dataclasses.replace(fold, assignments=tuple(a.replace("M", "F") for a in fold.assignments))
    draw_pattern(only_valley, tmp_path / "other.png")
    assert like(pixels(tmp_path / "other.png"), (214, 40, 40)).sum() == 0


@pytest.mark.parametrize("board", [9, [9, 7], [7, 9]])
def test_the_grid_ends_where_the_board_ends(board: int | list[int], tmp_path: Path) -> None:
    """The pyramid's sheet is eight cells wide, and the picture shows a little more than that."""
    fold = on_disk(dataclasses.replace(designs.pyramid(), metadata={"board": board}), tmp_path)
    [axes] = pattern_figure(fold).axes
    lines = [path for path in (c.get_segments() for c in axes.collections if isinstance(c, LineCollection)) if path]
    grid = np.array(next(segments for segments in lines if len(segments) == sum(sides(board))))
    upright = grid[grid[:, 0, 0] == grid[:, 1, 0]]
    for along, count in enumerate(sides(board)):
        assert (grid[..., along].min(), grid[..., along].max()) == (-(count - 1) / 2, (count - 1) / 2)
    assert len(upright) == sides(board)[0]


def sides(board: int | list[int]) -> list[int]:
    return [board, board] if isinstance(board, int) else board


def test_pattern_is_not_mirrored(tmp_path: Path) -> None:
    """The only mountain of this degree-4 vertex leaves at 110°, the valleys at 0°, 70° and 220°."""
    fold = on_disk(designs.degree_four(), tmp_path)
    draw_pattern(fold, tmp_path / "pattern.png")
    mountain = np.argwhere(like(pixels(tmp_path / "pattern.png")[60:800], (214, 40, 40)))
    valley = np.argwhere(like(pixels(tmp_path / "pattern.png")[60:800], (29, 95, 209)))
    assert mountain[:, 1].mean() < valley[:, 1].mean()  # left of them ...
    assert mountain[:, 0].mean() < valley[:, 0].mean()  # ... and above them


def test_folded_sides_and_target(tmp_path: Path) -> None:
    fold = on_disk(designs.single_valley(), tmp_path)
    draw_folded(fold, tmp_path / "plain.png", size=SIZE)
    plain = pixels(tmp_path / "plain.png")
    assert plain.shape == (SIZE, SIZE, 3)
    assert hue(plain, 0).mean() > 0.1  # the orange front
    draw_folded(
        fold,
        tmp_path / "with.png",
        TargetSurface(designs.bowl_mesh()[0] + np.array([0, 6, 0]), designs.bowl_mesh()[1]),
        size=SIZE,
    )
    both = pixels(tmp_path / "with.png")
    assert hue(both, 0).mean() > 0.005
    assert like(both, (160, 210, 190), 45).mean() > 0.05  # the green target beside it
    turned = on_disk(dataclasses.replace(designs.single_valley(), folded=mirrored(designs.single_valley())), tmp_path)
    draw_folded(turned, tmp_path / "back.png", size=SIZE)
    assert hue(pixels(tmp_path / "back.png"), 2).mean() > 0.1  # upside down: the blue back


def mirrored(design: CreasePattern) -> NDArray[np.float64]:
    """The folded forms turned over about the x axis."""
    return design.folded * np.array([1.0, -1.0, -1.0])


def test_target_veils_what_is_behind_it(tmp_path: Path) -> None:
    fold = on_disk(designs.single_valley(best=0), tmp_path)
    plate = np.array([(-1, -1, 0), (3, -1, 0), (3, 2, 0), (-1, 2, 0)], dtype=float)
    faces = np.array([(0, 1, 2), (0, 2, 3)])
    orange = {}
    for height in (-1.5, 1.5):
        target = TargetSurface(plate + np.array([0, 0, height]), faces)
        draw_folded(fold, tmp_path / "a.png", target, size=SIZE)
        image = pixels(tmp_path / "a.png")
        orange[height] = int(hue(image, 0).sum())
    assert 0 < orange[1.5] < 0.8 * orange[-1.5]  # in front it tints the paper, behind it does not


def test_depth_decides_not_order(tmp_path: Path) -> None:
    """Two crossing panels: each hides the other on one side, which sorting whole polygons cannot show."""
    one = np.array([(-1, -1, -1), (1, -1, 1), (1, 1, 1), (-1, 1, -1)], dtype=float)
    other = np.array([(-1, -1, 1), (1, -1, -1), (1, 1, -1), (-1, 1, 1)], dtype=float)
    studio = folded_picture.Studio(np.vstack([one, other]), None, SIZE)
    sheet = folded_picture.DrawnSheet(np.array([(0, 1, 2), (0, 2, 3), (4, 5, 6), (4, 6, 7)]), np.array([0, 0, 1, 1]))
    coords = np.vstack([one, other])
    picture = np.asarray(studio.picture(sheet, coords), dtype=np.int64)
    swapped = folded_picture.DrawnSheet(sheet.triangles[[2, 3, 0, 1]], sheet.panels[[2, 3, 0, 1]])
    assert np.array_equal(picture, np.asarray(studio.picture(swapped, coords), dtype=np.int64))
    shades = {tuple(colour) for colour in picture.reshape(-1, 3)[hue(picture, 0).ravel()][:, :1] // 24}
    assert len(shades) >= 2  # both fronts are seen


def test_motion(tmp_path: Path) -> None:
    fold = on_disk(designs.pyramid(), tmp_path)
    target = TargetSurface(*designs.pyramid_mesh())
    draw_motion(fold, tmp_path / "motion.gif", target, size=SIZE)
    assert (tmp_path / "motion.gif").stat().st_size < 1_500_000
    frames, durations = [], []
    with Image.open(tmp_path / "motion.gif") as gif:
        assert gif.info["loop"] == 0
        assert gif.n_frames == 12  # flat, five on the way, the best, five back
        for index in range(gif.n_frames):
            gif.seek(index)
            frames.append(np.asarray(gif.convert("RGB"), dtype=np.int64))
            durations.append(gif.info["duration"])
    assert durations == [700, 60, 60, 60, 60, 60, 1600, *[60] * 5]
    assert {frame.shape for frame in frames} == {(*frames[0].shape[:2], 3)}
    assert frames[0].shape[1] == SIZE
    for index in range(1, 6):
        assert np.array_equal(frames[index], frames[12 - index])
        assert (frames[index] != frames[index - 1]).any(axis=-1).mean() > 0.02
    assert all(tuple(frame[0, 0]) == (255, 255, 255) for frame in frames)


def test_motion_shows_stored_forms_only(tmp_path: Path) -> None:
    fold = on_disk(designs.pyramid(best=3), tmp_path)
    shown = steps(fold)
    assert np.array_equal(shown[0].coords[:, :2], fold.vertices)
    assert not shown[0].coords[:, 2].any()
    assert np.array_equal([frame.coords for frame in shown[1:]], designs.pyramid().folded[:4])


def test_the_same_bytes_every_time(tmp_path: Path) -> None:
    fold = on_disk(designs.degree_four(), tmp_path)
    target = TargetSurface(*designs.bowl_mesh(24, 6))
    for name in ("a", "b"):
        draw_pattern(fold, tmp_path / f"{name}_pattern.png", size=300)
        draw_folded(fold, tmp_path / f"{name}_folded.png", target, size=SIZE)
        draw_motion(fold, tmp_path / f"{name}_motion.gif", target, size=120)
    for picture in ("pattern.png", "folded.png", "motion.gif"):
        assert (tmp_path / f"a_{picture}").read_bytes() == (tmp_path / f"b_{picture}").read_bytes()


@pytest.mark.parametrize(("value", "said"), [(-1e-16, "return 0.0000"), (-0.12345, "return −0.1235")])
def test_a_return_that_is_rounding_is_0(value: float, said: str, tmp_path: Path) -> None:
    fold = on_disk(dataclasses.replace(designs.single_valley(), metadata={"return": value}), tmp_path)
    assert said in folded_picture.caption_lines(fold, fold.frames[0])[1]


def test_odd_titles_and_facts(tmp_path: Path) -> None:
    odd = {"title": "a $\\frac{1 $ b\n" * 40, "return": 10**400, "board": "25"}
    fold = on_disk(dataclasses.replace(designs.single_valley(), metadata=odd), tmp_path)
    draw_pattern(fold, tmp_path / "a.png", size=300)
    draw_folded(fold, tmp_path / "b.png", size=SIZE)


def test_a_file_without_frames_or_facts_is_drawn_flat(tmp_path: Path) -> None:
    fold = dataclasses.replace(
        on_disk(designs.single_valley(), tmp_path), frames=(), modes=None, driven=None, metadata={}, title=""
    )
    draw_pattern(fold, tmp_path / "a.png", size=300)
    draw_folded(fold, tmp_path / "b.png", size=SIZE)
    draw_motion(fold, tmp_path / "c.gif", size=120)
    assert hue(pixels(tmp_path / "b.png"), 0).mean() > 0.1


def test_read_target(tmp_path: Path) -> None:
    vertices, faces = designs.pyramid_mesh()
    trimesh.Trimesh(vertices, faces, process=False).export(tmp_path / "target.ply")
    target = read_target(tmp_path / "target.ply")
    assert np.allclose(target.vertices, vertices, atol=1e-6)
    assert np.array_equal(target.faces, faces)
    (tmp_path / "empty.ply").write_text("")
    (tmp_path / "text.stl").write_text("hello")
    for name in ("missing.ply", "empty.ply", "text.stl"):
        with pytest.raises(InputError, match=name):
            read_target(tmp_path / name)
