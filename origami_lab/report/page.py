"""One page with everything on it, which loads nothing from elsewhere."""

from __future__ import annotations

import base64
import io
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass
from html import escape
from pathlib import Path

from PIL import Image

from origami_lab.report.design_files import DesignFiles
from origami_lab.report.gallery import DrawnMotion, Shape
from origami_lab.report.run_groups import Groups, Heading
from origami_lab.report.run_reader import Note, Run, relative
from origami_lab.report.table_formats import known_text, many, number, value_text
from origami_lab.report.tables import Cell, Table
from origami_lab.runs.trial_row import REFUTED

GENERATOR = '<meta name="generator" content="origami-lab report">'
"""By which a page is known as one of ours."""


@dataclass(frozen=True, eq=False)
class Content:
    """What goes on the page. Figures are SVG, by task."""

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
    tasks = ", ".join(dict.fromkeys(column.name for column in content.groups.columns))
    sections = {
        "Tables": _tables(content.tables),
        "Learning curves": _curves(content),
        "Gallery": _gallery(content),
        "Crease patterns": _patterns(content),
        "Folding motion": "".join(_motion(column, motion) for column, motion in content.motions.items()),
        "Runs": _runs(content.runs, output),
    }
    sections = {title: body for title, body in sections.items() if body}
    links = "".join(f'<a href="#{_anchor(title)}">{title}</a>' for title in sections)
    bodies = "".join(f'<h2 id="{_anchor(title)}">{title}</h2>\n{body}\n' for title, body in sections.items())
    style = Path(__file__).with_name("page.css").read_text(encoding="utf-8")
    return (
        f'<!DOCTYPE html>\n<html lang="en">\n<head>\n<meta charset="utf-8">\n{GENERATOR}\n'
        '<meta name="viewport" content="width=device-width, initial-scale=1">\n'
        f"<title>Rigid origami: {escape(tasks)}</title>\n<style>\n{style}</style>\n</head>\n<body>\n"
        f'<h1>Rigid origami: {escape(tasks)}</h1>\n<p class="quiet">{_counts(content)}</p>\n'
        f"<nav>{links}</nav>\n{_notes(content.notes, output)}{bodies}</body>\n</html>\n"
    )


def _anchor(title: str) -> str:
    return title.lower().replace(" ", "-")


def _counts(content: Content) -> str:
    trials = sum(len(group.trials) for group in content.groups.cells.values())
    searchers = len({run.method for run in content.runs})
    tasks = len({run.task for run in content.runs})
    return (
        f"{many(len(content.runs), 'run')}, {many(trials, 'trial')}: "
        f"{many(searchers, 'searcher')} on {many(tasks, 'task')}"
    )


def _notes(notes: Sequence[Note], output: Path) -> str:
    if not notes:
        return ""
    items = "".join(f"<li>{escape(note.shown(output))}</li>" for note in notes)
    return f'<div class="warning"><b>Notes</b><ul>{items}</ul></div>\n'


def _heading(heading: Heading) -> str:
    own = heading.label.removeprefix(heading.name).strip(" ()")
    return escape(heading.name) + (f"<small>{escape(own)}</small>" if own else "")


def _list(notes: Iterable[str]) -> str:
    items = "".join(f"<li>{escape(note)}</li>" for note in notes)
    return f'<ul class="notes">{items}</ul>\n' if items else ""


def _tables(tables: Sequence[Table]) -> str:
    """One below the other; what holds for several is said once."""
    body, said = "", set[str]()
    for table in tables:
        body += _table(table) + _list(note for note in table.notes if note not in said)
        said.update(table.notes)
    return body


def _table(table: Table) -> str:
    head = "".join(f'<th scope="col">{_heading(column)}</th>' for column in table.columns)
    body = ""
    for row in table.rows:
        cells = "".join(_cell(table.cell(row, column), table.digits) for column in table.columns)
        body += f'<tr><th scope="row">{_heading(row)}</th>{cells}</tr>\n'
    return (
        f'<h3 id="{table.name}">{escape(table.title)}</h3>\n'
        f'<div class="wide"><table aria-labelledby="{table.name}">\n'
        f"<thead><tr><th></th>{head}</tr></thead>\n<tbody>\n{body}</tbody></table></div>\n"
    )


def _cell(cell: Cell, digits: int) -> str:
    text = value_text(cell, digits)
    text = f"<b>{text}</b>" if cell.best else text
    if cell.spread is not None:
        text += f" <small>({cell.spread.n})</small>"
    if cell.known is not None:
        text += f'<small class="beside">[{known_text(cell.known)}] {cell.mark}</small>'
    kind = "missing" if cell.spread is None else "best" if cell.best else ""
    return f'<td class="{kind}">{text}</td>' if kind else f"<td>{text}</td>"


def _curves(content: Content) -> str:
    body = ""
    for column in content.groups.columns:
        pairs = (("best return so far", content.learning), ("trials solved", content.solved))
        found = [(name, figures[column]) for name, figures in pairs if column in figures]
        plots = "".join(_plot(svg, f"{column.label}: {name}") for name, svg in found)
        body += f'<div class="pair">{plots}</div>\n' if plots else ""
    if not body:
        return ""
    return (
        "<p>The mean of the best return so far, with a band of one standard deviation that ends where the trials do,"
        " from where every trial has a design; then the share of trials that have come to the return named at the"
        " axis.</p>\n" + body
    )


