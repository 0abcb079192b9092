"""From run folders to a folder with tables, figures and a page."""

from __future__ import annotations

import json
import re
import tempfile
from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path

from matplotlib.figure import Figure

from origami_lab.drawing.figures import png_and_svg
from origami_lab.drawing.pattern_picture import pattern_figure
from origami_lab.errors import InputError
from origami_lab.files import read_json, regular_bytes, remove_files, require_no_link, write_whole
from origami_lab.report.design_files import DESIGNS, write_designs
from origami_lab.report.gallery import best_shape, draw_motion, draw_shapes, gallery_figure, motion_figure
from origami_lab.report.known_values import KnownValues
from origami_lab.report.learning_curves import learning_figure, read_curves, solved_figure, threshold_of
from origami_lab.report.page import GENERATOR, Content, render
from origami_lab.report.run_groups import Groups, group_runs
from origami_lab.report.run_reader import Note, Run, read_runs
from origami_lab.report.table_formats import csv_text, latex, many, markdown
from origami_lab.report.tables import Table, interactions_table, return_tables

FIGURES = "figures"
LARGEST_PAGE = 2**30
"""Bytes of a page that is looked at: its pictures are in it."""
PAGE, MANIFEST = "index.html", "files.json"
"""The page, and the list of all files of a report: an own one, by which a later report knows what it may remove."""
_OF_0_1_0 = {
    FIGURES: re.compile(r"(learning|solved|gallery|pattern|motion)(-[\w.=-]+)?\.(png|svg)"),
    DESIGNS: re.compile(r"best-[\w.=-]+\.(html|svg|json)|viewer\.js"),
}
"""Names of files that reports of version 0.1.0 have drawn, which had no list."""


@dataclass(frozen=True)
class Report:
    """Files that were written."""

    output: Path
    runs: Sequence[Run]
    notes: Sequence[Note]

    def __str__(self) -> str:
        trials = sum(len(run.trials) for run in self.runs)
        return f"{many(trials, 'trial')} of {many(len(self.runs), 'run')}: {self.output / 'index.html'}"


def build_report(
    directories: Sequence[Path],
    output: Path | None = None,
    beside: KnownValues | None = None,
    solved: float | None = None,
    say: Callable[[str], None] = lambda line: None,
) -> Report:
    """Read all runs at or below some directories and write the report on them.

    Parameters
    ----------
    output
        The folder to write to: a new or empty one, or that of an earlier report; None for ``report`` in the first
        directory.
    beside
        Values to print beside ours.
    solved
        The return at which a trial counts as solved; None for nearly the best of any trial of the task.
    say
        Takes lines about the progress.

    Raises
    ------
    InputError
        If there is nothing to report on, or the folder cannot be written.
    """
    runs, notes = read_runs(directories)
    output = directories[0] / "report" if output is None else output
    _check_output(output)
    groups = group_runs(runs)
    notes += groups.notes
    returns, interactions = return_tables(groups, beside), interactions_table(groups, beside)
    files = _Files()
    files.add_tables("returns", returns, groups)
    files.add_tables("interactions", [interactions], groups)
    say(f"{many(len(runs), 'run')} found; drawing the curves")
    curves = read_curves(groups, notes)
    learning, reached = {}, {}
    for column in groups.columns:
        if not any(place[1] == column for place in curves):
            continue
        learning[column] = files.add_figure("learning", column.label, learning_figure(groups, column, curves))
        threshold = threshold_of(groups, column, curves) if solved is None else solved
        if threshold is not None:
            figure = solved_figure(groups, column, curves, threshold)
            reached[column] = files.add_figure("solved", column.label, figure)
        elif groups.best_of(column) is not None:
            notes.append(Note(f"{column.label}: no curve of solved trials, the first design of each is as good as any"))
    say("drawing the designs")
    shapes = draw_shapes(groups, notes)
    beside_page = write_designs(shapes, files.stem, files.contents)
    patterns, motions = {}, {}
    if shapes:
        files.add_figure("gallery", "", gallery_figure(groups, shapes))
    for column in groups.columns:
        best = best_shape(groups, column, shapes)
        if best is not None:
            patterns[column] = files.add_figure("pattern", column.label, pattern_figure(best[1].fold))
            motions[column] = draw_motion(*best, notes)
            files.add_figure("motion", column.label, motion_figure(motions[column], column))
    tables = [*returns, interactions]
    below = {note for table in tables for note in table.notes}
    above = tuple(note for note in notes if f"{note.text}." not in below)
    content = Content(runs, groups, tables, learning, reached, shapes, beside_page, patterns, motions, above)
    _write(output, {PAGE: render(content, output), **files.contents})
    return Report(output, runs, notes)


