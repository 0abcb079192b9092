"""The page of a multirun: its jobs side by side, each read from the data of its own page."""

from __future__ import annotations

from contextlib import suppress
from pathlib import Path
from typing import TYPE_CHECKING

from origami_lab.errors import InputError
from origami_lab.file_names import PAGE, PAGE_DATA
from origami_lab.files import regular_bytes, write_whole
from origami_lab.runs.multirun_folder import TABLE, Index, read_index
from origami_lab.runs.run_folder import RunFolder
from origami_lab.text import command_text

if TYPE_CHECKING:
    from origami_lab.config.node import Node
    from origami_lab.runs.multirun_folder import PlannedJob

LARGEST_PAGE = 2**26
MOST_NAMED = 4
"""Tasks, and searchers, that the heading names."""


def write_multirun_page(folder: Path) -> None:
    """Write the page of a multirun's folder, unless it is there already as it would be; raises OSError.

    It holds no result: what its jobs come to it takes from their own pages, while they run, too.
    """
    index = read_index(folder)
    if index is None:
        return
    text = multirun_page_text(index, folder)
    try:
        if regular_bytes(folder / PAGE, LARGEST_PAGE) == text.encode():
            return
    except FileNotFoundError:
        pass
    write_whole(folder / PAGE, text)


def multirun_page_text(index: Index, folder: Path) -> str:
    """The page as text."""
    from origami_lab.pages import page_text
    from origami_lab.tracking.tracker import commands_to_look

    tasks, methods = ({getattr(job, kind) for job in index.jobs} for kind in ("task", "method"))
    common = [", ".join(sorted(names)) for names in (tasks, methods) if len(names) <= MOST_NAMED]
    values = {
        "kind": "multirun",
        "name": " · ".join([*common, f"{len(index.jobs)} job{'' if len(index.jobs) == 1 else 's'}"]),
        "experiment": index.experiment,
        "jobs": [{"folder": job.folder, "name": _name(job, tasks, methods), "task": job.task} for job in index.jobs],
        "data": f"{PAGE_DATA}/live.js",
        "table": TABLE,
        "report": command_text(["origami-lab", "report", str(folder)]),
        "look": commands_to_look(_config_of_a_job(index, folder).get("tracking") or {}, folder),
    }
    return page_text(
        __package__,
        "multirun_page.html.jinja",
        values,
        scripts=[Path(__file__).with_name("multirun_page.js")],
    )


def _config_of_a_job(index: Index, folder: Path) -> Node:
    """The configuration of the first job that has one; empty if none has begun."""
    for job in index.jobs:
        with suppress(InputError, OSError):
            return RunFolder(folder / job.folder).config()
    return {}


def _name(job: PlannedJob, tasks: set[str], methods: set[str]) -> str:
    """What tells a job from the others."""
    named = [*([job.task] if len(tasks) > 1 else []), *([job.method] if len(methods) > 1 else []), *job.own]
    return " · ".join(named) or job.name
