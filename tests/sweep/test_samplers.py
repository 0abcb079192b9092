"""A trial's parameters depend on the declaration, its place and what has finished: on nothing else."""

from __future__ import annotations

import math
from decimal import Decimal
from pathlib import Path
from typing import Any

import pytest
from hypothesis import given
from hypothesis import strategies as st
from optuna.trial import FrozenTrial, create_trial

from origami_lab.errors import InputError
from origami_lab.sweep.samplers import distribution, suggest
from origami_lab.sweep.search_space import Parameter, grid_points
from origami_lab.sweep.sweep_config import Declaration
from tests.sweep.conftest import declare

NO = InputError("x", 1, "too large")


def nothing_refused(point: object) -> None:
    return None


def points(declaration: Declaration, number: int) -> list[dict[str, Any]]:
    return [suggest(declaration, slot, [], nothing_refused)[0] for slot in range(number)]


def test_ranges_and_conditions(tmp_path: Path) -> None:
    declaration = declare(tmp_path)
    found = points(declaration, 60)
    assert {type(point["search.population"]) for point in found} == {int}
    assert all(6 <= point["search.population"] <= 24 for point in found)
    assert {point["search.rescale"] for point in found} == {True, False}
    assert all(("search.sigma_1" in point) == point["search.rescale"] for point in found)
    sigmas = [math.log10(point["search.sigma_1"]) for point in found if point["search.rescale"]]
    assert all(-2 <= sigma <= 0 for sigma in sigmas)
    below = sum(sigma < -1 for sigma in sigmas)  # half of them, on a logarithmic scale
    assert 0.25 < below / len(sigmas) < 0.75


def test_random_points_depend_on_seed_and_place_only(tmp_path: Path) -> None:
    declaration = declare(tmp_path)
    forwards = points(declaration, 5)
    backwards = [suggest(declaration, slot, history(declaration, 4), nothing_refused)[0] for slot in (4, 3, 2, 1, 0)]
    assert forwards == backwards[::-1]
    assert len({str(point) for point in forwards}) == 5
    other = declare(tmp_path, sampler={"name": "random", "seed": 4})
    assert points(other, 5) != forwards


def history(declaration: Declaration, number: int) -> list[FrozenTrial]:
    """Trials that are worth more, the larger their population."""
    found = []
    kinds = {parameter.name: distribution(parameter) for parameter in declaration.space}
    for point in points(declare_random(declaration), number):
        having = {name: kinds[name] for name in point}
        found.append(create_trial(params=point, distributions=having, value=float(point["search.population"])))
    return found


def declare_random(declaration: Declaration) -> Declaration:
    from dataclasses import replace

    return replace(declaration, sampler=replace(declaration.sampler, name="random"))


@pytest.mark.parametrize("name", ["tpe", "cmaes"])
def test_samplers_learn_from_the_history_and_repeat_themselves(tmp_path: Path, name: str) -> None:
    if name == "cmaes":
        pytest.importorskip("cmaes")
    # CMA-ES knows numbers only
    space = {"search.population": {"low": 6, "high": 200}, "search.sigma_1": {"low": 0.01, "high": 1.0}}
    declaration = declare(tmp_path, sampler={"name": name, "seed": 1, "startup": 4}, space=space)
    known: list[FrozenTrial] = []
    kinds = {parameter.name: distribution(parameter) for parameter in declaration.space}
    for slot in range(40):
        point, system = suggest(declaration, slot, known, nothing_refused)
        assert (point, system) == suggest(declaration, slot, known, nothing_refused)
        value = float(point["search.population"])
        known.append(create_trial(params=point, distributions=kinds, value=value, system_attrs=system))
    early, late = (sum(t.value for t in part if t.value) / 10 for part in (known[:10], known[-10:]))
    assert late > early + 30


def test_a_refused_point_is_drawn_again(tmp_path: Path) -> None:
    declaration = declare(tmp_path)
    first, _ = suggest(declaration, 0, [], nothing_refused)
    second, _ = suggest(declaration, 0, [], lambda point: NO if point == first else None)
    assert second != first
    with pytest.raises(InputError, match="none of 30 points that were drawn can be played: x=1: too large"):
        suggest(declaration, 0, [], lambda point: NO)


@given(
    first=st.integers(-200, 200),
    width=st.integers(1, 60),
    count=st.integers(1, 40),
    places=st.sampled_from([0, 1, 2, 3]),
)
def test_the_values_of_a_grid_are_those_of_the_range(first: int, width: int, count: int, places: int) -> None:
    def written(number: int) -> int | float:
        return number if places == 0 else float(Decimal(number).scaleb(-places))

    parameter = Parameter("x", low=written(first), high=written(first + count * width), step=written(width))
    found = parameter.values()
    assert found == tuple(written(first + number * width) for number in range(count + 1))
    kind = distribution(parameter)
    for value in found:
        create_trial(params={"x": value}, distributions={"x": kind}, value=0.0)  # Optuna takes it, too


def test_a_grid_is_played_once_over(tmp_path: Path) -> None:
    space = {"search.elite": {"low": 0, "high": 2}, "search.rescale": {"choices": [True, False]}}
    declaration = declare(tmp_path, trials=None, sampler={"name": "grid", "seed": 2}, space=space)
    found = [str(point) for point in points(declaration, 6)]
    assert sorted(found) == sorted(str(point) for point in grid_points(declaration.space))
    assert found != [str(point) for point in grid_points(declaration.space)]  # shuffled
