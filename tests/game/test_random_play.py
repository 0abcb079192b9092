"""A few random episodes of every kind; ``python -m benchmarks.random_play`` plays many.

Design page, section 9, items 6 and 8.
"""

from __future__ import annotations

import numpy as np
import pytest

from benchmarks.random_play import KINDS, STARTS, STATUSES, Configuration, play_and_check
from origami_lab.game.kernels.state import STATUS_NAMES

SYMMETRIES = [(start, symmetry) for start, (_, symmetries) in STARTS.items() for symmetry in symmetries]


@pytest.mark.parametrize(("start", "symmetry"), SYMMETRIES)
@pytest.mark.parametrize("growing", [False, True], ids=["plain", "growing"])
def test_random_play_keeps_every_invariant(start: str, symmetry: str, growing: bool) -> None:
    boards: list[tuple[int | tuple[int, int], float | None]] = [(9, None), (13, 2.9), (25, 2.9)]
    if symmetry != "xyd":
        boards.append(((13, 7), None))
    for board, length in boards:
        configuration = Configuration(symmetry, start, board, length, growing)
        tally = play_and_check(configuration, 16 if growing else 100, seed=2)
        assert not tally.violations, "\n".join(tally.violations)
        assert tally.statuses.sum() == (16 if growing else 100)


@pytest.mark.parametrize("symmetry", ["none", "y", "x", "xy", "xyd"])
@pytest.mark.parametrize("start", ["square", "bare-panel"])
@pytest.mark.parametrize("growing", [False, True], ids=["plain", "growing"])
def test_random_play_with_sources_on_the_boundary(start: str, symmetry: str, growing: bool) -> None:
    if symmetry not in STARTS[start][1]:
        pytest.skip("the panel does not have the symmetry")
    for board, length in ((9, None), (13, 2.9)):
        configuration = Configuration(symmetry, start, board, length, growing, "boundary")
        tally = play_and_check(configuration, 16 if growing else 100, seed=3)
        assert not tally.violations, "\n".join(tally.violations)
        assert tally.counts[KINDS.index("source on boundary")]


@pytest.mark.parametrize("symmetry", ["none", "y", "x", "xy", "xyd"])
@pytest.mark.parametrize("start", ["square", "any-crease", "bare-panel"])
@pytest.mark.parametrize("growing", [False, True], ids=["plain", "growing"])
def test_random_play_with_sectors_of_half_a_turn(start: str, symmetry: str, growing: bool) -> None:
    if symmetry not in STARTS[start][1]:
        pytest.skip("the start pattern does not have the symmetry")
    for board, length in ((9, None), (13, 2.9)):
        configuration = Configuration(symmetry, start, board, length, growing, "boundary", straight=True)
        tally = play_and_check(configuration, 16 if growing else 100, seed=4)
        assert not tally.violations, "\n".join(tally.violations)
        assert tally.counts[KINDS.index("straight on")]


def test_no_kind_of_move_is_silently_impossible() -> None:
    counts = np.zeros(len(KINDS), dtype=np.int64)
    for symmetry in ("y", "x", "xy"):
        counts += play_and_check(Configuration(symmetry, "square", 9, None), 400, seed=5).counts
    boundary = Configuration("xy", "square", 9, None, sources="boundary", straight=True)
    counts += play_and_check(boundary, 200, seed=5).counts
    missing = [kind for kind, count in zip(KINDS, counts, strict=True) if not count and kind != "taken back"]
    assert not missing


def test_status_names_agree() -> None:
    assert len(STATUSES) == len(STATUS_NAMES) + 1
