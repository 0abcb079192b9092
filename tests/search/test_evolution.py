"""EVO: what an agent plays, who reproduces, and how the next generation comes about."""

from __future__ import annotations

import numpy as np
import pytest

from origami_lab.errors import InputError
from origami_lab.game.game import Game
from origami_lab.game.kernels.state import SELECTION
from origami_lab.game.start_patterns import Square
from origami_lab.objectives.shape import ShapeObjective
from origami_lab.search.evolution import EvolutionarySearch, Tournament, value_slots
from origami_lab.search.problem import Problem
from origami_lab.targets.solids import cube, pyramid


def game(symmetry: str = "xy") -> Game:
    return Game(13, symmetry, Square("choose"))


def cube_problem(budget: int) -> Problem:
    return Problem(Game(9, "xy", Square(1), max_crease_length=2), ShapeObjective(cube()), budget)


@pytest.mark.parametrize(("symmetry", "d"), [("xy", 49), ("y", 91), ("none", 169), ("xyd", 28)])
def test_a_vector_has_the_papers_entries_and_one_for_each_other_action(symmetry: str, d: int) -> None:
    """49 on a 13×13 board with two axes is the paper's example."""
    slots = value_slots(game(symmetry))
    placements = 2 * 5  # half-widths 1 to 5, two signs
    assert slots.max() + 1 == 4 * d + 1 + 4 + placements
    assert set(slots[slots >= 0]) == set(range(slots.max() + 1))
    for row in slots:
        used = row[row >= 0]
        assert len(set(used)) == len(used) == 3 * d + 1 + 4 + placements


@pytest.mark.parametrize("symmetry", ["none", "xy", "xyd"])
def test_an_agent_plays_the_legal_action_it_values_most(symmetry: str) -> None:
    """Against plain Python that keeps the values in a dictionary."""
    board = game(symmetry)
    points = [
        (x, y)
        for y in range(-6, 7)
        for x in range(-6, 7)
        if board.symmetry.playable(np.array([[x, y]]))[0]  # row by row, as the vector's docstring says
    ]
    problem = Problem(board, ShapeObjective(cube()), 10**6)
    arena = Tournament(problem, value_slots(board), 1)
    rng = np.random.default_rng(4)
    locations = {-1: 0, 1: 0}
    for _ in range(20):
        values = rng.standard_normal(int(arena.slots.max()) + 1)
        entry: dict[tuple[str, int, tuple[int, int]], float] = {}
        blocks = [("select", -1), ("select", 1), ("locate", -1), ("locate", 1)]
        for block, (kind, mode) in enumerate(blocks):
            for number, point in enumerate(points):
                entry[kind, mode, point] = values[block * len(points) + number]
        played = np.frombuffer(arena.play(values), dtype=np.int32)
        assert len(played) >= 3
        states, mode = board.new_states(), 0
        for action in played:
            worth = {}
            for candidate in board.legal(states).tolist():
                x, y = candidate % 169 % 13 - 6, candidate % 169 // 13 - 6
                if candidate >= 3 * 169:
                    worth[candidate] = values[4 * len(points) + candidate - 3 * 169]
                elif candidate >= 2 * 169:
                    worth[candidate] = entry["locate", mode, (x, y)]
                else:
                    worth[candidate] = entry["select", 1 if candidate >= 169 else -1, (x, y)]
            assert action == max(worth, key=lambda candidate: worth[candidate])
            if int(states["phase"][0]) == SELECTION:
                mode = 1 if action >= 169 else -1
            elif int(states["phase"][0]) > SELECTION:
                locations[mode] += 1
            board.play(states, int(action))
        assert len(board.legal(states)) == 0
    assert min(locations.values()) > 0