def _plot(svg: bytes, name: str) -> str:
    return f'<figure class="plot"><img alt="{escape(name)}" src="{_inline(svg, "svg+xml")}"></figure>'


def _gallery(content: Content) -> str:
    if not content.shapes:
        return ""
    body = ""
    for column in content.groups.columns:
        cells = "".join(_shape(content, row, column) for row in content.groups.rows)
        body += f'<h3>{_heading(column)}</h3>\n<div class="shapes">{cells}</div>\n'
    return (
        "<p>The best folded shape of each searcher, with its return and seed; the best of each task is framed. Links"
        f" lead to the folder <code>designs</code> beside this page.</p>\n{body}"
    )


def _shape(content: Content, row: Heading, column: Heading) -> str:
    """A searcher's place in the row of a task, also if it has no design there: rows are compared."""
    shape = content.shapes.get((row, column))
    name = f"<b>{_heading(row)}</b>"
    if shape is None:
        return f'<figure class="missing"><div class="card">–</div><figcaption>{name}</figcaption></figure>'
    picture = _picture(shape.image, f"{column.label}, {row.label}")
    caption = f"{name}{escape(shape.caption)}{_links(content.designs[row, column])}"
    kind = ' class="first"' if shape.best else ""
    return f"<figure{kind}>{picture}<figcaption>{caption}</figcaption></figure>"


def _links(design: DesignFiles) -> str:
    """What its certificate says, and the files beside the page."""
    mark = ' class="refuted"' if design.verdict == REFUTED else ""
    said = escape(design.verdict)
    if design.certificate is not None:
        said = f'<a href="{design.certificate}">{said}</a>'
    links = f'<a href="{design.viewer}">turn and fold</a> · <a href="{design.pattern}">SVG</a>'
    return f'<br><span class="links"><span{mark}>{said}</span><br>{links}</span>'


def _patterns(content: Content) -> str:
    figures = "".join(
        f'<figure><div class="card"><img alt="crease pattern, {escape(column.label)}" src="{_inline(svg, "svg+xml")}">'
        f"</div><figcaption>{escape(_origin(column, content.motions[column]))}</figcaption></figure>\n"
        for column, svg in content.patterns.items()
    )
    return f'<p>Of the best design of each task.</p>\n<div class="patterns">{figures}</div>\n' if figures else ""


def _origin(column: Heading, motion: DrawnMotion) -> str:
    """Whose design it is."""
    value = number(motion.trial.value, 4)
    return f"{column.label}: {motion.row.label}, seed {motion.trial.seed}, return {value}"


def _motion(column: Heading, motion: DrawnMotion) -> str:
    steps = ""
    for image, angle in zip(motion.images, motion.angles, strict=True):
        shown = "" if angle is None else f"{number(angle, 1)}°"
        picture = _picture(image, f"{column.label} {shown}".strip())
        steps += f"<figure>{picture}<figcaption>{shown}</figcaption></figure>"
    return f'<h3>{escape(_origin(column, motion))}</h3>\n<div class="motion">{steps}</div>\n'


def _picture(image: Image.Image, name: str) -> str:
    stream = io.BytesIO()
    image.save(stream, format="PNG", optimize=True)
    return f'<div class="card"><img alt="{escape(name)}" src="{_inline(stream.getvalue(), "png")}"></div>'


def _inline(content: bytes, kind: str) -> str:
    return f"data:image/{kind};base64,{base64.b64encode(content).decode('ascii')}"


def _runs(runs: Sequence[Run], output: Path) -> str:
    """Where everything is from: folders, commands, versions."""
    body = ""
    for run in runs:
        statuses = [trial.status for trial in run.trials]
        trials = ", ".join(f"{statuses.count(status)} {status}" for status in sorted(set(statuses)))
        command = str(run.summary.get("command") or "")
        seconds = run.summary.get("seconds")
        took = f"{number(float(seconds), 0)} s" if isinstance(seconds, int | float) else "–"
        body += (
            f"<tr><td><code>{escape(relative(run.folder, output))}</code></td><td>{escape(run.task)}</td>"
            f"<td>{escape(run.method)}</td><td>{escape(trials)}</td><td>{took}</td>"
            f'<td class="command">{f"<code>{escape(command)}</code>" if command else "not known"}</td></tr>\n'
        )
    head = "".join(
        f'<th scope="col">{name}</th>' for name in ("folder", "task", "searcher", "trials", "took", "command")
    )
    return f'<div class="wide"><table><thead><tr>{head}</tr></thead>\n<tbody>\n{body}</tbody></table></div>\n' + _list(
        [*_versions(runs, output), "Folders are named from that of this page."]
    )


def _versions(runs: Sequence[Run], output: Path) -> list[str]:
    """What the runs were computed with, each set once."""
    found: dict[str, list[str]] = {}
    for run in runs:
        text = ", ".join(f"{name} {version}" for name, version in run.versions.items()) or "versions not known"
        found.setdefault(text, []).append(relative(run.folder, output))
    if len(found) == 1:
        return [f"Computed with {next(iter(found))}."]
    return [f"{', '.join(folders)}: {text}." for text, folders in found.items()]