class _Files:
    """Files to be written, by name."""

    def __init__(self) -> None:
        self.contents: dict[str, str | bytes] = {}
        self._stems: set[str] = set()

    def add_tables(self, name: str, tables: Sequence[Table], groups: Groups) -> None:
        self.contents[f"{name}.md"] = markdown(tables)
        self.contents[f"{name}.csv"] = csv_text(tables, groups)
        self.contents[f"{name}.tex"] = latex(tables)

    def add_figure(self, kind: str, label: str, figure: Figure) -> bytes:
        """Returns the figure as SVG."""
        stem = self.stem(kind, label)
        png, svg = png_and_svg(figure)
        self.contents |= {f"{FIGURES}/{stem}.png": png, f"{FIGURES}/{stem}.svg": svg}
        return svg

    def stem(self, kind: str, label: str) -> str:
        """A name that no two figures share."""
        stem = name = "-".join([kind, *re.findall(r"[\w.=]+", label)])
        number = 1
        while name.casefold() in self._stems:
            number += 1
            name = f"{stem}-{number}"
        self._stems.add(name.casefold())
        return name


def _check_output(output: Path) -> None:
    """Raise InputError unless a report may be written there, before anything is drawn."""
    try:
        if output.exists() and any(output.iterdir()) and not _is_ours(output):
            raise InputError("--output", output, "must be a new or empty folder, or that of an earlier report")
        output.mkdir(parents=True, exist_ok=True)
        for folder in (FIGURES, DESIGNS):
            require_no_link(output, folder)
        tempfile.TemporaryFile(dir=output).close()
    except OSError as error:
        raise _unwritable(output, error) from error


def _is_ours(output: Path) -> bool:
    try:
        page = regular_bytes(require_no_link(output, PAGE), LARGEST_PAGE)
    except OSError:
        return False
    return GENERATOR in page[:1000].decode("utf-8", "replace")


def _earlier_files(output: Path) -> list[str]:
    """The drawn files of the report that is there: those of its list or, without one, those that are known by name."""
    try:
        listed = read_json(require_no_link(output, MANIFEST))["files"]
        return [name for name in listed if isinstance(name, str) and name.partition("/")[0] in (FIGURES, DESIGNS)]
    except FileNotFoundError:
        folders = [folder for folder in _OF_0_1_0 if (output / folder).is_dir() and not (output / folder).is_symlink()]
        there = ((folder, file.name) for folder in folders for file in (output / folder).iterdir())
        return [f"{folder}/{name}" for folder, name in there if _OF_0_1_0[folder].fullmatch(name)]
    except (OSError, ValueError, KeyError, TypeError):
        return []


def _unwritable(output: Path, error: OSError) -> InputError:
    return InputError("--output", output, f"must be a folder that can be written ({error.strerror or error})")


def _write(output: Path, files: Mapping[str, str | bytes]) -> None:
    """Write the files, the page first, and remove what an earlier report has drawn and this one has not."""
    try:
        earlier = _earlier_files(output)
        for folder in {Path(name).parent for name in files}:
            require_no_link(output, folder).mkdir(exist_ok=True)
        _write_list(output, [*files, *earlier])
        for name, content in files.items():
            write_whole(output / name, content, sync=True)
        remove_files(output, [name for name in earlier if name not in files])
        _write_list(output, files)
    except OSError as error:
        raise _unwritable(output, error) from error


def _write_list(output: Path, names: Iterable[str]) -> None:
    """Write the list of a report's files; while it is being written also those of the report before."""
    write_whole(output / MANIFEST, json.dumps({"files": sorted({MANIFEST, *names})}, indent=1) + "\n", sync=True)