def test_the_best_reproduce_and_the_rest_is_discarded() -> None:
    searcher = EvolutionarySearch(population=8, parents=0.25, sigma_1=0.0, sigma_2=0.0, sigma_3=0.0, rescale=False)
    agents = np.repeat(np.arange(8.0)[:, None], 5, axis=1)
    returns = np.array([-3.0, -np.inf, -1.0, -2.0, -5.0, -9.0, -7.0, -np.inf])
    following = searcher.next_generation(agents, returns, np.random.default_rng(0))
    assert following.shape == agents.shape
    assert following[:6, 0].tolist() == [2, 3, 2, 3, 2, 3]
    assert not np.isin(following[6:], agents).any()


def test_of_equal_agents_each_is_as_likely_a_parent() -> None:
    searcher = EvolutionarySearch(population=8, parents=0.25, sigma_1=0.0, sigma_2=0.0, sigma_3=0.0, rescale=False)
    agents = np.repeat(np.arange(8.0)[:, None], 5, axis=1)
    returns = np.array([-3.0, -0.5, -1.0, -2.0, -1.0, -np.inf, -1.0, -1.0])
    rng = np.random.default_rng(0)
    chosen = np.array([searcher.next_generation(agents, returns, rng)[:2, 0] for _ in range(4000)], dtype=int)
    assert (chosen[:, 0] == 1).all()
    counts = np.bincount(chosen[:, 1], minlength=8)
    assert counts[[2, 4, 6, 7]] == pytest.approx(1000, abs=110)  # 4 standard deviations
    assert counts.sum() == counts[[2, 4, 6, 7]].sum()


def test_rescaled_parents_play_as_they_did_and_mutate_by_the_same_measure() -> None:
    still = EvolutionarySearch(population=16, sigma_1=0.0, sigma_2=0.0, rescale=True)
    rng = np.random.default_rng(5)
    problem = cube_problem(10**6)
    arena = Tournament(problem, value_slots(problem.game), 4)
    agents = 3.0 + 20.0 * rng.standard_normal((16, int(arena.slots.max()) + 1))
    before = agents.copy()
    following = still.next_generation(agents, -np.arange(16.0), rng)
    assert (agents == before).all()
    assert np.allclose(following[:4].mean(axis=1), 0.0)
    assert np.allclose(following[:4].std(axis=1), 1.0)
    assert [arena.play(values) for values in following[:4]] == [arena.play(values) for values in agents[:4]]
    # the most mutated copies are the best, always
    returns = np.repeat([0.0, 0.0, 1.0, 0.0], 4)
    for rescale in (True, False):
        searcher = EvolutionarySearch(population=16, rescale=rescale)
        for _ in range(200):
            agents = searcher.next_generation(agents, returns, rng)
        spread = agents[:4].std(axis=1)
        assert (spread.max() < 2.0) if rescale else (spread.min() > 10.0)  # √(200 (0.1² + 1²)) = 14


def test_mutations_have_the_standard_deviations_asked_for() -> None:
    searcher = EvolutionarySearch(population=100, parents=0.25, sigma_1=0.1, sigma_2=0.5, sigma_3=2.0, rescale=False)
    rng = np.random.default_rng(1)
    agents = 10 * rng.standard_normal((100, 4000))
    following = searcher.next_generation(agents, -np.arange(100.0), rng)
    first, second, third, newcomers = np.split(following, 4)
    # 100,000 numbers each: the mean is good to 0.003 σ, the standard deviation to 0.0022 σ
    for change, sigma in (
        (first - agents[:25], 0.1),
        (second - first, 0.5),
        (third - first, 2.0),
        (newcomers, 1.0),
    ):
        assert abs(change.mean()) < 0.015 * sigma
        assert abs(change.std() - sigma) < 0.011 * sigma
        assert abs(np.corrcoef(change[0], change[1])[0, 1]) < 0.08  # each agent for itself
    for one, other in ((first - agents[:25], second - first), (second - first, third - first)):
        assert abs(np.corrcoef(one.ravel(), other.ravel())[0, 1]) < 0.015


