"""Growth and relay under a threshold, against distances and replays from scratch."""

from __future__ import annotations

import math
from typing import Any

import numpy as np
import pytest

from origami_lab.errors import InputError
from origami_lab.game.folded_sheet import FoldedSheet
from origami_lab.game.game import Game
from origami_lab.game.kernels.play import copy_to
from origami_lab.game.kernels.state import NOT_FOLDABLE, States
from origami_lab.game.moves import Extend, Move
from origami_lab.game.start_laying import play_move
from origami_lab.game.start_patterns import Crease, Square
from origami_lab.geometry.bvh import distances
from origami_lab.objectives.shape import ShapeEvaluator, ShapeObjective
from origami_lab.search.neighbourhood.changes import Change, cut, random_move, shift
from origami_lab.search.neighbourhood.covering import Covering
from origami_lab.search.neighbourhood.ground import WORK
from origami_lab.search.neighbourhood.one_run import LocalRun
from origami_lab.search.neighbourhood.search import NeighbourhoodSearch
from origami_lab.search.neighbourhood.threshold import Aim
from origami_lab.search.problem import Problem
from origami_lab.search.random_stream import Draws
from origami_lab.targets.face_surface import face
from origami_lab.targets.solids import bowl, cube
from origami_lab.targets.target import Target


def tilted() -> Target:
    """A plate without any of the board's symmetries."""
    vertices = np.array([[-3.0, -2.5, 0.3], [3.5, -2.0, -0.4], [3.0, 3.0, 0.5], [-2.5, 2.0, -0.6]])
    return Target("tilted", vertices, np.array([[0, 1, 2], [0, 2, 3]]), closed=False)


CASES: dict[str, tuple[Any, Any, int, float]] = {
    # game, target, driving angle, threshold
    "bowl": (lambda: Game(25, "xyd", Square("choose"), max_crease_length=2.9), bowl, 0, 1.2),
    "face": (lambda: Game(25, "y", Crease(0), max_crease_length=2.9), lambda: face(spacing=0.5), 1, 3.5),
    "cube": (lambda: Game(9, "xy", Square(1), max_crease_length=2), cube, 4, 1.2),
    "no length": (lambda: Game(9, "xy", Square(1)), cube, 3, 1.2),
    "tilted": (lambda: Game(13, "y", Square(1), max_crease_length=2.9), tilted, 1, 1.6),
}


class Grown:
    """A run that has grown its first design, and what it was grown with."""

    def __init__(self, name: str, seed: int, **settings: Any) -> None:
        game, target, angle, threshold = CASES[name]
        distance = settings.pop("distance", "vertex")
        self.problem = Problem(game(), ShapeObjective(target(), distance), 1_000_000)
        self.covering = Covering(self.problem, Draws(np.random.default_rng(seed)), NeighbourhoodSearch(**settings))
        self.run = LocalRun(angle, threshold=threshold)
        self.aim: Aim = self.covering._aim(self.run)
        bench = self.covering.bench
        for _ in range(200):
            bench.place(angle)
            self.left = self.covering.grow(self.run, self.aim, self.covering.covered(self.aim), -1)
            if int(self.states["n_extensions"][WORK]) > 1:
                break
        else:
            pytest.fail("nothing grows")
        self.design = bench.read(WORK, self.covering.coverage.order[: self.left].copy())

    @property
    def states(self) -> States:
        return self.covering.bench.positions.states

    def distance(self) -> float:
        """The vertex distance at the run's angle, from scratch: all samples, all vertices, images included."""
        game, k = self.problem.game, self.run.angle
        assert isinstance(self.problem.evaluator, ShapeEvaluator)
        states = self.states[WORK : WORK + 1].copy()
        return self.problem.evaluator.measure(states, 0, k, "vertex") if len(game.angles) else math.inf

    def straying(self) -> float:
        """The furthest vertex from the target, by brute force over the whole sheet."""
        game, target = self.problem.game, self.problem.objective.target
        sheet = FoldedSheet(self.states[WORK : WORK + 1], 0, game.rules.record)
        points = np.ascontiguousarray(sheet.points[self.run.angle])
        return float(distances(target.bvh, points).max())


