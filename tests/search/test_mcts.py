"""MCTS: the tree by hand, what a simulation adds to it, and what is kept after a real action."""

from __future__ import annotations

import math

import numpy as np
import pytest

from origami_lab.errors import InputError
from origami_lab.game.game import Game
from origami_lab.game.start_patterns import Square
from origami_lab.objectives.shape import ShapeObjective
from origami_lab.objectives.shelf import ShelfObjective
from origami_lab.search.mcts import MonteCarloTreeSearch, ReturnRange, Tree
from origami_lab.search.mcts_kernel import NODE, back_up, best_child, expand, plant
from origami_lab.search.problem import Problem
from origami_lab.targets.solids import cube


def cube_problem(budget: int) -> Problem:
    return Problem(Game(9, "xy", Square(1), max_crease_length=2), ShapeObjective(cube()), budget)


def by_hand() -> np.ndarray:
    """A root with 9 visits and children of 4 visits (mean −2), 4 visits (mean −3) and none; the penalty is −8."""
    nodes = np.zeros(4, dtype=NODE)
    nodes["first"], nodes["count"] = [1, 0, 0, 0], [3, -1, -1, -1]
    nodes["visits"], nodes["total"] = [9, 4, 4, 0], [-24.0, -8.0, -12.0, 0.0]
    nodes["prior"] = [1.0, 0.25, 0.5, 0.25]
    return nodes


@pytest.mark.parametrize(
    ("c", "unvisited", "expected"),
    [
        # Q: 0.5, 0.25; c·P·√9/(1+N): 0.15 c, 0.3 c, 0.75 c
        (1.0, 0.0, 2),  # 0.65, 0.55, 0.75
        (0.5, 0.0, 0),  # 0.575, 0.4, 0.375
        (1.0, -0.3, 0),  # 0.65, 0.55, 0.45
        (0.5, math.nan, 2),  # the root's mean is −24/9, so Q is 1/3: 0.575, 0.4, 0.708
        (0.2, math.nan, 0),  # 0.53, 0.31, 0.483
        (0.0, 0.49, 0),
        (0.0, 0.51, 2),
    ],
)
def test_puct(c: float, unvisited: float, expected: int) -> None:
    assert best_child(by_hand(), 0, c, -8.0, 0.0, unvisited) == 1 + expected


def test_of_equal_children_the_first_is_taken_and_the_scale_matters() -> None:
    nodes = by_hand()
    nodes["prior"][1:], nodes["visits"][1:], nodes["total"][1:] = 1 / 3, 3, -9.0
    assert best_child(nodes, 0, 1.0, -8.0, 0.0, 0.0) == 1
    nodes["total"][3] = -8.9
    assert best_child(nodes, 0, 1.0, -8.0, 0.0, 0.0) == 3
    assert best_child(nodes, 0, 1.0, -3.0, -3.0, 0.0) == 1  # nothing to scale by


def test_back_up() -> None:
    nodes = by_hand()
    path = np.array([0, 3, 99], dtype=np.int32)
    back_up(nodes, path, 1, -1.5)
    assert nodes["visits"].tolist() == [10, 4, 4, 1]
    assert nodes["total"].tolist() == [-25.5, -8.0, -12.0, -1.5]


def test_priors_are_a_mixture_of_uniform_and_dirichlet() -> None:
    """Dir(α) over n: mean 1/n, variance (1/n)(1 − 1/n)/(nα + 1) of each share."""
    n, epsilon, alpha, rounds = 8, 0.25, 0.03, 20_000
    tree = Tree(cube_problem(10), np.random.default_rng(0), MonteCarloTreeSearch(epsilon=epsilon, alpha=alpha))
    nodes = np.zeros(1 + n, dtype=NODE)
    legal = np.arange(100, 100 + n, dtype=np.int32)
    shares = np.empty((rounds, n))
    for row in shares:
        plant(nodes)
        tree.noise.reserve(n)
        expand(nodes, 1, 0, legal, epsilon, tree.noise.block[tree.noise.used :])
        tree.noise.use(n)
        row[:] = (nodes["prior"][1:] - (1 - epsilon) / n) / epsilon
    assert nodes["action"][1:].tolist() == legal.tolist()
    assert (nodes["count"][0], nodes["first"][0]) == (n, 1)
    assert np.allclose(shares.sum(axis=1), 1.0)
    assert shares.min() > -1e-12
    variance = (1 / n) * (1 - 1 / n) / (n * alpha + 1)
    assert np.allclose(shares.mean(axis=0), 1 / n, atol=4 * math.sqrt(variance / rounds))
    assert np.allclose(shares.var(axis=0), variance, rtol=0.05)


def test_a_tiny_alpha_gives_everything_to_one() -> None:
    tree = Tree(cube_problem(10), np.random.default_rng(0), MonteCarloTreeSearch(epsilon=1.0, alpha=1e-3))
    nodes = np.zeros(4, dtype=NODE)
    plant(nodes)
    expand(nodes, 1, 0, np.arange(3, dtype=np.int32), 1.0, tree.noise.block)
    assert nodes["prior"][1:].max() == pytest.approx(1.0)
    assert np.isfinite(nodes["prior"]).all()


def check_subtree(tree: Tree, node: int) -> int:
    """Every node's visits are its children's and one of its own; returns how many nodes were visited."""
    first, count = int(tree.nodes["first"][node]), int(tree.nodes["count"][node])
    if count <= 0:
        return 1
    children = range(first, first + count)
    visited = [child for child in children if tree.nodes["visits"][child] > 0]
    assert tree.nodes["visits"][node] == 1 + sum(int(tree.nodes["visits"][child]) for child in visited)
    return 1 + sum(check_subtree(tree, child) for child in visited)


