"""Habits of other programs that refute a file: what is said beside the refutation."""

from __future__ import annotations

import json
import math
from pathlib import Path

import numpy as np
import pytest

import origami_lab
from origami_lab.verification.certificate import Certificate
from tests.fold_format.corpus import Pattern, corpus
from tests.fold_format.dialects import DIALECTS, Fold

CORPUS = {name: pattern for name, pattern in corpus().items() if pattern.one_freedom}
every_pattern = pytest.mark.parametrize("pattern", CORPUS.values(), ids=CORPUS)
SWAP = dict(zip("MVmv", "VMvm", strict=True))


def verified(tmp_path: Path, fold: Fold) -> Certificate:
    (tmp_path / "a.fold").write_text(json.dumps(fold), encoding="utf-8")
    return origami_lab.verify(tmp_path / "a.fold")


def frames_of(fold: Fold) -> list[Fold]:
    return [fold, *fold.get("file_frames", [])]


def reversed_letters(fold: Fold) -> None:
    for frame in frames_of(fold):
        if "edges_assignment" in frame:
            frame["edges_assignment"] = [SWAP.get(letter, letter) for letter in frame["edges_assignment"]]


def reversed_angles(fold: Fold) -> None:
    for frame in frames_of(fold):
        if "edges_foldAngle" in frame:
            frame["edges_foldAngle"] = [-angle for angle in frame["edges_foldAngle"]]


def reversed_signs(fold: Fold) -> None:
    reversed_letters(fold)
    reversed_angles(fold)


@every_pattern
@pytest.mark.parametrize("spoil", [reversed_letters, reversed_angles, reversed_signs])
@pytest.mark.parametrize("dialect", ["children", "folded first", "clockwise", "chain"])
def test_reversed_signs(pattern: Pattern, spoil: object, dialect: str, tmp_path: Path) -> None:
    fold = DIALECTS[dialect].write(pattern)
    spoil(fold)  # type: ignore[operator]
    certificate = verified(tmp_path, fold)
    assert certificate.verdict == "refuted", certificate.words()
    assert "the other way round" in certificate.reason


@every_pattern
@pytest.mark.parametrize("spoil", [reversed_letters, reversed_angles])
@pytest.mark.parametrize("dialect", ["plain", "simulator"])
def test_letters_against_angles(pattern: Pattern, spoil: object, dialect: str, tmp_path: Path) -> None:
    """Without folded vertices letters and angles contradict each other."""
    fold = DIALECTS[dialect].write(pattern)
    key = "edges_foldAngle" if "edges_foldAngle" in fold else "edges_foldAngles"
    fold["edges_foldAngle"] = fold.pop(key)
    spoil(fold)  # type: ignore[operator]
    certificate = verified(tmp_path, fold)
    assert certificate.verdict == "refuted", certificate.words()
    assert "signs reversed" in certificate.reason


@every_pattern
@pytest.mark.parametrize("factor", [0.001, 25.4, 1000.0])
def test_scaled_states(pattern: Pattern, factor: float, tmp_path: Path) -> None:
    fold = DIALECTS["children"].write(pattern)
    for frame in fold["file_frames"]:
        frame["vertices_coords"] = (factor * np.array(frame["vertices_coords"])).tolist()
    certificate = verified(tmp_path, fold)
    assert certificate.verdict == "refuted", certificate.words()
    assert f"{factor:g} times as long" in certificate.reason


@every_pattern
def test_a_file_scaled_as_a_whole_is_as_good(pattern: Pattern, tmp_path: Path) -> None:
    for factor in (0.01, 25.4, 1e4):
        fold = DIALECTS["children"].write(pattern)
        for frame in frames_of(fold):
            frame["vertices_coords"] = (factor * np.array(frame["vertices_coords"])).tolist()
        assert verified(tmp_path, fold).verdict == "certified"


@every_pattern
def test_radians(pattern: Pattern, tmp_path: Path) -> None:
    fold = DIALECTS["children"].write(pattern)
    for frame in frames_of(fold):
        frame["edges_foldAngle"] = [math.radians(angle) for angle in frame["edges_foldAngle"]]
    certificate = verified(tmp_path, fold)
    assert certificate.verdict == "refuted", certificate.words()
    assert "radians" in certificate.reason


@every_pattern
@pytest.mark.parametrize("creator", ["", "Origami Simulator: http://git.amandaghassaei.com/OrigamiSimulator/"])
@pytest.mark.parametrize("which", ["turned", "last"])
def test_target_angles(pattern: Pattern, creator: str, which: str, tmp_path: Path) -> None:
    """A simulation's folded form bears what its creases are to come to: ±180°, or the last state's angles."""
    fold = DIALECTS["folded alone"].write(pattern)
    fold["file_creator"] = creator
    fold["vertices_coords"] = pattern.folded[0].tolist()
    if which == "turned":
        fold["edges_foldAngle"] = [{"V": 180.0, "M": -180.0}.get(letter, 0.0) for letter in pattern.letters]
    certificate = verified(tmp_path, fold)
    assert certificate.verdict == "refuted", certificate.words()
    assert "targets of a simulation" in certificate.reason
    assert ("Origami Simulator wrote this file" in certificate.reason) == bool(creator)


def test_targets_of_a_flat_pattern(tmp_path: Path) -> None:
    fold = DIALECTS["plain"].write(CORPUS["huffman (80.0, 95.0, 70.0, 115.0)"])
    fold["edges_foldAngle"] = [{"V": 180.0, "M": -180.0}.get(letter, 0.0) for letter in fold["edges_assignment"]]
    certificate = verified(tmp_path, fold)
    assert certificate.verdict == "refuted"
    assert "targets of a simulation" in certificate.reason


@every_pattern
def test_no_hint_where_none_is_due(pattern: Pattern, tmp_path: Path) -> None:
    """One crease that is wrong is a wrong design."""
    fold = DIALECTS["children"].write(pattern)
    creases = [e for e, letter in enumerate(pattern.letters) if letter != "B"]
    frame = fold["file_frames"][1]
    frame["edges_foldAngle"][creases[-1]] *= -1
    certificate = verified(tmp_path, fold)
    assert certificate.verdict == "refuted"
    if len(creases) > 1:
        assert "hint" not in certificate.reason, certificate.reason
