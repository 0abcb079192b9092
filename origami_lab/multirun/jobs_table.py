"""The table that a multirun prints at its end: a line for each of its jobs."""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import TYPE_CHECKING

from rich.console import Console
from rich.text import Text

from origami_lab.text import command_text

if TYPE_CHECKING:
    from rich.table import Table

    from origami_lab.runs.multirun_folder import JobResult

OF_THE_FOLDER = ("output", "resume", "open")
"""Settings of a multirun that none of its jobs needs where it runs by itself."""


def jobs_title(found: Sequence[JobResult], experiment: str) -> str:
    """The title of the table: all that the jobs have in common."""
    names = ({getattr(outcome.job, kind) for outcome in found} for kind in ("task", "method"))
    common = [next(iter(values)) for values in names if len(values) == 1]
    return " · ".join([f"{len(found)} job{'' if len(found) == 1 else 's'}", *common, experiment])


def best_commands(found: Sequence[JobResult], flags: Sequence[str]) -> list[str]:
    """A line for each task with the command that runs its best job by itself: the highest mean return."""
    lines = []
    for task in dict.fromkeys(outcome.job.task for outcome in found):
        own = [outcome for outcome in found if outcome.job.task == task and outcome.spread is not None]
        if len(own) > 1:
            best = max(own, key=lambda outcome: outcome.spread.mean if outcome.spread else -math.inf)
            words = [word for word in best.job.overrides if word.partition("=")[0].lstrip("+") not in OF_THE_FOLDER]
            lines.append(f"best of {task}: {command_text(['origami-lab', *flags, *words])}")
    return lines


def table_of_jobs(found: Sequence[JobResult], console: Console) -> Table:
    """One line a job, by what tells it from the others; the best of each task is bold."""
    from rich.measure import Measurement

    wide = console.options.update(width=10_000)
    for shown in (("return", "best"), ("return",)):
        table = _table_of(found, shown)
        if Measurement.get(console, wide, table).maximum <= console.width:
            break
    return table


def _table_of(found: Sequence[JobResult], shown: Sequence[str]) -> Table:
    from rich import box
    from rich.table import Table

    tasks, methods = ({getattr(outcome.job, name) for outcome in found} for name in ("task", "method"))
    table = Table(header_style="bold", box=box.SIMPLE_HEAD, padding=(0, 1, 0, 0))
    table.add_column("job", overflow="fold")
    shows_status = any(outcome.status != "ok" for outcome in found)
    for name in ("trials", *shown):
        table.add_column(name, justify="right")
    if shows_status:
        table.add_column("status")
    best: dict[str, float] = {}
    for outcome in found:
        if outcome.spread is not None:
            best[outcome.job.task] = max(best.get(outcome.job.task, outcome.spread.mean), outcome.spread.mean)
    for outcome in found:
        job, spread, row = outcome.job, outcome.spread, outcome.best
        named = [*job.own, *([job.task] if len(tasks) > 1 else []), *([job.method] if len(methods) > 1 else [])]
        figures = {
            "return": "–" if spread is None else spread.rounded,
            "best": "–" if row is None else f"{row.return_:z.4f}",
        }
        table.add_row(
            Text(" · ".join(named) or job.name),
            f"{outcome.done} of {outcome.asked}",
            *(figures[name] for name in shown),
            *([outcome.status] if shows_status else []),
            style="bold" if spread is not None and spread.mean == best[job.task] else None,
        )
    return table
