"""One page with everything on it, which loads nothing from elsewhere; its form is in ``page.html.jinja``."""

from __future__ import annotations

import base64
import io
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING

from jinja2 import Environment, PackageLoader, StrictUndefined, select_autoescape
from markupsafe import Markup

from origami_lab.report.design_files import DesignFiles
from origami_lab.report.gallery import DrawnMotion, Shape
from origami_lab.report.run_groups import Groups, Heading
from origami_lab.report.run_reader import Note, Run, relative
from origami_lab.report.table_formats import known_text, many, number, value_text
from origami_lab.report.tables import Table
from origami_lab.runs.trial_row import REFUTED, counts

if TYPE_CHECKING:
    from PIL import Image

GENERATOR = '<meta name="generator" content="origami-lab report">'
"""By which a page is known as one of ours."""


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
    """The page as it is written to a folder, from which run folders are named."""
    sections = {
        "Tables": content.tables,
        "Learning curves": content.learning or content.solved,
        "Gallery": content.shapes,
        "Crease patterns": content.patterns,
        "Folding motion": content.motions,
        "Runs": content.runs,
    }
    pages = Environment(
        loader=PackageLoader("origami_lab.report", "."),
        autoescape=select_autoescape(default=True),
        undefined=StrictUndefined,
        keep_trailing_newline=True,
    )
    pages.filters |= {
        "anchor": lambda title: title.lower().replace(" ", "-"),
        "value": value_text,
        "known": known_text,
        "degrees": lambda angle: f"{number(angle, 1)}°",
        "svg": lambda figure: _inline(figure, "svg+xml"),
        "png": _png,
        "origin": lambda column: _origin(column, content.motions[column]),
    }
    return pages.get_template("page.html.jinja").render(
        content=content,
        output=output,
        generator=Markup(GENERATOR),
        style=Markup(Path(__file__).with_name("page.css").read_text(encoding="utf-8")),
        tasks=", ".join(dict.fromkeys(column.name for column in content.groups.columns)),
        counts=_counts(content),
        sections=[title for title, body in sections.items() if body],
        tables=_with_own_notes(content.tables),
        refuted=REFUTED,
        runs=[_run(run, output) for run in content.runs],
        versions=_versions(content.runs, output),
    )


def _counts(content: Content) -> str:
    trials = sum(len(group.trials) for group in content.groups.cells.values())
    searchers = len({run.method for run in content.runs})
    tasks = len({run.task for run in content.runs})
    return (
        f"{many(len(content.runs), 'run')}, {many(trials, 'trial')}: "
        f"{many(searchers, 'searcher')} on {many(tasks, 'task')}"
    )


def _with_own_notes(tables: Sequence[Table]) -> list[tuple[Table, list[str]]]:
    """Each table with its notes; a note that holds for several is said once."""
    found, said = [], set[str]()
    for table in tables:
        found.append((table, [note for note in table.notes if note not in said]))
        said.update(table.notes)
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
        "method": run.method,
        "trials": ", ".join(f"{count} {status}" for status, count in ended.items()),
        "took": f"{number(float(seconds), 0)} s" if isinstance(seconds, int | float) else "–",
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
