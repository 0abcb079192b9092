"""Whole changes in one kernel, against the same made step by step from Python."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest

from origami_lab.objectives.shape import ShapeObjective
from origami_lab.search.neighbourhood.covering import Covering
from origami_lab.search.neighbourhood.one_run import LocalRun
from origami_lab.search.neighbourhood.search import NeighbourhoodSearch
from origami_lab.search.problem import Problem
from origami_lab.search.random_stream import Draws
from tests.search.neighbourhood.step_by_step import StepByStep
from tests.search.neighbourhood.test_growth import CASES

SETTINGS = {"shift": 0.5, "flip": 0.3, "more": 0.6, "source": 0.1, "idle_changes": 6, "temperature": 0.02}


def course_of(kind: type[Covering], name: str, budget: int, **settings: Any) -> tuple[list[Any], Problem]:
    """Where a narrow and a wide run stand whenever they stop, and the next random number."""
    game, target, angle, threshold = CASES[name]
    distance = settings.pop("distance", "vertex")
    problem = Problem(game(), ShapeObjective(target(), distance), budget)
    numbers = NeighbourhoodSearch(**SETTINGS | settings)
    covering = kind(problem, Draws(np.random.default_rng(5)), numbers)
    found: list[Any] = []
    for wide in (False, True):
        run = LocalRun(angle, wide=wide, threshold=threshold)
        for _ in range(15):
            # most stops are within a change, which goes on until it is over
            covering.improve(run, problem.interactions + 60, patience=50)
            design = run.design
            table = () if design is None else (design.moves.tolist(), design.points.tolist(), design.places.tolist())
            rest = () if design is None else (design.own, design.uncovered.tolist())
            numbers_of_run = run.threshold, run.value, run.lowest, run.last, run.idle
            found.append((table, rest, numbers_of_run, problem.interactions, problem.places_evaluated))
    found.append(covering.draws.one())
    return found, problem


@pytest.mark.parametrize("look", [False, True])
@pytest.mark.parametrize("name", CASES)
def test_compiled_changes_are_those_made_step_by_step(name: str, look: bool) -> None:
    """Designs, counts and draws, to the last bit."""
    compiled, problem = course_of(Covering, name, 100_000, look=look)
    assert compiled == course_of(StepByStep, name, 100_000, look=look)[0]
    assert problem.improvements
    assert len({str(each) for each in compiled}) > 4


def test_many_cuts_and_growths_and_panels_that_count() -> None:
    """A change may need any number of draws, and a design is grown as often as asked for."""
    settings = {"more": 0.99, "shift": 0.1, "regrowths": 3, "distance": "surface"}
    assert course_of(Covering, "bowl", 100_000, **settings)[0] == course_of(StepByStep, "bowl", 100_000, **settings)[0]


@pytest.mark.parametrize("budget", [*range(1, 9), 100, 333])
def test_the_budget_ends_a_change_wherever_it_is(budget: int) -> None:
    compiled, problem = course_of(Covering, "bowl", budget)
    stepwise, other = course_of(StepByStep, "bowl", budget)
    assert compiled[:-1] == stepwise[:-1]
    assert problem.interactions == other.interactions == budget
    assert problem.outcome() == other.outcome()
