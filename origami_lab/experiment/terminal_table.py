"""The table that a run prints at its end, and the lines below it."""

from __future__ import annotations

import math
from collections.abc import Iterable, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any

from origami_lab.file_names import CUT_SHEETS, FOLDED_PNG, PAGE, POLISHED, trial_folder
from origami_lab.lengths import smallest_sheet
from origami_lab.runs.trial_row import (
    FAILED,
    GOAL,
    MINUTES,
    NO_DESIGN,
    OK,
    REFUTED,
    RETURNS,
    STOPPED,
    TIME_LIMIT,
    UNDECIDED,
    Spread,
    TrialRow,
    best_row,
    certificates,
    spreads,
)
from origami_lab.text import command_text, short_of

if TYPE_CHECKING:
    from rich.table import Table


NARROW = 72
"""A terminal of fewer columns cannot show all that a trial has to tell."""

ROUNDING = 1e-9
"""Cells, millimetres, percent: less is 0, up to rounding."""


def summary_table(rows: Sequence[TrialRow], title: str | None = None, width: int = 80) -> Table:
    """The trials and their mean ± std, for a terminal of 80 columns; a narrow one gets what matters most."""
    from rich import box
    from rich.table import Table

    designs = [row for row in rows if row.outcome != NO_DESIGN]  # the others have the penalty for a return
    measured = [name for name in RETURNS[1:] if any(row[name] is not None for row in designs)]
    # the distance that the search used is the return: said once
    same = [name for name in measured if not any(_differs(row[name], row.return_) for row in designs)]
    wide = width >= NARROW
    returns = ["return", *(name for name in measured if name not in same[:1] and wide)]
    several = len(rows) > 1
    table = Table(
        title=title,
        title_justify="left",
        show_footer=several,
        header_style="bold",
        box=box.SIMPLE_HEAD,
        padding=(0, 1, 0, 0),
    )
    found = spreads(designs)
    best = best_row(designs)
    table.add_column("seed", "mean\nstd", justify="right")
    for name in returns:
        table.add_column(name.removeprefix("return_"), _footer(found.get(name)), justify="right")
    polished = any(row.polished_return is not None for row in designs)
    for shown in ("angle °", "best at", "vertices") if wide and not polished else ("angle °", "best at")[: 1 + wide]:
        table.add_column(shown, justify="right")
    if polished:
        table.add_column("polished", _footer(found.get("polished_return")), justify="right")
    shows_status = any(row.outcome != OK for row in rows)
    if shows_status:
        table.add_column("status")
    for row in sorted(rows, key=lambda row: row.seed):
        table.add_row(
            str(row.seed),
            *(_number(row[name] if row in designs else None, "z.4f") for name in returns),
            _number(row.driving_angle, ".1f"),
            *([_number(row.interactions_to_best, ",d")] if wide else []),
            *([_number(row.vertices, "d")] if wide and not polished else []),
            *([_number(row.polished_return, "z.4f")] if polished else []),
            *([row.outcome] if shows_status else []),
            style="bold" if row is best and several else None,
        )
    return table


def hint(rows: Iterable[TrialRow]) -> str | None:
    """One line on what usually helps where trials ended without a design; None if all have one."""
    empty = sum(row.outcome == NO_DESIGN for row in rows)
    if not empty:
        return None
    trials = "1 trial" if empty == 1 else f"{empty} trials"
    return (
        f"{trials} found no design that folds: what usually helps is a larger budget, "
        "start.size=1 or 2, a symmetry, or a larger max_crease_length"
    )


def certificate_lines(rows: Iterable[TrialRow]) -> list[str]:
    """Lines on the certificates for below the table: the counts, and a warning if one refutes its design."""
    rows = list(rows)
    found = certificates(rows)
    if not found:
        return []
    counts = ", ".join(f"{len(seeds)} {verdict}" for verdict, seeds in sorted(found.items()))
    lines = [f"certificates: {counts}"]
    if seeds := found.get(REFUTED):
        listed = ", ".join(map(str, seeds))
        lines.append(
            f"warning: seed {listed}: the best design is refuted, it does not fold as it should: see certificate.json"
        )
    if seeds := found.get(UNDECIDED):
        angle = next(row.driving_angle for row in rows if row.seed == seeds[0])
        short = "" if angle is None else f" ({short_of(angle)})"
        lines.append(
            "not certifiable: its certificate.json says why; where paper comes to lie flat on paper, a smaller driving"
            f" angle{short} stops short of that and can be certified, a little off"
        )
    return lines


def where_lines(rows: Iterable[TrialRow], folder: Path) -> list[str]:
    """Lines on where the best design's picture and the run's page are, if they are there."""
    rows, lines = [row for row in rows if row.outcome != NO_DESIGN], []
    best = best_row(rows)
    polished = best_row(rows, "polished_return")
    pictures = [] if polished is None else [trial_folder(folder, polished.seed) / f"{POLISHED}.png"]
    pictures += [] if best is None else [trial_folder(folder, best.seed) / FOLDED_PNG]
    if (picture := next((file for file in pictures if file.is_file()), None)) is not None:
        lines.append(f"its picture: {picture}")
        if (sheet := picture.with_name(CUT_SHEETS[1])).is_file():  # there is one of the trial's own design only
            polishes = picture.name != FOLDED_PNG
            made = command_text(["origami-lab", "export", str(picture.with_name(f"{POLISHED}.fold")), "--to", "cut"])
            lines.append(f"to cut it: {made}" if polishes else f"to cut: {sheet}")
    if (folder / PAGE).is_file():
        lines.append(f"all of it: {folder / PAGE}")
    return lines