def test_the_elite_stays_as_it_is() -> None:
    rng = np.random.default_rng(2)
    agents = rng.standard_normal((16, 50))
    searcher = EvolutionarySearch(population=16, elite=3, rescale=False)
    following = searcher.next_generation(agents, -np.arange(16.0), rng)
    assert (following[:3] == agents[:3]).all()
    assert (following[3] != agents[3]).all()
    assert (following[4:8] != following[:4]).all()  # their copies change
    none = EvolutionarySearch(population=16, rescale=False).next_generation(agents, -np.arange(16.0), rng)
    assert (none[:4] != agents[:4]).all()


def test_evaluation_finds_the_same_parents_as_scoring_everyone() -> None:
    """An agent that cannot become a parent is not scored in full; one that plays what another did is worth −∞."""
    rng = np.random.default_rng(3)
    problem = cube_problem(10**6)
    slots = value_slots(problem.game)
    agents = rng.standard_normal((80, int(slots.max()) + 1))
    agents[40:60] = agents[:20]
    arena, plain = Tournament(problem, slots, parents=20), Tournament(cube_problem(10**6), slots, parents=20)
    returns = arena.evaluate(agents)
    full, seen = np.full(80, -np.inf), set()
    for i, values in enumerate(agents):
        actions = plain.play(values)
        if actions not in seen:
            full[i] = plain.problem.finish(plain.positions, 0, above=-np.inf)
        seen.add(actions)
    assert (full[40:60] == -np.inf).all()
    assert len(seen) < 60 < np.isfinite(full).sum() + 21
    assert np.isinf(returns).sum() > 20
    best = np.argsort(-full, kind="stable")[:20]
    assert (np.argsort(-returns, kind="stable")[:20] == best).all()
    equal = full >= full[best[-1]]  # whichever of them is chosen
    assert (returns[equal] == full[equal]).all()
    assert arena.problem.best_value == plain.problem.best_value
    assert arena.problem.interactions == plain.problem.interactions
    # a second time nothing is scored again, with the same result
    again = arena.evaluate(agents)
    assert (np.argsort(-again, kind="stable")[:20] == best).all()
    assert (again[best] == full[best]).all()


@pytest.mark.slow
def test_it_finds_the_known_optimum_of_the_cube() -> None:
    found = 0
    for seed in (1, 2, 3):
        problem = cube_problem(150_000)
        EvolutionarySearch(population=256).search(problem, np.random.default_rng(seed))
        found += problem.best_value > -0.0023
    assert found >= 2


@pytest.mark.slow
def test_with_rescaled_parents_it_finds_the_known_optimum_of_the_pyramid() -> None:
    for seed in (0, 1):
        problem = Problem(Game(9, "xy", Square(1)), ShapeObjective(pyramid()), 400_000)
        EvolutionarySearch(rescale=True).search(problem, np.random.default_rng(seed))
        assert problem.best_value >= -3 * np.sin(np.arccos(-1 / 3) - 1.884) - 1e-9


def test_a_whole_number_may_be_written_as_a_float() -> None:
    searcher = EvolutionarySearch(population=1e3, elite=2.0)  # type: ignore[arg-type]
    assert (searcher.population, searcher.parents, searcher.elite) == (1000, 250, 2)
    assert isinstance(searcher.population, int)


@pytest.mark.parametrize(
    ("key", "value"),
    [
        ("population", 2),
        ("population", "many"),
        ("population", 12.5),
        ("population", True),
        ("parents", 0.5),
        ("parents", 0.001),
        ("parents", None),
        ("sigma_1", -0.1),
        ("sigma_2", float("nan")),
        ("sigma_3", "1"),
        ("elite", 33),
        ("elite", -1),
        ("elite", float("inf")),
        ("rescale", 1),
    ],
)
def test_bad_numbers_are_refused(key: str, value: object) -> None:
    with pytest.raises(InputError, match=rf"search\.{key}="):
        EvolutionarySearch(**{key: value})  # type: ignore[arg-type]
