"""Learning curves: the mean best return so far, and the share of trials that are solved, over interactions."""

from __future__ import annotations

import csv
import io
import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.ticker import PercentFormatter
from numpy.typing import NDArray

from origami_lab.drawing.figures import INK, QUIET, new_figure
from origami_lab.files import LARGEST_TABLE, regular_bytes
from origami_lab.report.run_groups import Groups, Heading
from origami_lab.report.run_reader import Note, Trial
from origami_lab.runs.trial_row import NO_DESIGN

COLOURS = ("#0072b2", "#d55e00", "#009e73", "#cc79a7", "#e69f00", "#56b4e9", "#7a5c00", "#5e3c99")
"""Told apart by most eyes (Okabe and Ito), and two more."""
DASHES = ("solid", "dashed", "dashdot", "dotted")
MOST_COLOURED = 8
"""Searchers that a figure tells apart; where there are more, the best have colours and the others are grey."""
GREY = "#c3c7cf"
NEAR, RELATIVE = 1e-3, 0.01
"""A trial is solved that comes as near to the best one, in board cells or as a share of its return."""


@dataclass(frozen=True, eq=False)
class Curve:
    """The best return so far of each of n trials, at S steps."""

    steps: NDArray[np.int64]
    """(S,) interactions."""
    values: NDArray[np.float64]
    """(n, S), NaN before a trial's first design."""

    @property
    def mean(self) -> NDArray[np.float64]:
        """(S,), NaN until every trial has a value."""
        found: NDArray[np.float64] = self.values.mean(axis=0)
        return found

    @property
    def std(self) -> NDArray[np.float64]:
        """(S,) sample standard deviation, 0 for a single trial."""
        if len(self.values) < 2:
            return np.where(np.isnan(self.mean), np.nan, 0.0)
        found: NDArray[np.float64] = self.values.std(axis=0, ddof=1)
        return found

    @property
    def band(self) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
        """(S,) and (S,), one standard deviation below and above the mean, but no further than a trial has been."""
        low = np.maximum(self.mean - self.std, self.values.min(axis=0))
        return low, np.minimum(self.mean + self.std, self.values.max(axis=0))

    def solved(self, threshold: float) -> NDArray[np.float64]:
        """(S,) the share of trials that have reached the threshold."""
        found: NDArray[np.float64] = (self.values >= threshold).mean(axis=0)
        return found


def read_curves(groups: Groups, notes: list[Note]) -> dict[tuple[Heading, Heading], Curve]:
    """The curves of all cells, by row and column; trials without a readable curve.csv are left out and named."""
    found = {}
    for place, group in groups.cells.items():
        improvements = []
        for trial in group.counted:
            try:
                improvements.append(_improvements(trial))
            except (OSError, ValueError, KeyError, TypeError, csv.Error):
                notes.append(Note("not in the curves, it has no curve.csv that can be read", (trial.folder,)))
        if improvements:
            found[place] = _curve(improvements, group.budget)
    return found


def _improvements(trial: Trial) -> tuple[NDArray[np.int64], NDArray[np.float64]]:
    """Interactions and best return of each improvement."""
    if trial.status == NO_DESIGN:  # what all its episodes brought
        return np.zeros(1, dtype=np.int64), np.array([trial.value])
    text = regular_bytes(trial.folder / "curve.csv", LARGEST_TABLE).decode("utf-8")
    with io.StringIO(text, newline="") as file:
        rows = [(int(row["interactions"]), float(row["return"])) for row in csv.DictReader(file)]
    if not rows or not all(math.isfinite(value) for _, value in rows):
        raise ValueError("no improvement")
    steps, values = zip(*sorted(rows), strict=True)
    return np.array(steps, dtype=np.int64), np.maximum.accumulate(np.array(values, dtype=np.float64))


def _curve(improvements: Sequence[tuple[NDArray[np.int64], NDArray[np.float64]]], budget: int) -> Curve:
    """All trials at every step at which one of them improves; one that ended early keeps what it had."""
    ends = [np.array([budget])]
    steps = np.unique(np.concatenate([*(steps for steps, _ in improvements), *ends]))
    values = np.full((len(improvements), len(steps)), np.nan)
    for index, (own, best) in enumerate(improvements):
        last = np.searchsorted(own, steps, side="right") - 1
        values[index] = np.where(last >= 0, best[np.maximum(last, 0)], np.nan)
    return Curve(steps, values)


def threshold_of(groups: Groups, column: Heading, curves: Mapping[tuple[Heading, Heading], Curve]) -> float | None:
    """The return that counts as solved: nearly the best of any trial of the task.

    None if it tells nothing: without a design, and where each trial with one was there from its first design on, as on
    an objective that gives every sheet the same return until something is found.
    """
    best = groups.best_of(column)
    if best is None:
        return None
    value = best[1].value
    threshold = value - max(NEAR, RELATIVE * abs(value))
    rose = any(_rises(curve, threshold) for _, curve in _of(groups, column, curves))
    designs = (trial for _, group in groups.column(column) for trial in group.counted if trial.status != NO_DESIGN)
    missed = any(trial.value < threshold for trial in designs)
    return threshold if rose or missed else None


