"""What an objective may return."""

from __future__ import annotations

import math
from fractions import Fraction

import numpy as np
import pytest

from origami_lab.errors import InputError
from origami_lab.objectives.objective import Score, checked, number


@pytest.mark.parametrize("value", [2, 2.0, True + 1, np.float32(2), np.int8(2), np.array(2.0), Fraction(4, 2)])
def test_numbers_of_any_kind(value: object) -> None:
    assert number(value, "Mine", "score") == 2.0


@pytest.mark.parametrize("value", [None, "2", b"2", math.nan, np.nan, np.ones(1), [2.0], 2j, object(), 10**400])
def test_what_is_no_number(value: object) -> None:
    with pytest.raises(InputError, match=r"objective=Mine: score returned .*; it must return a number$"):
        number(value, "Mine", "score")


def test_the_worst_score_is_one_and_the_best_is_not() -> None:
    assert checked(Score(-math.inf, -1), 1, 3, "Mine") == Score(-math.inf, -1)
    assert checked(Score(np.float64(1), np.int64(2)), 1, 3, "Mine") == Score(1.0, 2)  # type: ignore[arg-type]
    for score in (Score(math.inf, 1), Score(1.0, 0), Score(1.0, 3), Score(1.0, -2), Score(1.0, 0.5)):  # type: ignore[arg-type]
        with pytest.raises(InputError, match="objective=Mine: score returned"):
            checked(score, 1, 3, "Mine")