@pytest.mark.parametrize("look", [False, True])
@pytest.mark.parametrize("name", CASES)
def test_nothing_strays_and_what_is_uncovered_is_known(name: str, look: bool) -> None:
    """At the run's angle; and the episode replays under the game's own rules."""
    for seed in range(4):
        grown = Grown(name, seed, look=look)
        limit = grown.aim.threshold * (1 + 1e-12)
        if not grown.problem.objective.target.closed:
            assert grown.straying() <= limit
        assert (grown.left == 0) == (grown.distance() <= limit)
        game = grown.problem.game
        actions = game.finished_actions(grown.states, WORK)
        again = game.replay(actions)  # raises on an illegal action
        k = grown.run.angle
        assert int(again["reach"][0]) > k
        count = int(again["n_vertices"][0])
        assert np.array_equal(again["position"][0][:count, k], grown.states["position"][WORK][:count, k])


@pytest.mark.parametrize("name", CASES)
def test_a_threshold_that_is_reached_is_reached_by_the_distance(name: str) -> None:
    """Success and failure, each against the distance from scratch: just below it something is uncovered or strays."""
    successes = 0
    for seed in range(6):
        grown = Grown(name, seed)
        distance, angle = grown.distance(), grown.run.angle
        for factor, enough in ((1 + 1e-11, True), (1 - 1e-11, False)):
            aim = grown.aim._replace(threshold=distance * factor)
            covering = grown.covering
            covering.bench.lay(unchanged_of(grown), aim, angle, recheck=True)
            whole = int(grown.states["n_vertices"][WORK]) == len(grown.design.points)
            assert (whole and covering.covered(aim) == 0) == enough
            successes += enough
    assert successes == 6


def unchanged_of(grown: Grown) -> Change:
    return Change(grown.design, np.zeros(len(grown.design.moves), dtype=np.int8), len(grown.design.moves))


def test_places_that_stray_are_interactions_or_not() -> None:
    """Counted, every place that is evaluated is one; with a look none is that strays, and they are reported."""
    counted, looking = Grown("bowl", 1, look=False), Grown("bowl", 1, look=True)
    assert counted.problem.places_evaluated == 0
    assert looking.problem.places_evaluated > 0
    assert looking.problem.outcome().places_evaluated == looking.problem.places_evaluated


@pytest.mark.parametrize("name", ["bowl", "face", "tilted"])
@pytest.mark.parametrize("distance", ["vertex", "surface"])
def test_what_is_known_to_stray_strays(name: str, distance: str) -> None:
    """A look that remembers finds what one finds that looks at every place anew, and looks less often."""

    def designs(*, forgetful: bool) -> tuple[list[Any], int]:
        grown = Grown(name, 0, distance=distance, look=True)
        covering, known, found = grown.covering, grown.covering.bench.room.known, []
        grown.run.design = grown.design
        for _ in range(40):
            if forgetful:
                known.thresholds[:] = -math.inf
            if grown.run.design is not None:
                covering.improve(grown.run, grown.problem.interactions + 1)
            actions = grown.states["actions"][WORK][: int(grown.states["n_actions"][WORK])]
            found.append((grown.run.threshold, grown.problem.interactions, actions.tolist()))
        return found, grown.problem.places_evaluated

    (remembered, few), (forgotten, many) = designs(forgetful=False), designs(forgetful=True)
    assert remembered == forgotten
    assert few < many


def play_relay(grown: Grown, named: list[Move]) -> States:
    """The oracle: moves played one by one through the game's own list, each held against the threshold from scratch."""
    problem, k = grown.problem, grown.run.angle
    game, target = problem.game, problem.objective.target
    rules = game.rules.replaced(min_reach=k + 1)
    states, before = game.new_states(1), game.new_states(1)
    states["reach"] = k + 1
    loose: set[tuple[int, int]] = set()
    for move in named:
        copy_to(before, 0, states, 0)
        goes = getattr(move, "leaf", None) in loose
        if not goes:
            try:
                play_move(rules, move, states)
                goes = int(states["status"][0]) == NOT_FOLDABLE
            except ValueError:
                goes = True
        if not goes:
            points = np.ascontiguousarray(game.sheet(states).points[k])
            outside = distances(target.bvh, points) > grown.aim.threshold * (1 + 1e-9)
            goes = bool(outside.any())
        if goes:
            copy_to(states, 0, before, 0)
            if isinstance(move, Extend):
                loose |= {move.a, move.b, move.c}
    return states


