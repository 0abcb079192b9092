"""The pictures of the glossary: ``python -m tools.glossary`` in docs/ draws them into docs/images/glossary.

They are made by what draws a run's pictures, on designs that are played here move by move.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import replace
from pathlib import Path

import matplotlib as mpl
import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.patches import Polygon, Rectangle
from numpy.typing import NDArray
from PIL import Image, ImageDraw
from scipy.spatial import cKDTree

from origami_lab.drawing import TargetSurface
from origami_lab.drawing.folded_picture import Studio, font, sheet_of
from origami_lab.drawing.pattern_picture import pattern_figure
from origami_lab.fold_format import FoldFile, as_fold_file, read_fold
from origami_lab.game import Extend, Game, Move, Place, Source, Square, Terminate
from origami_lab.geometry import sample_triangles
from tools.gallery import target_of_design

ROOT = Path(__file__).parents[2]
FOLDER = ROOT / "docs" / "images" / "glossary"
SIDE = 520
TEAL, PURPLE, ORANGE = "#12876f", "#8e3fb0", "#c85a00"


def played(moves: Sequence[Move], symmetry: str = "none", title: str = "", **settings: object) -> FoldFile:
    """A design of a few moves on a board of 9 × 9 points."""
    game = Game(9, symmetry, Square(1), **settings)  # type: ignore[arg-type]
    states = game.replay_moves(moves)
    reach = game.sheet(states).reach
    fold = as_fold_file(game.design(game.finished_actions(states), reach - 1))
    return replace(fold, title=title)


def pattern(fold: FoldFile, mark: Callable[[Axes], None] | None = None, whole: bool = True) -> Image.Image:
    """The crease pattern on the whole board, with something marked."""
    figure = pattern_figure(fold, 2 * SIDE)
    axes = figure.axes[0]
    if whole:
        axes.set(xlim=(-4.5, 4.5), ylim=(-4.5, 4.5))
        for line in range(-4, 5):
            axes.plot([line, line], [-4, 4], color="#e8eaee", linewidth=0.8, zorder=0)
            axes.plot([-4, 4], [line, line], color="#e8eaee", linewidth=0.8, zorder=0)
    if mark is not None:
        mark(axes)
    return raster(figure)


def raster(figure: Figure) -> Image.Image:
    """A figure as a picture of half its size."""
    figure.canvas.draw()
    pixels = np.asarray(figure.canvas.buffer_rgba())  # type: ignore[attr-defined]
    return Image.fromarray(pixels[..., :3].copy()).reduce(2)


def said(axes: Axes, text: str, at: tuple[float, float], to: tuple[float, float], colour: str = "#15161c") -> None:
    """A word with an arrow to a place."""
    axes.annotate(
        text,
        to,
        at,
        fontsize=17,
        color=colour,
        ha="center",
        va="center",
        zorder=9,
        bbox={"facecolor": "white", "edgecolor": "none", "alpha": 0.85, "pad": 2},
        arrowprops={"arrowstyle": "->", "color": colour, "linewidth": 1.8, "shrinkB": 6},
    )


def folded(fold: FoldFile, coords: NDArray[np.float64], studio: Studio, words: str) -> Image.Image:
    """The folded sheet with a line below."""
    image = studio.picture(sheet_of(fold), coords)
    draw = ImageDraw.Draw(image)
    draw.text((image.width / 2, image.height - 8), words, (38, 40, 52), font(max(13, image.width // 22)), anchor="ms")
    return image


def beside(*pictures: Image.Image) -> Image.Image:
    """Pictures in a row."""
    row = Image.new("RGB", (sum(image.width for image in pictures), max(image.height for image in pictures)), "white")
    left = 0
    for image in pictures:
        row.paste(image, (left, 0))
        left += image.width
    return row


START: list[Move] = [Place(1, 1)]
FIRST = Extend((1, 1), 1, (3, 0), (0, 3), (3, 3))
PYRAMID: list[Move] = [Place(1, 1), Extend((-1, 1), -1, (0, 4), (-4, 0), (-2, 2)), Terminate()]
CUBE: list[Move] = [
    Place(1, 1),
    Extend((-1, 1), -1, (-1, 3), (-3, 1), (-2, 2)),
    Source((-3, 1), "end", 1),
    Extend((-3, 1), -1, (-2, 2), (-4, 1), (-3, 2)),
    Terminate(),
]


def extended(mode: int = 1, title: str = "") -> FoldFile:
    """The start square with one corner extended."""
    return played([Place(1, 1), replace(FIRST, mode=mode), Terminate()], title=title)


def board() -> Image.Image:
    """A start square on its board, one cell shaded."""

    def mark(axes: Axes) -> None:
        axes.add_patch(Rectangle((2, 2), 1, 1, facecolor="#ffd9a8", edgecolor=ORANGE, linewidth=2, zorder=2))
        said(axes, "a cell", (3.2, 0.9), (2.5, 2.0), ORANGE)
        x, y = np.meshgrid(np.arange(-4, 5), np.arange(-4, 5))
        axes.scatter(x, y, s=14, color="#8a8d96", zorder=1)
        said(axes, "a board point", (-2.4, -2.6), (-1.0, -3.0))

    return pattern(played(START, title="a board of 9 × 9 points"), mark)


def start() -> Image.Image:
    """The start square, whose four sides are the sources."""

    def mark(axes: Axes) -> None:
        said(axes, "a source: a driven crease", (-2.4, 3.9), (-0.5, 1.0), ORANGE)
        said(axes, "start panel", (2.9, -3.6), (0.2, -0.2))

    return pattern(played(PYRAMID, "xy", title="a start square: its sides are sources"), mark)


def leaf() -> Image.Image:
    """Leaves on the boundary, and one vertex that is none any more."""

    def mark(axes: Axes) -> None:
        leaves = np.array([(3, 0), (3, 3), (0, 3), (-1, 1), (-1, -1), (1, -1)])
        axes.scatter(leaves[:, 0], leaves[:, 1], s=260, facecolors="none", edgecolors=PURPLE, linewidths=2.4, zorder=8)
        said(axes, "leaves", (-2.6, 2.9), (-0.2, 3.0), PURPLE)
        said(axes, "extended: no leaf", (2.4, -2.4), (1, 1), TEAL)

    return pattern(extended(title="leaves: vertices that are not extended yet"), mark)


def extension() -> Image.Image:
    """The four actions of a move: a leaf with its mode, and its three children."""
    before = played(START, title="before: the leaf is chosen")

    def choose(axes: Axes) -> None:
        axes.scatter([1], [1], s=300, facecolors="none", edgecolors=TEAL, linewidths=2.6, zorder=8)
        said(axes, "1  leaf, mode", (2.6, 2.4), (1, 1), TEAL)

    def grown(axes: Axes) -> None:
        for name, point, at in (
            ("2  a", (3, 0), (3.6, -1.1)),
            ("3  b", (0, 3), (-1.3, 3.6)),
            ("4  c", (3, 3), (3.5, 3.9)),
        ):
            said(axes, name, at, point, TEAL)

    return beside(pattern(before, choose), pattern(extended(title="after: three children, four panels"), grown))


def mode() -> Image.Image:
    """One pattern, two ways to fold."""
    pictures = []
    for number in (1, -1):
        fold = extended(number)
        frame = fold.frames[min(3, len(fold.frames) - 1)]
        studio = Studio(frame.coords, None, SIDE)
        name = "M = +1: middle crease a valley" if number > 0 else "M = −1: middle crease a mountain"
        pictures.append(folded(fold, frame.coords, studio, name))
    return beside(*pictures)


def mountains() -> Image.Image:
    """Mountains, valleys and the boundary of a pyramid."""

    def mark(axes: Axes) -> None:
        axes.add_patch(
            Polygon([(-1, 1), (-2, 2), (0, 4)], facecolor="#ffd9a8", edgecolor=ORANGE, linewidth=2, zorder=2)
        )
        said(axes, "a panel", (-2.9, 3.4), (-1.1, 2.4), ORANGE)

    return pattern(played(PYRAMID, "xy", title="the pyramid's pattern"), mark)


def symmetry() -> Image.Image:
    """The quarter that is played, and its images."""

    def mark(axes: Axes) -> None:
        axes.add_patch(Rectangle((-4.5, 0), 4.5, 4.5, facecolor=TEAL, alpha=0.13, zorder=1))
        axes.axvline(0, color=TEAL, linestyle="dashdot", linewidth=1.6, zorder=6)
        axes.axhline(0, color=TEAL, linestyle="dashdot", linewidth=1.6, zorder=6)
        said(axes, "what is played", (-2.6, 3.9), (-2.9, 1.9), TEAL)

    return pattern(played(PYRAMID, "xy", title="symmetry xy: one quarter, three images"), mark)


def merge() -> Image.Image:
    """Two neighbours share a child."""

    def mark(axes: Axes) -> None:
        axes.scatter([-2], [2], s=320, facecolors="none", edgecolors=ORANGE, linewidths=2.8, zorder=8)
        said(axes, "merge: a child of two vertices", (-1.2, 3.9), (-2, 2), ORANGE)
        said(axes, "a later source", (-3.1, -2.9), (-3, 0), TEAL)

    return pattern(played(CUBE, "xy", title="the cube's pattern", max_crease_length=2), mark)


def reach() -> Image.Image:
    """The motion of the pyramid: six of ten driving angles are reached."""
    fold = played(PYRAMID, "xy")
    frames = sorted(fold.frames, key=lambda frame: float(frame.driving_angle or 0.0))
    studio = Studio(np.vstack([frame.coords for frame in frames]), None, 250)
    shown = [frames[k] for k in (0, 2, 4, 5)]
    words = [f"{np.degrees(frame.driving_angle or 0.0):.0f}°" for frame in shown]
    strip = beside(*(folded(fold, frame.coords, studio, text) for frame, text in zip(shown, words, strict=True)))
    scale = Image.new("RGB", (strip.width, 96), "white")
    draw = ImageDraw.Draw(scale)
    for k in range(10):
        left = 60 + k * (strip.width - 120) // 10
        box = (left, 30, left + (strip.width - 120) // 10 - 8, 58)
        draw.rectangle(box, fill="#12876f" if k < len(frames) else "#e8eaee", outline="#8a8d96")
        middle = (left + box[2]) / 2
        draw.text((middle, 76), f"{(k + 1) * 17.99:.0f}°", (38, 40, 52), font(15), anchor="mm")
    draw.text((60, 16), f"reach: {len(frames)} of 10 driving angles", (38, 40, 52), font(17, True), anchor="lm")
    whole = Image.new("RGB", (strip.width, strip.height + 96), "white")
    whole.paste(strip, (0, 0))
    whole.paste(scale, (0, strip.height))
    return whole


def worth() -> Image.Image:
    """A bowl in its target, and where the two are furthest apart."""
    file = ROOT / "results" / "paper" / "designs" / "bowl-dfts-seed4.fold"
    fold = read_fold(file)
    shape = target_of_design(file)
    assert shape is not None
    target = TargetSurface(shape.vertices, shape.faces)
    coords = fold.best.coords
    here, there, distance = furthest(coords[sheet_of(fold).triangles], target.vertices[target.faces])
    side = 2 * SIDE
    studio = Studio(coords, target, side, upright=fold.upright)
    image = studio.picture(sheet_of(fold), coords)
    draw = ImageDraw.Draw(image)
    (a, b), (c, d) = (studio.camera.project(np.stack([here, there]))[:, :2] / 2).tolist()
    for x, y in ((a, b), (c, d)):
        draw.ellipse((x - 9, y - 9, x + 9, y + 9), fill="#c85a00", outline="white", width=2)
    draw.line((a, b, c, d), fill="#c85a00", width=5)
    words = f"furthest apart: {distance:.2f} cells, so the return is −{distance:.2f}"
    draw.text((side / 2, side - 30), words, (38, 40, 52), font(30), anchor="ms")
    return image.reduce(2)


def furthest(
    sheet: NDArray[np.float64], target: NDArray[np.float64]
) -> tuple[NDArray[np.float64], NDArray[np.float64], float]:
    """The point of one surface that is furthest from the other, its nearest point there, and how far that is.

    Both are (T, 3, 3) triangles; of each 200,000 random points are looked at.
    """
    rng = np.random.default_rng(0)
    points = [np.asarray(sample_triangles(triangles, 200_000, rng)) for triangles in (sheet, target)]
    best = (np.zeros(3), np.zeros(3), -1.0)
    for one, other in (points, points[::-1]):
        distances, nearest = cKDTree(other).query(one)
        k = int(distances.argmax())
        if distances[k] > best[2]:
            best = (one[k], other[nearest[k]], float(distances[k]))
    return best


PICTURES: dict[str, Callable[[], Image.Image]] = {
    "board": board,
    "source": start,
    "leaf": leaf,
    "extension": extension,
    "mode": mode,
    "mountains": mountains,
    "symmetry": symmetry,
    "merge": merge,
    "reach": reach,
    "return": worth,
}


def main() -> None:
    """Draw all pictures."""
    mpl.use("Agg")
    FOLDER.mkdir(parents=True, exist_ok=True)
    for name, draw in PICTURES.items():
        image = draw().convert("RGB").quantize(128, dither=Image.Dither.NONE)
        image.save(FOLDER / f"{name}.png", optimize=True)


if __name__ == "__main__":
    main()
