"""One page with everything on it, which loads nothing from elsewhere; its form is in ``page.html.jinja``."""

from __future__ import annotations

import base64
import io
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any

from origami_lab.pages import page_text
from origami_lab.report.design_files import DesignFiles
from origami_lab.report.gallery import DrawnMotion, Shape
from origami_lab.report.learning_curves import MOST_COLOURED
from origami_lab.report.run_groups import Groups, Heading
from origami_lab.report.run_reader import Note, Run, relative
from origami_lab.report.table_formats import known_text, many, number, value_text
from origami_lab.report.tables import Table
from origami_lab.runs.trial_row import REFUTED, counts

if TYPE_CHECKING:
    from PIL import Image

KIND = "report"
GENERATOR = f'<meta name="generator" content="origami-lab {KIND}">'
"""By which a page is known as one of ours."""
MOST_SHAPES = 7
"""Designs of a task that are seen at once."""
MOST_NAMED = 6
"""Tasks that the heading names."""
RUN_COLUMNS = ("folder", "task", "searcher", "trials", "took", "command")
SHORT_NAMES = {
    "returns": "return",
    "returns_vertex": "by vertex",
    "returns_surface": "by surface",
    "returns_sampled": "by sampled points",
    "returns_mean": "mean distance",
    "returns_likeness": "likeness",
    "returns_polished": "polished",
    "interactions": "interactions",
}
"""Tables as the switch above them names them."""


@dataclass(frozen=True, eq=False)
class Content:
    """The contents of the page; figures are SVG, by task."""

    runs: Sequence[Run]
    groups: Groups
    tables: Sequence[Table]
    learning: Mapping[Heading, bytes]
    solved: Mapping[Heading, bytes]
    shapes: Mapping[tuple[Heading, Heading], Shape]
    designs: Mapping[tuple[Heading, Heading], DesignFiles]
    patterns: Mapping[Heading, bytes]
    motions: Mapping[Heading, DrawnMotion]
    notes: Sequence[Note]


def render(content: Content, output: Path) -> str:
    """The page as it is written to a folder, from which run folders are named. It has no script."""
    sections = {
        "Gallery": content.shapes,
        "Tables": content.tables,
        "Learning curves": content.learning or content.solved,
        "Crease patterns": content.patterns,
        "Folding motion": content.motions,
        "Runs": content.runs,
    }
    runs = [_run(run, output) for run in content.runs]
    style = Path(__file__).with_name("page.css")
    values = {
        "kind": KIND,
        "content": content,
        "output": output,
        "tasks": _in_short([column.name for column in content.groups.columns]),
        "counts": _counts(content),
        "sections": [title for title, body in sections.items() if body],
        "gallery": _gallery(content),
        "tables": _with_own_notes(content.tables),
        "many_searchers": MOST_COLOURED if len(content.groups.rows) > MOST_COLOURED else 0,
        "refuted": REFUTED,
        "runs": runs,
        "run_columns": [name for name in RUN_COLUMNS if name in ("folder", "task") or any(run[name] for run in runs)],
        "versions": _versions(content.runs, output),
    }
    filters: dict[str, Callable[..., Any]] = {
        "anchor": lambda title: title.lower().replace(" ", "-"),
        "value": value_text,
        "known": known_text,
        "short": lambda name: SHORT_NAMES.get(name, name),
        "degrees": lambda angle: f"{number(angle, 1)}°",
        "svg": lambda figure: _inline(figure, "svg+xml"),
        "png": _png,
        "origin": lambda column: _origin(column, content.motions[column]),
    }
    switches = "".join(
        f"#show-{table.name}:checked ~ .shown-by-{table.name} {{ display: block; }}\n" for table in content.tables
    )
    page = page_text(__package__, "page.html.jinja", values, styles=[style], filters=filters)
    return page.replace("</style>", f"{switches}</style>", 1)


def _in_short(names: Sequence[str]) -> str:
    """The names of tasks for the heading, not too many."""
    each = list(dict.fromkeys(names))
    return ", ".join(each) if len(each) <= MOST_NAMED else f"{len(each)} tasks"


def _gallery(content: Content) -> list[tuple[Heading, list[Heading], list[Heading]]]:
    """Of each task the searchers whose designs are seen at once, and the others: where there are many, the best first.

    A searcher that was run has its place also where it has no design.
    """
    found: list[tuple[Heading, list[Heading], list[Heading]]] = []
    for column in content.groups.columns:
        rows = [row for row, _ in content.groups.column(column)]
        if len(rows) <= MOST_SHAPES:
            found.append((column, rows, []))
            continue
        designs = [row for row in rows if (row, column) in content.shapes]
        designs.sort(key=lambda row: -content.shapes[row, column].trial.value)
        found.append((column, designs[:MOST_SHAPES], designs[MOST_SHAPES:]))
    return found


def _counts(content: Content) -> str:
    trials = sum(len(group.trials) for group in content.groups.cells.values())
    searchers = len({run.method for run in content.runs})
    tasks = len({run.task for run in content.runs})
    return (
        f"{many(len(content.runs), 'run')}, {many(trials, 'trial')}: "
        f"{many(searchers, 'searcher')} on {many(tasks, 'task')}"
    )


def _with_own_notes(tables: Sequence[Table]) -> list[tuple[Table, list[str], int | None]]:
    """Each table with its notes, and how many trials each of its cells has if they are equally many."""
    found = []
    for table in tables:
        numbers = {cell.spread.n for cell in table.cells.values() if cell.spread is not None}
        trials = next(iter(numbers)) if len(numbers) == 1 else None
        notes = list(table.notes)
        if trials is not None:
            each = f"each cell {many(trials, 'trial')}"
            notes = [note.replace("in parentheses the number of trials", each) for note in notes]
        found.append((table, notes, trials))
    return found


def _origin(column: Heading, motion: DrawnMotion) -> str:
    """The origin of a design: task, searcher, seed and return."""
    value = number(motion.trial.value, 4)
    return f"{column.label}: {motion.row.label}, seed {motion.trial.seed}, return {value}"


def _png(image: Image.Image) -> str:
    stream = io.BytesIO()
    image.save(stream, format="PNG", optimize=True)
    return _inline(stream.getvalue(), "png")


def _inline(content: bytes, kind: str) -> str:
    return f"data:image/{kind};base64,{base64.b64encode(content).decode('ascii')}"


def _run(run: Run, output: Path) -> dict[str, str]:
    """Where a run is from, in words."""
    seconds = run.summary.get("seconds")
    ended = counts(trial.row for trial in run.trials)
    return {
        "folder": relative(run.folder, output),
        "task": run.task,
        "searcher": run.method,
        "trials": ", ".join(f"{count} {status}" for status, count in ended.items()),
        "took": f"{number(float(seconds), 0)} s" if isinstance(seconds, int | float) else "",
        "command": str(run.summary.get("command") or ""),
    }


def _versions(runs: Sequence[Run], output: Path) -> list[str]:
    """Versions that the runs were computed with, each set once."""
    found: dict[str, list[str]] = {}
    for run in runs:
        text = ", ".join(f"{name} {version}" for name, version in run.versions.items()) or "versions not known"
        found.setdefault(text, []).append(relative(run.folder, output))
    if len(found) == 1:
        return [f"Computed with {next(iter(found))}."]
    return [f"{', '.join(folders)}: {text}." for text, folders in found.items()]