def test_simulations_count_up_and_the_tree_is_kept(monkeypatch: pytest.MonkeyPatch) -> None:
    """Visits, means and the path are recounted from the returns that were scored."""
    problem = cube_problem(10**6)
    tree = Tree(problem, np.random.default_rng(0), MonteCarloTreeSearch(simulations=60))
    kept: list[tuple[int, int, float]] = []
    before: list[int] = []
    choose = tree.choose

    def watched() -> int:
        root = tree.nodes[tree.root]
        assert int(root["visits"]) == before[-1] + 60
        child = choose()
        first, count = int(root["first"]), int(root["count"])
        assert tree.nodes["visits"][child] == tree.nodes["visits"][first : first + count].max()
        assert check_subtree(tree, tree.root) > 10
        kept.append((child, int(tree.nodes["visits"][child]), float(tree.nodes["total"][child])))
        before.append(kept[-1][1])
        return child

    returns: list[float] = []
    simulate = tree.simulate_compiled

    def recorded(count: int) -> int:
        """One of the simulations."""
        assert 1 <= count <= 60
        root = tree.root
        visits, total = int(tree.nodes["visits"][root]), float(tree.nodes["total"][root])
        if kept and visits == kept[-1][1]:  # the first simulation after a real action
            assert (root, visits, total) == kept[-1]
        done = simulate(1)
        returns.append(float(tree.nodes["total"][root]) - total)
        assert int(tree.nodes["visits"][root]) == visits + 1
        assert -8.0 - 1e-9 <= returns[-1] <= 1e-9
        return done

    before.append(0)
    monkeypatch.setattr(tree, "choose", watched)
    monkeypatch.setattr(tree, "simulate_compiled", recorded)
    tree.play_episode()
    assert len(kept) >= 3
    assert any(visits > 1 for _, visits, _ in kept[:-1])
    assert max(returns) == pytest.approx(problem.best_value)
    # what was really played is what the tree chose, to the end
    actions = tree.positions.states["actions"][0][: len(kept)].tolist()
    assert actions == [int(tree.nodes["action"][child]) for child, _, _ in kept]
    assert len(problem.game.legal(problem.game.replay(actions))) == 0


def test_drawn_actions_follow_visits_to_the_power_of_the_temperature() -> None:
    tree = Tree(cube_problem(10), np.random.default_rng(0), MonteCarloTreeSearch(greedy=False, temperature=1.5))
    tree.nodes[:4] = by_hand()
    tree.nodes["visits"][1:4] = [1, 4, 0]
    drawn = np.bincount([tree.choose() for _ in range(18_000)], minlength=4)
    assert drawn[0] == drawn[3] == 0
    assert drawn[1] == pytest.approx(2000, abs=170)  # 1 : 8
    tree.settings.greedy = True
    assert tree.choose() == 2


def test_returns_are_scaled_by_the_penalty_or_by_what_was_seen() -> None:
    scale = ReturnRange(-8.0)
    for value in (-1.0, -3.0, -math.inf):
        assert not scale.see(value)
    assert (scale.low, scale.high) == (-8.0, 0.0)
    assert (scale.clip(-math.inf), scale.clip(-2.0)) == (-8.0, -2.0)
    assert scale.see(5.0)
    assert (scale.low, scale.high) == (-3.0, 5.0)
    assert (scale.clip(-8.0), scale.clip(4.0)) == (-3.0, 4.0)
    assert not scale.see(7.0)
    assert (scale.low, scale.high) == (-3.0, 7.0)


def test_means_stay_on_the_scale_when_returns_leave_that_of_the_penalty(monkeypatch: pytest.MonkeyPatch) -> None:
    """A shelf scores 0 until there is one, so its scale changes late."""
    choose, outside = Tree.choose, []

    def checked(tree: Tree) -> int:
        outside.append(tree.returns.low == 0.0)
        nodes = tree.nodes[: tree.size][tree.nodes["visits"][: tree.size] > 0]
        means = nodes["total"] / nodes["visits"]
        assert tree.returns.low - 1e-9 <= means.min() <= means.max() <= tree.returns.high + 1e-9
        return choose(tree)

    monkeypatch.setattr(Tree, "choose", checked)
    problem = Problem(Game(13, "xy", Square(), source_action=False), ShelfObjective(), 30_000)
    MonteCarloTreeSearch().search(problem, np.random.default_rng(0))
    assert problem.best_value > 0.0
    assert any(outside)
    assert not all(outside)


@pytest.mark.slow
def test_it_finds_the_known_optimum_of_the_cube() -> None:
    found = 0
    for seed in range(4):
        problem = cube_problem(250_000)
        MonteCarloTreeSearch().search(problem, np.random.default_rng(seed))
        found += problem.best_value > -0.0023
    assert found >= 3


@pytest.mark.parametrize(
    ("key", "value"),
    [
        ("simulations", 1),
        ("simulations", "100"),
        ("simulations", 10.5),
        ("exploration", -1),
        ("exploration", None),
        ("epsilon", 1.5),
        ("alpha", 0),
        ("unvisited", 2),
        ("unvisited", "mean"),
        ("greedy", 1),
        ("temperature", float("inf")),
    ],
)
def test_bad_numbers_are_refused(key: str, value: object) -> None:
    with pytest.raises(InputError, match=rf"search\.{key}="):
        MonteCarloTreeSearch(**{key: value})  # type: ignore[arg-type]