def figure_lines(rows: Iterable[TrialRow]) -> list[str]:
    """Lines on the best design, and how like its target it is."""
    rows = list(rows)
    best = best_row(row for row in rows if row.outcome != NO_DESIGN)
    if best is None:
        return []
    if best.chamfer is None:
        return [f"best{f' (seed {best.seed})' if len(rows) > 1 else ''}: return {_number(best.return_, 'z.4f')}"]
    other = [] if best.return_units is None else [f"{_short(-best.return_units)} units of the file"]
    if best.return_mm is not None:
        other.append(f"{_short(-best.return_mm)} mm on paper")
    if best.return_percent is not None:
        other.append(f"{_short(-best.return_percent)} % of the target's size")
    seed = f" (seed {best.seed})" if len(rows) > 1 else ""
    away = f"{_short(-best.return_)} cells from the target" if best.return_ is not None else "distance"
    lines = [
        f"best{seed}: {' = '.join([away, *other])}; on average {_short(best.chamfer)} cells;"
        f" likeness {_number(best.likeness, '.2f')}"
    ]
    if best.cell_mm is not None:
        sides = f"{_short(best.width_mm)} × {_short(best.height_mm)} mm"
        sheet = smallest_sheet(best.width_mm or 0.0, best.height_mm or 0.0)
        room = "" if sheet is None else f" and fits {sheet}"
        lines.append(f"its pattern is {sides}{room}, {_short(best.cell_mm)} mm a board cell")
    return lines


def surface_line(rows: Iterable[TrialRow]) -> str | None:
    """A line on designs that the vertices flatter; None if there are none."""
    seeds = sorted(row.seed for row in rows if row.surface_is_worse)
    if not seeds:
        return None
    return (
        f"seed {', '.join(map(str, seeds))}: by surface the design is further from the target than by vertex, by"
        " more than a tenth: panels stand out, or leave places bare, where no vertex shows it"
    )


def end_lines(rows: Iterable[TrialRow]) -> list[str]:
    """Lines on trials that ended before their budget was spent."""
    rows, lines = sorted(rows, key=lambda row: row.seed), []
    for end, words in _END_WORDS.items():
        if seeds := [row.seed for row in rows if row.ended == end]:
            lines.append(f"seed {', '.join(map(str, seeds))}: {words}")
    return lines


_END_WORDS = {
    GOAL: "ended by target_return, which it has reached",
    MINUTES: "ended by minutes: what it found depends on the machine, and is not reproducible by the seed alone",
}


def polish_lines(rows: Iterable[TrialRow]) -> list[str]:
    """Lines on the polished designs for below the table: the best of them, and whose polish did not come to its end."""
    rows = sorted((row for row in rows if row.polish is not None), key=lambda row: row.seed)
    if not rows:
        return []
    polished = [row for row in rows if row.polished_return is not None]
    lines = []
    if best := best_row(polished, "polished_return"):
        gain = best["polished_return"] - best["return"]
        spread = f", mean {spreads(polished)['polished_return']}" if len(polished) > 1 else ""
        lines = [
            f"polished: best {best.polished_return:z.4f} (seed {best.seed}, {gain:z.4f} better), driving angle"
            f" {best.polished_driving_angle:.2f}°{spread}"
        ]
    for end in (TIME_LIMIT, STOPPED, FAILED):
        if seeds := [row.seed for row in rows if row.polish and row.polish.partition(":")[0] == end]:
            lines.append(f"polish of seed {', '.join(map(str, seeds))}: {_POLISH_WORDS[end]}")
    return lines


_POLISH_WORDS = {
    TIME_LIMIT: "ended by the time limit polish_seconds",
    STOPPED: "stopped; resume=true goes on with it",
    FAILED: "failed, see the column polish of trials.csv",
}


def places_line(rows: Iterable[TrialRow]) -> str | None:
    """A line on places that were looked at without being played; None if there were none."""
    places = sum(row.places_evaluated or 0 for row in rows)
    return f"places evaluated without being played: {places:,}" if places else None


def _differs(value: float | None, other: float | None) -> bool:
    """Whether a table with four decimals has something to tell about ``value``."""
    return value is not None and (other is None or abs(value - other) > 1e-6)


def _footer(spread: Spread | None) -> str:
    return "" if spread is None else f"{_number(spread.mean, 'z.4f')}\n{_number(spread.std, 'z.4f')}"


def _short(value: float | None) -> str:
    """Three digits, and 0 for what rounding leaves of it."""
    return "–" if value is None or not math.isfinite(value) else f"{value if abs(value) > ROUNDING else 0.0:.3g}"


def _number(value: Any, form: str) -> str:
    return "–" if value is None or not math.isfinite(value) else format(value, form)
