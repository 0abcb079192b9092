"""The grammar of seeds."""

from __future__ import annotations

from contextlib import suppress

import pytest
from hypothesis import given
from hypothesis import strategies as st

from origami_lab.config.seeds import MOST, format_seeds, parse_seeds
from origami_lab.errors import InputError

seeds = st.integers(0, 2**63 - 1)


@pytest.mark.parametrize(
    ("written", "meant"),
    [
        (3, (3,)),
        ("3", (3,)),
        (0, (0,)),
        ("0..9", tuple(range(10))),
        ("4..4", (4,)),
        (" 1 .. 3 ", (1, 2, 3)),
        ([0, 3, 7], (0, 3, 7)),
        ([7, 0], (7, 0)),
    ],
)
def test_forms(written: object, meant: tuple[int, ...]) -> None:
    assert parse_seeds(written) == meant


@pytest.mark.parametrize(
    "written",
    [
        *("9..0", "abc", "", "1..", "..3", "1...3", "0,3", "-1", "-2..3", f"0..{MOST}", "0..9..12", "1-3"),
        *([], [0, 0], [1, "2"], [1, -2], [True], {"a": 1}),
        *(-1, True, None, 1.5, 2**63),
    ],
)
def test_refused_with_the_value_and_what_would_be_right(written: object) -> None:
    with pytest.raises(InputError) as refused:
        parse_seeds(written)
    message = str(refused.value)
    assert message.startswith("seed=")
    assert "must" in message
    assert "\n" not in message


def test_a_backward_range_is_turned_round() -> None:
    with pytest.raises(InputError, match=r"seed=9\.\.0: .*0\.\.9"):
        parse_seeds("9..0")


@given(st.lists(seeds, min_size=1, max_size=20, unique=True))
def test_lists_survive_being_written(values: list[int]) -> None:
    assert parse_seeds(format_seeds(values)) == tuple(values)


@given(seeds.filter(lambda seed: seed < 2**63 - 100), st.integers(0, 50))
def test_ranges_survive_being_written(first: int, length: int) -> None:
    values = tuple(range(first, first + length + 1))
    assert parse_seeds(f"{first}..{first + length}") == values
    assert parse_seeds(format_seeds(values)) == values


@given(st.text() | st.from_regex(r"-?\d{1,6}\.\.-?\d{1,6}") | st.lists(st.integers() | st.text()) | st.floats())
def test_anything_is_read_or_refused(value: object) -> None:
    with suppress(InputError):
        assert all(seed >= 0 for seed in parse_seeds(value))
