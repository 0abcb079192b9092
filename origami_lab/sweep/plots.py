"""The plots of a study: what was found when, what mattered, which values were good, and the comparison at the end."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import TYPE_CHECKING, Any

import numpy as np

from origami_lab.config.checked_values import shown
from origami_lab.drawing.figures import HIGHLIGHT, INK, QUIET, new_figure
from origami_lab.sweep.search_space import Parameter

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

GIVEN_UP: dict[str, Any] = {"s": 16, "c": "#9aa0b0", "marker": "x", "lw": 1, "label": "given up: mean of fewer seeds"}
PLAYED: dict[str, Any] = {"s": 18, "c": HIGHLIGHT, "label": "all seeds"}
BEST: dict[str, Any] = {"s": 60, "facecolors": "none", "edgecolors": INK, "lw": 1.2, "label": "best"}
"""How trials are marked."""
COLUMNS = 4
"""Small plots side by side."""


def history(record: Mapping[str, Any]) -> Figure:
    """The value of each trial, and the best so far, in order of the trials."""
    figure = new_figure(6.4, 3.6)
    axes = figure.add_subplot()
    complete, pruned = _by_state(record)
    for trials, look in ((pruned, GIVEN_UP), (complete, PLAYED)):
        axes.scatter([trial["trial"] for trial in trials], [trial["value"] for trial in trials], **look)
    if complete:
        values = np.maximum.accumulate([trial["value"] for trial in complete])
        across = [trial["trial"] for trial in complete] + [record["trials"] - 1]
        axes.step(across, [*values, values[-1]], where="post", color=INK, lw=1.2, label="best so far")
    _finish(axes, "trial", "mean return")
    _legend(figure, axes)
    return figure


def importance(found: Mapping[str, float], note: str) -> Figure:
    """A plot of the share of the returns' variance that each parameter explains."""
    names = sorted(found, key=lambda name: found[name])
    figure = new_figure(6.4, 1.0 + 0.34 * max(len(names), 1))
    axes = figure.add_subplot()
    bars = axes.barh(names, [found[name] for name in names], color=HIGHLIGHT, height=0.62)
    axes.bar_label(bars, [f"{found[name]:.2f}" for name in names], padding=3, fontsize=8, color=QUIET)
    axes.set_xlim(0, max([*found.values(), 0.1]) * 1.15)
    _finish(axes, note, "")
    axes.grid(visible=False, axis="y")
    return figure


def slices(record: Mapping[str, Any], space: Sequence[Parameter]) -> Figure:
    """The value of each trial over each parameter by itself."""
    rows = -(-len(space) // COLUMNS)
    columns = min(len(space), COLUMNS)
    figure = new_figure(2.3 * columns + 0.4, 2.2 * rows + 0.3)
    complete, pruned = _by_state(record)
    first: Axes | None = None
    for number, parameter in enumerate(space):
        axes = figure.add_subplot(rows, columns, number + 1, sharey=first)
        first = first or axes
        best = [trial for trial in complete if trial["trial"] == record["best"]]
        for trials, look in ((pruned, GIVEN_UP), (complete, PLAYED), (best, BEST)):
            having = [trial for trial in trials if parameter.name in trial["point"]]
            across = [_slot(parameter, trial["point"][parameter.name]) for trial in having]
            axes.scatter(across, [trial["value"] for trial in having], **look)
        if parameter.choices:
            axes.set_xticks(range(len(parameter.choices)), [shown(value) for value in parameter.choices])
            axes.set_xlim(-0.5, len(parameter.choices) - 0.5)
        else:
            _scale(axes, parameter)
        _finish(axes, parameter.name, "mean return" if number % columns == 0 else "")
        axes.tick_params(labelleft=number % columns == 0, labelsize=7)
    if first is not None:
        _legend(figure, first)
    return figure


def held_out(comparison: Mapping[str, Any]) -> Figure:
    """Every return on the held-out seeds, and the means."""
    settings = comparison["settings"]
    figure = new_figure(6.4, 0.9 + 0.6 * len(settings))
    axes = figure.add_subplot()
    rng = np.random.default_rng(np.random.SeedSequence(0))
    for row, (name, found) in enumerate(settings.items()):
        returns = np.asarray(found["returns"])
        colour = HIGHLIGHT if name == "best" else QUIET
        axes.scatter(returns, row + rng.uniform(-0.16, 0.16, len(returns)), s=14, c=colour, alpha=0.6, lw=0)
        axes.plot([found["mean"]] * 2, [row - 0.3, row + 0.3], color=INK, lw=1.6)
        axes.annotate(f"{found['mean']:.3f}", (found["mean"], row - 0.33), ha="center", fontsize=8, color=INK)
    axes.set_yticks(range(len(settings)), list(settings))
    axes.set_ylim(len(settings) - 0.5, -0.6)
    _finish(axes, "return on held-out seeds (line: mean)", "")
    axes.grid(visible=False, axis="y")
    return figure


def _by_state(record: Mapping[str, Any]) -> tuple[list[dict[str, Any]], list[dict[str, Any]]]:
    """The trials that were played to the end, and those given up."""
    ended = record["ended"]
    return [t for t in ended if t["state"] == "complete"], [t for t in ended if t["state"] == "pruned"]


def _slot(parameter: Parameter, value: Any) -> float:
    if not parameter.choices:
        return float(value)
    return next(
        index
        for index, choice in enumerate(parameter.choices)
        if choice == value and isinstance(choice, bool) == isinstance(value, bool)
    )


def _scale(axes: Axes, parameter: Parameter) -> None:
    """The whole range; on a logarithmic scale with plain numbers, few enough to be read."""
    if not parameter.log:
        margin = 0.05 * (parameter.high - parameter.low)
        axes.set_xlim(parameter.low - margin, parameter.high + margin)
        return
    from matplotlib.ticker import FormatStrFormatter, LogLocator, NullFormatter

    decades = float(np.log10(parameter.high / parameter.low))
    margin_factor = 10 ** (0.05 * decades)
    axes.set_xlim(parameter.low / margin_factor, parameter.high * margin_factor)
    axes.set_xscale("log")
    axes.xaxis.set_major_locator(LogLocator(10, subs=(1.0, 2.0, 5.0) if decades < 1.8 else (1.0,)))
    axes.xaxis.set_major_formatter(FormatStrFormatter("%g"))
    axes.xaxis.set_minor_formatter(NullFormatter())


def _legend(figure: Figure, axes: Axes) -> None:
    """The legend of the marks, above everything."""
    handles, labels = axes.get_legend_handles_labels()
    figure.legend(handles, labels, loc="outside upper left", ncols=len(labels), frameon=False, fontsize=8)


def _finish(axes: Axes, across: str, up: str) -> None:
    axes.set_xlabel(across, fontsize=8, color=INK)
    axes.set_ylabel(up, fontsize=8, color=INK)
    axes.tick_params(labelsize=8, colors=QUIET, length=3)
    axes.grid(color="#e8eaf0", lw=0.6)
    axes.set_axisbelow(True)
    for name, spine in axes.spines.items():
        spine.set_visible(name in ("left", "bottom"))
        spine.set_color("#c5c8d2")
