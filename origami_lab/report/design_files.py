"""The designs of the gallery as files beside the page: a viewer, the crease pattern, the certificate.

A viewer is a page of its own. What all have in common, 600 kB, is there once; each adds its design, and its target.
"""

from __future__ import annotations

import json
from collections.abc import Callable, Mapping
from contextlib import suppress
from dataclasses import dataclass
from urllib.parse import quote

from origami_lab.drawing.viewer import viewer_page, viewer_script
from origami_lab.errors import InputError
from origami_lab.export.svg import svg_text
from origami_lab.file_names import POLISHED
from origami_lab.fold_format.fold_file import FoldFile
from origami_lab.fold_format.motion_frames import read_motion
from origami_lab.fold_format.writer import read_fold
from origami_lab.report.gallery import Shape, read_target_of
from origami_lab.report.run_groups import Heading
from origami_lab.report.run_reader import Trial
from origami_lab.runs.trial_row import NOT_CHECKED, VERDICTS

DESIGNS = "designs"
SCRIPT = "viewer.js"
UNKNOWN = "no certificate"


@dataclass(frozen=True)
class DesignFiles:
    """A design's files, and what its certificate says."""

    viewer: str
    pattern: str
    """Addresses, as seen from the page."""
    certificate: str | None
    """None where there is none."""
    verdict: str
    """One of ``VERDICTS``, what its row says where there is no certificate, or :data:`UNKNOWN`."""
    polished: str | None = None
    """The viewer of the design that was polished off the grid; None where there is none."""


def write_designs(
    shapes: Mapping[tuple[Heading, Heading], Shape], stem: Callable[[str, str], str], files: dict[str, str | bytes]
) -> dict[tuple[Heading, Heading], DesignFiles]:
    """Add the files of all shapes to ``files``; where they are, by row and column.

    Parameters
    ----------
    stem
        Makes a name of its own from a kind and a label.
    """
    found = {}
    for (row, column), shape in shapes.items():
        name = f"{DESIGNS}/{stem('best', f'{column.label} {row.label}')}"
        try:
            fold = read_motion(shape.trial.folder)
        except InputError:
            fold = shape.fold
        target = read_target_of([shape.trial], [])
        files |= {f"{name}.html": viewer_page(fold, target, script=SCRIPT), f"{name}.svg": svg_text(fold, fold.best)}
        text, verdict = _certificate(shape.trial)
        if text is not None:
            files[f"{name}.json"] = text
        address = quote(name)
        polished = _polished(shape.trial)
        if polished is not None:
            files[f"{name}-polished.html"] = viewer_page(polished, target, script=SCRIPT)
        found[row, column] = DesignFiles(
            f"{address}.html",
            f"{address}.svg",
            None if text is None else f"{address}.json",
            verdict,
            None if polished is None else f"{address}-polished.html",
        )
    if found:
        files[f"{DESIGNS}/{SCRIPT}"] = viewer_script()
    return found


def _polished(trial: Trial) -> FoldFile | None:
    """A trial's polished design, if its row has one that can be read."""
    if trial.row.polished_return is None:
        return None
    with suppress(InputError):
        return read_fold(trial.folder / f"{POLISHED}.fold")
    return None


def _certificate(trial: Trial) -> tuple[str | None, str]:
    """A trial's certificate, if it can be read, and its verdict; nothing is verified here."""
    try:
        text = (trial.folder / "certificate.json").read_text(encoding="utf-8")
        verdict = json.loads(text)["verdict"]
    except (OSError, ValueError, KeyError, TypeError, RecursionError):
        return None, NOT_CHECKED if trial.row.certificate == NOT_CHECKED else UNKNOWN
    return (text, str(verdict)) if verdict in VERDICTS else (None, UNKNOWN)
