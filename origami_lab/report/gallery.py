"""The designs: the best folded shape of each searcher and task, the crease pattern and the motion of each task's best.

All is drawn from the files of the trials; what a folder lacks is named in a note.
"""

from __future__ import annotations

import textwrap
from collections.abc import Iterable, Mapping, Sequence
from contextlib import suppress
from dataclasses import dataclass

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from numpy.typing import NDArray
from PIL import Image

from origami_lab.drawing import TargetSurface, read_target
from origami_lab.drawing.figures import HIGHLIGHT, INK, QUIET, new_figure
from origami_lab.drawing.folded_picture import Studio, sheet_of
from origami_lab.drawing.motion_gif import steps
from origami_lab.errors import InputError
from origami_lab.fold_format.fold_file import FoldFile, FoldFrame
from origami_lab.fold_format.writer import read_fold
from origami_lab.report.run_groups import Groups, Heading
from origami_lab.report.run_reader import Note, Trial
from origami_lab.report.table_formats import number
from origami_lab.runs.run_folder import RunFolder

SIZE = 300
"""Pixels, the side of a picture."""
MOTION_STEPS = 5
ONLY_WITH_ALL_FILES = ("motion.fold",)
"""Files that are read here and ``files=designs`` does not write."""
_SAME = 1e-9
"""Returns that differ by less are equally good."""


@dataclass(frozen=True, eq=False)
class Shape:
    """The best design of one searcher on one task."""

    trial: Trial
    fold: FoldFile
    image: Image.Image
    best: bool
    """Whether no other searcher's is better on that task."""

    @property
    def caption(self) -> str:
        return f"{number(self.trial.value, 4)}, seed {self.trial.seed}"

    @property
    def polished(self) -> str:
        """The return of the polished design, as a text; empty if there is none."""
        value = self.trial.row.polished_return
        return "" if value is None else f"polished {number(value, 4)}"


@dataclass(frozen=True, eq=False)
class DrawnMotion:
    """The folding motion of a task's best design."""

    row: Heading
    trial: Trial
    images: tuple[Image.Image, ...]
    angles: tuple[float | None, ...]
    """Driving angles in degrees."""

    @property
    def steps(self) -> list[tuple[Image.Image, float | None]]:
        """Each image with its angle."""
        return list(zip(self.images, self.angles, strict=True))


def draw_shapes(groups: Groups, notes: list[Note]) -> dict[tuple[Heading, Heading], Shape]:
    """The best design of each cell, by row and column; those of a task from one place in the same scale."""
    found: dict[tuple[Heading, Heading], Shape] = {}
    for column in groups.columns:
        designs = {}
        for row, group in groups.column(column):
            if group.best is not None:
                fold = _read(group.best, ("best.fold", "motion.fold"), notes, "not in the gallery")
                if fold is not None:
                    designs[row] = (group.best, fold)
        if not designs:
            continue
        top = max(trial.value for trial, _ in designs.values())
        points = np.vstack([_standing(fold, fold.best) for _, fold in designs.values()])
        target = read_target_of([trial for trial, _ in designs.values()], notes)
        if target is not None:  # it stands as the designs that are to fold into it
            upright = next(iter(designs.values()))[1].upright
            target = TargetSurface(target.vertices @ upright.T, target.faces)
        studio = Studio(points, target, SIZE, trim=True)
        for row, (trial, fold) in designs.items():
            image = studio.picture(sheet_of(fold), _standing(fold, fold.best))
            found[row, column] = Shape(trial, fold, image, trial.value >= top - _SAME)
    return found


def best_shape(
    groups: Groups, column: Heading, shapes: Mapping[tuple[Heading, Heading], Shape]
) -> tuple[Heading, Shape] | None:
    """A task's best design that is on disk, and its row."""
    known = [(row, shapes[row, column]) for row in groups.rows if (row, column) in shapes]
    return max(known, key=lambda pair: pair[1].trial.value, default=None)


def draw_motion(row: Heading, shape: Shape, notes: list[Note]) -> DrawnMotion:
    """From the flat sheet to the best angle, in pictures from one place; true folded forms, none interpolated."""
    fold = _read(shape.trial, ("motion.fold",), notes, "its motion is drawn in fewer steps") or shape.fold
    forms = steps(fold)
    chosen = sorted({round(index) for index in np.linspace(0, len(forms) - 1, MOTION_STEPS)})
    forms = tuple(forms[index] for index in chosen)
    target = read_target_of([shape.trial], [])
    studio = Studio(np.vstack([form.coords for form in forms]), target, SIZE, trim=True, upright=fold.upright)
    sheet = sheet_of(fold)
    angles = (form.driving_angle for form in forms)
    return DrawnMotion(
        row,
        shape.trial,
        tuple(studio.picture(sheet, form.coords) for form in forms),
        tuple(None if angle is None else float(np.degrees(angle)) for angle in angles),
    )


