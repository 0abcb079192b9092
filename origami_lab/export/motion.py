"""A design's whole motion from the files of a trial, and one state of it."""

from __future__ import annotations

import dataclasses
import math
import os
from pathlib import Path

import numpy as np

from origami_lab.errors import InputError
from origami_lab.export.foldfile import FoldFile, FoldFrame
from origami_lab.export.reading import read_fold

_SAME = 1e-9
"""Driving angles, radians, and coordinates, cells, that are the same in two files."""


def read_motion(path: str | os.PathLike[str]) -> FoldFile:
    """Read a FOLD file; beside a trial's ``best.fold``, the fine steps of its ``motion.fold`` too.

    ``path`` may also be the folder of the trial. Raises :class:`InputError`, whose field is the path, on anything
    that is not such a file.
    """
    path = fold_path(path)
    fold, beside = read_fold(path), _beside(path)
    return fold if beside is None else merge_motion(fold, read_fold(beside))


def read_even_motion(path: str | os.PathLike[str]) -> FoldFile:
    """As :func:`read_motion`, but with the steps of one file only, which are evenly spaced: for films."""
    path = fold_path(path)
    return read_fold(_beside(path) or path)


def fold_path(path: str | os.PathLike[str]) -> Path:
    """``best.fold`` if ``path`` is the folder of a trial, else ``path``."""
    path = Path(path)
    return path / "best.fold" if (path / "best.fold").is_file() else path


def _beside(path: Path) -> Path | None:
    """The fine steps of a trial's best design, where there are any."""
    file = path.with_name("motion.fold")
    return file if path.name == "best.fold" and file.is_file() else None


def merge_motion(fold: FoldFile, motion: FoldFile) -> FoldFile:
    """``fold`` with the folded forms of both, by increasing driving angle, its best one last.

    Forms that both have are ``fold``'s. A motion of another pattern, or without driving angles, adds nothing.
    """
    same = (
        np.array_equal(fold.edges, motion.edges)
        and fold.vertices.shape == motion.vertices.shape
        and np.allclose(fold.vertices, motion.vertices, rtol=0, atol=_SAME)
    )
    frames = [*fold.frames, *motion.frames]
    if not same or not fold.frames or any(frame.driving_angle is None for frame in frames):
        return fold
    known = [_driving(frame) for frame in fold.frames]
    added = [frame for frame in motion.frames if min(abs(_driving(frame) - angle) for angle in known) > _SAME]
    before = sorted([*fold.frames[:-1], *added], key=lambda frame: abs(_driving(frame)))
    return dataclasses.replace(fold, frames=(*before, fold.best))


def state_at(fold: FoldFile, degrees: float | None = None) -> FoldFrame:
    """The stored folded form whose driving angle is nearest to ``degrees``; the best one by default.

    0 is the flat sheet. Nothing is interpolated: that would stretch the panels. Raises :class:`InputError`, with the
    field ``angle``, outside what is stored.
    """
    if degrees is None:
        return fold.best
    if any(frame.driving_angle is None for frame in fold.frames):
        if degrees == 0.0:
            return fold.flat
        raise InputError("angle", f"{degrees:g}", "must be 0 or left out: the file does not say its driving angles")
    states = [fold.flat, *fold.frames]
    largest = max(abs(math.degrees(_driving(frame))) for frame in states)
    if not 0.0 <= degrees <= largest + 0.005:  # as it is printed, with two decimals
        raise InputError("angle", f"{degrees:g}", f"must be from 0 to {largest:.2f} degrees, as far as the file folds")
    return min(states, key=lambda frame: abs(abs(math.degrees(_driving(frame))) - degrees))


def _driving(frame: FoldFrame) -> float:
    """The driving angle, where the file says one."""
    return 0.0 if frame.driving_angle is None else frame.driving_angle
