"""The motion of a trial out of its two files, and the state that is asked for."""

from __future__ import annotations

import dataclasses
from pathlib import Path

import numpy as np
import pytest

from origami_lab.errors import InputError
from origami_lab.fold_format.motion_frames import fold_path, read_even_motion, read_motion, state_at
from origami_lab.fold_format.writer import as_fold_file, write_fold
from origami_lab.game.crease_pattern import CreasePattern
from tests.known_designs import closed_forms as designs


def steps(design: CreasePattern, angles: np.ndarray) -> CreasePattern:
    """The valley's motion at other angles."""
    made = designs.single_valley()
    folded = made.folded[: len(angles)].copy()
    folded[:, 2:4, 0] = 1 + 2 * np.cos(angles)[:, None]
    folded[:, 2:4, 2] = 2 * np.sin(angles)[:, None]
    turned = np.where(made.boundary, 0.0, np.repeat(angles[:, None], len(made.edges), axis=1))
    return dataclasses.replace(
        made, driving_angles=angles, folded=folded, fold_angles=turned, best=len(angles) - 1, metadata=design.metadata
    )


def trial(folder: Path) -> Path:
    """best.fold has 10 angles, its best is the fifth; motion.fold goes up to that in eight steps."""
    design = designs.single_valley(best=4)
    write_fold(folder / "best.fold", design)
    write_fold(folder / "motion.fold", steps(design, np.linspace(0, design.driving_angles[4], 9)[1:]))
    return folder


def test_both_files_are_one_motion(tmp_path: Path) -> None:
    path = trial(tmp_path) / "best.fold"
    fold = read_motion(path)
    degrees = np.degrees([frame.driving_angle for frame in fold.motion])
    tenths = np.degrees(3.14) * np.arange(1, 11) / 10
    eighths = tenths[4] * np.arange(1, 9) / 8
    both = np.unique(np.round(np.concatenate([tenths, eighths]), 9))
    assert degrees == pytest.approx(both)
    assert np.degrees(fold.best.driving_angle) == pytest.approx(tenths[4])
    assert fold.assignments == fold.best.assignments
    assert read_motion(tmp_path).motion[0].driving_angle == fold.motion[0].driving_angle
    assert len(read_even_motion(path).frames) == 8
    for frame in fold.frames:
        rho = frame.driving_angle
        assert frame.coords[2] == pytest.approx([1 + 2 * np.cos(rho), -1, 2 * np.sin(rho)])


def test_what_does_not_belong_together_is_not_merged(tmp_path: Path) -> None:
    path = trial(tmp_path) / "best.fold"
    write_fold(tmp_path / "motion.fold", designs.pyramid())
    assert len(read_motion(path).frames) == 10
    assert read_even_motion(path).title == "valley, hand, seed 0"
    path.rename(tmp_path / "other.fold")
    assert len(read_motion(tmp_path / "other.fold").frames) == 10
    assert fold_path(tmp_path) == tmp_path  # no trial: no best.fold


def test_state_at() -> None:
    fold = as_fold_file(designs.single_valley(best=4))
    tenth = np.degrees(0.314)
    assert state_at(fold) is fold.best
    assert state_at(fold, 0.0).coords[:, 2].max() == 0.0
    for degrees, k in ((tenth, 1), (1.4 * tenth, 1), (1.6 * tenth, 2), (10 * tenth, 10), (0.6 * tenth, 1)):
        assert state_at(fold, degrees).driving_angle == pytest.approx(k * 0.314)
    assert state_at(fold, 0.4 * tenth).driving_angle == 0.0
    for degrees in (-1.0, 10 * tenth + 0.01, np.nan):
        with pytest.raises(InputError, match=r"angle=.*: must be from 0 to 179\.91 degrees"):
            state_at(fold, degrees)
    unknown = dataclasses.replace(fold, frames=(dataclasses.replace(fold.best, driving_angle=None),))
    assert state_at(unknown) is unknown.best
    assert state_at(unknown, 0.0).coords[:, 2].max() == 0.0
    with pytest.raises(InputError, match="angle=30: must be 0 or left out"):
        state_at(unknown, 30.0)
    flat = dataclasses.replace(fold, frames=())
    assert state_at(flat).driving_angle == 0.0