@pytest.mark.parametrize("name", ["bowl", "face", "tilted"])
def test_a_relay_is_a_replay_of_what_is_left(name: str) -> None:
    """After cuts and shifts of random designs, to the last bit."""
    dropped = cuts = shifts = 0
    for seed in range(6):
        grown = Grown(name, seed, source=0.0)
        game, bench, draws = grown.problem.game, grown.covering.bench, grown.covering.draws
        named = game.moves(game.finished_actions(grown.states, WORK))
        for _ in range(6):
            chosen = random_move(grown.design, draws)
            change = shift(grown.design, chosen, game.rules.half, 0.2, draws) if draws.one() < 0.5 else None
            if change is None:
                change = cut(grown.design, chosen, 0.3, draws)
                cuts += 1
            else:
                if grown.design.points.shape[0] != len({tuple(p) for p in change.design.points.tolist()}):
                    continue  # two vertices on one point: their moves cannot be told apart by points
                shifts += 1
            # moves that go at once, and changed ones as they read now
            bench.lay(change, grown.aim, grown.run.angle)
            table, points = change.design.moves, change.design.points
            expected = play_relay(grown, renamed(game, named, grown.design.points, table, points, change.goes))
            assert game.finished_actions(expected) == game.finished_actions(grown.states, WORK)
            count = int(expected["n_vertices"][0])
            k = grown.run.angle
            ours = grown.states["position"][WORK]
            assert np.array_equal(expected["position"][0][:count, k], ours[:count, k])
            dropped += int(grown.states["n_extensions"][WORK]) < len(named) - 1 - int(change.goes.sum())
    assert min(dropped, cuts, shifts) > 0


def renamed(game: Game, named: list[Move], old: Any, table: Any, points: Any, goes: Any) -> list[Move]:
    """The moves with shifted points and flipped modes; one that is cut has a leaf that is never there."""
    ways = {}
    for v in range(len(old)):
        if not np.array_equal(old[v], points[v]):
            ways = {tuple((m @ old[v]).tolist()): tuple((m @ points[v]).tolist()) for m in game.symmetry.matrices}
    out: list[Move] = []
    for move, row, cut_away in zip(named, table, goes, strict=True):
        if isinstance(move, Extend):
            names = {name: ways.get(getattr(move, name), getattr(move, name)) for name in ("a", "b", "c", "leaf")}
            changed = Extend(names["leaf"], int(row["sign"]), names["a"], names["b"], names["c"])
            if cut_away:
                changed = Extend((99, 99), 1, names["a"], names["b"], names["c"])
            out.append(changed)
        else:
            out.append(move)
    return out


def test_panels_stay_near_where_they_bound() -> None:
    """Under surface, at the points of a grid finer than the one that was looked at, to half its spacing."""
    rng = np.random.default_rng(0)
    worse = 0
    for seed in range(12):
        found = []
        for distance in ("surface", "vertex"):
            grown = Grown("face", seed, distance=distance)
            triangles = grown.problem.game.sheet(grown.states[WORK : WORK + 1])
            corners = triangles.points[grown.run.angle][triangles.triangles]
            weights = rng.dirichlet([1, 1, 1], 200)
            points = np.ascontiguousarray(np.einsum("nc,tcx->ntx", weights, corners).reshape(-1, 3))
            found.append(float(distances(grown.problem.objective.target.bvh, points).max()))
        assert found[0] <= grown.aim.threshold + 0.5
        worse += found[1] > grown.aim.threshold
    assert worse > 0  # panels that no vertex shows


def test_bad_numbers_are_refused() -> None:
    for name, value in {"runs": 0, "threshold": 1.0, "shift": 1.5, "more": 1.0, "look": 1, "actions": 3}.items():
        with pytest.raises(InputError, match=rf"search\.{name}"):
            NeighbourhoodSearch(**{name: value})  # type: ignore[arg-type]
    assert NeighbourhoodSearch(runs=1e1).runs == 10  # type: ignore[arg-type]