def _rises(curve: Curve, threshold: float) -> bool:
    """Whether a trial was below a return and came to it."""
    below = (curve.values < threshold).any(axis=1)
    return bool((below & (curve.values[:, -1] >= threshold)).any())


def styles(rows: Sequence[Heading]) -> dict[Heading, tuple[str, str]]:
    """Colour and dashes of each searcher, the same in all figures."""
    count = len(COLOURS)
    return {row: (COLOURS[i % count], DASHES[i // count % len(DASHES)]) for i, row in enumerate(rows)}


def _coloured(
    groups: Groups, column: Heading, curves: Mapping[tuple[Heading, Heading], Curve]
) -> dict[Heading, tuple[str, str]]:
    """Colour and dashes of the searchers that a task's figures tell apart: all, or of many the best at the end."""
    found = _of(groups, column, curves)
    if len(groups.rows) <= MOST_COLOURED:
        return styles(groups.rows)
    ends = {row: curve.mean[-1] for row, curve in found if not np.isnan(curve.mean[-1])}
    return styles(sorted(ends, key=lambda row: -ends[row])[:MOST_COLOURED])


def learning_figure(groups: Groups, column: Heading, curves: Mapping[tuple[Heading, Heading], Curve]) -> Figure:
    """Mean best return so far of each searcher on one task, and its band."""
    figure, axes = _axes("interactions", "best return so far")
    start, end = math.inf, 10.0
    shown: list[float] = []
    coloured = _coloured(groups, column, curves)
    for row, curve in _of(groups, column, curves):
        mean = curve.mean
        known = ~np.isnan(mean)
        if not known.any():
            continue
        colour, dashes = coloured.get(row, (GREY, "solid"))
        steps = np.maximum(curve.steps[known], 1)
        label, order = (row.label, 2.5) if row in coloured else (None, 1.5)
        axes.step(steps, mean[known], where="post", color=colour, linestyle=dashes, label=label, zorder=order)
        low, high = (edge[known] for edge in curve.band)
        if row in coloured:
            axes.fill_between(steps, low, high, step="post", color=colour, alpha=0.16, linewidth=0)
        start, end = min(start, *steps), max(end, *steps)
        # the first designs are much worse than what matters: they may leave the picture at the bottom
        late = steps >= 0.02 * steps[-1]
        shown += [*low[late].tolist(), *high.tolist()]
    _finish(axes, start, end, column)
    if shown:
        bottom, top = min(shown), max(shown)
        axes.set_ylim(bottom - 0.05 * (top - bottom or 1), top + 0.05 * (top - bottom or 1))
    return figure


def solved_figure(
    groups: Groups, column: Heading, curves: Mapping[tuple[Heading, Heading], Curve], threshold: float
) -> Figure:
    """The share of each searcher's trials that have reached a return, over interactions."""
    figure, axes = _axes("interactions", f"trials at {threshold:.4g} or better".replace("-", "−"))
    start, end = math.inf, 10.0
    coloured = _coloured(groups, column, curves)
    for row, curve in _of(groups, column, curves):
        colour, dashes = coloured.get(row, (GREY, "solid"))
        steps = np.maximum(curve.steps, 1)
        label, order = (row.label, 2.5) if row in coloured else (None, 1.5)
        share = curve.solved(threshold)
        axes.step(steps, share, where="post", color=colour, linestyle=dashes, label=label, zorder=order)
        start, end = min(start, *steps), max(end, *steps)
    axes.yaxis.set_major_formatter(PercentFormatter(1.0, decimals=0))
    axes.set_ylim(-0.03, 1.03)
    _finish(axes, start, end, column)
    return figure


def _of(
    groups: Groups, column: Heading, curves: Mapping[tuple[Heading, Heading], Curve]
) -> list[tuple[Heading, Curve]]:
    return [(row, curves[row, column]) for row in groups.rows if (row, column) in curves]


def _axes(across: str, up: str) -> tuple[Figure, Axes]:
    figure = new_figure(5.6, 3.7)
    axes = figure.add_subplot()
    axes.set_xlabel(across, color=QUIET)
    axes.set_ylabel(up, color=QUIET)
    axes.set_xscale("log")
    axes.grid(color="#e6e8ec", linewidth=0.7)
    axes.set_axisbelow(True)
    axes.tick_params(colors=QUIET, which="both")
    for name, spine in axes.spines.items():
        spine.set_visible(name in ("left", "bottom"))
        spine.set_color("#b8bcc6")
    return figure, axes


def _finish(axes: Axes, start: float, end: float, column: Heading) -> None:
    axes.set_title(column.label, loc="left", fontsize=11, fontweight="bold", color=INK, parse_math=False)
    if start < end:
        axes.set_xlim(max(1.0, start), end)
        axes.legend(frameon=False, fontsize=8.5, labelcolor=INK)
