"""What a file's digits say of its precision, and what verdicts make of it."""

from __future__ import annotations

import copy
import json
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

import origami_lab
from origami_lab.fold_format.file_digits import Precision, decimals, precision, rounding
from origami_lab.verification.certificate import Certificate
from tests.fold_format.corpus import Pattern, corpus
from tests.fold_format.dialects import DIALECTS, Fold

CORPUS = {name: pattern for name, pattern in corpus().items() if pattern.one_freedom}
CERTIFIED_FROM = 9
"""Decimals from which on each pattern of the corpus is certified in every dialect."""


@settings(max_examples=200, deadline=None)
@given(seed=st.integers(0, 10**6), digits=st.integers(4, 13), size=st.floats(0.5, 5000.0))
def test_fixed_decimals(seed: int, digits: int, size: float) -> None:
    """Half a unit of the last decimal, never less, and at most ten times that where large numbers have few digits."""
    values = np.round(np.random.default_rng(seed).uniform(-size, size, (20, 2)), digits)
    off = rounding(values)
    if digits + np.log10(np.abs(values).max()) < 14:
        assert 0.5 * 10.0**-digits <= off * (1 + 1e-9)
        assert off <= 50 * 10.0**-digits or off == 0.0


@settings(max_examples=200, deadline=None)
@given(seed=st.integers(0, 10**6), digits=st.integers(4, 13), size=st.floats(1e-3, 5000.0))
def test_significant_digits(seed: int, digits: int, size: float) -> None:
    """Numbers written with so many significant digits: what the largest ones may be off by is allowed for."""
    drawn = np.random.default_rng(seed).uniform(-size, size, 40) * 10.0 ** np.random.default_rng(seed).integers(
        -3, 1, 40
    )
    values = np.array([float(f"{x:.{digits}g}") for x in drawn])
    assert np.abs(values - drawn).max() <= rounding(values) * (1 + 1e-6)


@settings(max_examples=100, deadline=None)
@given(seed=st.integers(0, 10**6))
def test_all_digits_and_grids_are_exact(seed: int) -> None:
    rng = np.random.default_rng(seed)
    assert rounding(rng.uniform(-3, 3, (20, 3))) == 0.0
    for step in (1.0, 0.5, 0.25, 0.125, 0.1, 0.2):
        assert rounding(np.round(step * rng.integers(-20, 20, (20, 2)), 3)) == 0.0
    single = rng.uniform(-3, 3, (20, 3)).astype(np.float32).astype(float)
    assert 0.0 < rounding(single) < 1e-6


def test_words() -> None:
    known = Precision(flat=5e-7, folded=5e-5, angle=np.radians(5e-4))
    assert known.words() == "coordinates with 4 decimals and fold angles with 3 decimals"
    assert known.finer(100.0) == "coordinates with 6 decimals and fold angles with 5 decimals"
    assert Precision().exact
    assert [decimals(0.5 * 10.0**-k) for k in range(13)] == list(range(13))
    made = precision(np.array([[0.123456, 1.0]]), [np.array([[0.1234, 0.0, 1.0]])], [np.array([45.125, np.nan, 30.01])])
    assert made == Precision(5e-6, 5e-4, 0.0) or made.folded > made.flat


def rounded(fold: Fold, digits: int) -> Fold:
    out = copy.deepcopy(fold)
    for frame in (out, *out.get("file_frames", [])):
        for key in ("vertices_coords", "edges_foldAngle"):
            if key in frame:
                frame[key] = np.round(frame[key], digits).tolist()
    return out


def verdicts(fold: Fold, path: Path) -> list[Certificate]:
    found = []
    for digits in range(4, 13):
        path.write_text(json.dumps(rounded(fold, digits)), encoding="utf-8")
        found.append(origami_lab.verify(path))
    return found


@pytest.mark.parametrize("dialect", ["children", "plain", "folded alone", "tilted"])
@pytest.mark.parametrize("pattern", CORPUS.values(), ids=CORPUS)
def test_rounded_files_are_certified_or_too_imprecise(pattern: Pattern, dialect: str, tmp_path: Path) -> None:
    for digits, certificate in enumerate(verdicts(DIALECTS[dialect].write(pattern), tmp_path / "a.fold"), start=4):
        if digits >= CERTIFIED_FROM:
            assert certificate.verdict == "certified", (digits, certificate.words())
        else:
            assert certificate.verdict != "refuted", (digits, certificate.words())
        if certificate.verdict != "certified":
            assert "too imprecise to tell" in certificate.reason
            assert "would do" in certificate.reason


def bent(fold: Fold, rng: np.random.Generator) -> None:
    frame = fold["file_frames"][int(rng.integers(3))]
    frame["vertices_coords"][int(rng.integers(len(frame["vertices_coords"])))][int(rng.integers(3))] += 0.02


def wrong_angle(fold: Fold, rng: np.random.Generator) -> None:
    frame = fold["file_frames"][int(rng.integers(3))]
    creases = [e for e, letter in enumerate(fold["edges_assignment"]) if letter != "B"]
    frame["edges_foldAngle"][creases[int(rng.integers(len(creases)))]] += 1.5


def wrong_letter(fold: Fold, rng: np.random.Generator) -> None:
    creases = [e for e, letter in enumerate(fold["edges_assignment"]) if letter != "B"]
    e = creases[int(rng.integers(len(creases)))]
    fold["edges_assignment"][e] = {"M": "V", "V": "M"}[fold["edges_assignment"][e]]


def moved_vertex(fold: Fold, rng: np.random.Generator) -> None:
    fold["vertices_coords"][int(rng.integers(len(fold["vertices_coords"])))][0] += 0.02


@pytest.mark.parametrize("plant", [bent, wrong_angle, wrong_letter, moved_vertex])
@pytest.mark.parametrize("pattern", CORPUS.values(), ids=CORPUS)
def test_planted_faults_are_never_certified(pattern: Pattern, plant: object, tmp_path: Path) -> None:
    fold = DIALECTS["children"].write(pattern)
    plant(fold, np.random.default_rng(len(pattern.edges)))  # type: ignore[operator]
    found = verdicts(fold, tmp_path / "a.fold")
    assert all(certificate.verdict != "certified" for certificate in found), found[0].words()
    assert found[-1].verdict == "refuted"


@pytest.mark.parametrize("pattern", CORPUS.values(), ids=CORPUS)
def test_single_precision(pattern: Pattern, tmp_path: Path) -> None:
    """Coordinates that went through binary32, as simulators and GLB have them, with all digits that these have."""
    fold = DIALECTS["children"].write(pattern)
    for frame in (fold, *fold["file_frames"]):
        frame["vertices_coords"] = np.array(frame["vertices_coords"]).astype(np.float32).astype(float).tolist()
    (tmp_path / "a.fold").write_text(json.dumps(fold), encoding="utf-8")
    certificate = origami_lab.verify(tmp_path / "a.fold")
    assert certificate.verdict == "certified", certificate.words()