def _standing(fold: FoldFile, form: FoldFrame) -> NDArray[np.float64]:
    """(V, 3) the folded sheet as it is used, each design in its own way."""
    turned: NDArray[np.float64] = form.coords @ fold.upright.T
    return turned


def _read(trial: Trial, names: Iterable[str], notes: list[Note], without: str) -> FoldFile | None:
    """The first of the trial's files that can be read; a note says what is ``without`` it."""
    reasons = []
    for name in names:
        try:
            return read_fold(trial.folder / name)
        except InputError as error:
            reasons.append(f"{name}: {error.value}" if (trial.folder / name).exists() else _missing(trial, name))
    notes.append(Note(f"{without} ({'; '.join(reasons)})", (trial.folder,)))
    return None


def _missing(trial: Trial, name: str) -> str:
    """The note that a file is not there, and why if that was asked for."""
    with suppress(InputError):
        if name in ONLY_WITH_ALL_FILES and RunFolder(trial.run).config().get("files") == "designs":
            return f"files=designs leaves out {name}"
    return f"there is no {name}"


def read_target_of(trials: Sequence[Trial], notes: list[Note]) -> TargetSurface | None:
    """The target's surface from the first run folder that has it; None for objectives without a target."""
    for trial in trials:
        try:
            return read_target(trial.run / "target.ply")
        except InputError:
            continue
    if any(trial.row.return_vertex is not None for trial in trials):
        notes.append(Note("drawn without its target, there is no target.ply that can be read", (trials[0].run,)))
    return None


def gallery_figure(groups: Groups, shapes: Mapping[tuple[Heading, Heading], Shape]) -> Figure:
    """All shapes, a row a task and a column a searcher; the best of each task framed."""
    rows, columns = groups.columns, groups.rows
    figure = new_figure(1.1 + 2.0 * len(columns), 0.4 + 2.0 * len(rows))
    grid = figure.subplots(len(rows), len(columns), squeeze=False)
    for i, task in enumerate(rows):
        for j, searcher in enumerate(columns):
            axes, shape = grid[i, j], shapes.get((searcher, task))
            _clear(axes)
            if shape is None:
                axes.text(0.5, 0.5, "–", ha="center", va="center", color=QUIET, transform=axes.transAxes)
            else:
                _show(axes, shape.image)
                axes.set_xlabel(shape.caption, fontsize=8, color=INK if shape.best else QUIET)
                _frame(axes, shape.best)
            if i == 0:
                axes.set_title(_broken(searcher.label), fontsize=10, fontweight="bold", color=INK, parse_math=False)
            if j == 0:
                axes.set_ylabel(_broken(task.label), fontsize=10, fontweight="bold", color=INK, parse_math=False)
    return figure


def motion_figure(motion: DrawnMotion, column: Heading) -> Figure:
    """The steps of a motion from left to right."""
    count = len(motion.images)
    height = 2.0 * motion.images[0].height / motion.images[0].width + 0.6
    figure = new_figure(2.0 * count, height)
    grid = figure.subplots(1, count, squeeze=False)[0]
    for axes, image, angle in zip(grid, motion.images, motion.angles, strict=True):
        _clear(axes)
        _show(axes, image)
        if angle is not None:
            axes.set_xlabel(f"{angle:.1f}°", fontsize=9, color=QUIET)
    grid[0].set_title(column.label, loc="left", fontsize=11, fontweight="bold", color=INK, parse_math=False)
    return figure


def _clear(axes: Axes) -> None:
    axes.set(xticks=[], yticks=[])
    axes.spines[:].set_visible(False)


def _show(axes: Axes, image: Image.Image) -> None:
    axes.imshow(np.asarray(image))


def _frame(axes: Axes, best: bool) -> None:
    if best:
        axes.spines[:].set(visible=True, color=HIGHLIGHT, linewidth=1.8)


def _broken(label: str) -> str:
    """A picture's heading: the name and, below it, the settings that tell it from others, in lines of its width."""
    name, bracket, rest = label.partition(" (")
    return "\n".join([name, *textwrap.wrap(f"({rest}", 24)]) if bracket else label
