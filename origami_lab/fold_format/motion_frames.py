"""A design's whole motion from the files of a trial, and one state of it."""

from __future__ import annotations

import dataclasses
import math
import os
from pathlib import Path

import numpy as np

from origami_lab.errors import InputError
from origami_lab.fold_format.fold_file import FoldFile, FoldFrame
from origami_lab.fold_format.reader import read_fold

_SAME = 1e-9
"""Driving angles, radians, and coordinates, cells, that are the same in two files."""


def read_motion(path: str | os.PathLike[str]) -> FoldFile:
    """Read a FOLD file; beside a trial's ``best.fold``, the fine steps of its ``motion.fold`` too.

    The folded forms of both come by increasing driving angle, the best one last; one that both have is that of
    ``best.fold``. ``path`` may also be the folder of the trial. Raises :class:`InputError`, whose field is the path, on
    anything that is not such a file.
    """
    fold, motion = _read(path)
    return fold if motion is None else with_motion(fold, motion)


def with_motion(fold: FoldFile, motion: FoldFile) -> FoldFile:
    """A file with the folded forms of another one of the same pattern, too, as :func:`read_motion` puts them."""
    known = [_driving(frame) for frame in fold.frames]
    added = [frame for frame in motion.frames if min(abs(_driving(frame) - angle) for angle in known) > _SAME]
    before = sorted([*fold.frames[:-1], *added], key=lambda frame: abs(_driving(frame)))
    return dataclasses.replace(fold, frames=(*before, fold.best))


def read_even_motion(path: str | os.PathLike[str]) -> FoldFile:
    """As :func:`read_motion`, but with the steps of one file only, which are evenly spaced: for films."""
    fold, motion = _read(path)
    return motion or fold


def fold_path(path: str | os.PathLike[str]) -> Path:
    """``best.fold`` if ``path`` is the folder of a trial, else ``path``."""
    path = Path(path)
    return path / "best.fold" if (path / "best.fold").is_file() else path


def _read(path: str | os.PathLike[str]) -> tuple[FoldFile, FoldFile | None]:
    """A file, and the motion beside it: of the same pattern, with a driving angle for each folded form, or None."""
    path = fold_path(path)
    fold, beside = read_fold(path), path.with_name("motion.fold")
    if path.name != "best.fold" or not beside.is_file():
        return fold, None
    motion = read_fold(beside)
    same = (
        np.array_equal(fold.edges, motion.edges)
        and fold.vertices.shape == motion.vertices.shape
        and np.allclose(fold.vertices, motion.vertices, rtol=0, atol=_SAME)
    )
    known = all(frame.driving_angle is not None for frame in (*fold.frames, *motion.frames))
    return fold, motion if same and known and fold.frames and motion.frames else None


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
