"""Shape approximation (paper, section 3.6.1): minus the Hausdorff distance between folded sheet and target.

Ways to measure it, all in board cells, all ≤ 0 with 0 for a perfect fit:

* ``vertex`` (the paper's definition): folded vertices to the target surface, samples of the target to the folded
  surface, both with exact point-to-surface distances;
* ``surface``: the two-sided Hausdorff distance of the surfaces, to a tolerance;
* ``sampled``: the paper's computation: vertices to random samples of the target, those to random samples of the
  folded surface. Two samplings of one surface differ by 0.05 to 0.2, so it ranks nothing below that;
* ``mean``: the mean distance of the points of each surface from the other one, both ways, and the mean of these two.
  One bad place does not decide, and so no sheet is known to be hopeless: there is no bound.

For a closed target, folded parts inside it do not stray; they still cover.
"""

from __future__ import annotations

import math
from functools import cached_property
from typing import Literal, get_args

import numpy as np
from numpy.typing import NDArray

from origami_lab.errors import InputError
from origami_lab.game.crease_pattern import CreasePattern
from origami_lab.game.game import Game
from origami_lab.game.kernels.state import States
from origami_lab.geometry.bvh import Bvh, build_bvh
from origami_lab.geometry.hausdorff import directed_distance
from origami_lab.geometry.sampled import sample_surface
from origami_lab.geometry.sampling import surface_draws
from origami_lab.geometry.surface_means import Cells, cells_of, like_share, mean_distance, thinned
from origami_lab.geometry.wide_tree import WideTree, build_wide_tree
from origami_lab.objectives.compiled_score import scores_itself
from origami_lab.objectives.known_places import Surface, nothing_known
from origami_lab.objectives.objective import NO_SCORE, Memos, Score, checked_number
from origami_lab.objectives.shape_kernels import (
    folded_triangles_of,
    memo_dtype,
    stray_at,
    stray_of,
    uncovered,
    uncovered_of,
)
from origami_lab.objectives.shape_score import ShapeScore, best_shape, value_shape
from origami_lab.targets.target import Direction, Target

Distance = Literal["vertex", "surface", "sampled", "mean"]
REPORTED: tuple[Distance, ...] = ("vertex", "surface", "sampled")
"""Distances that every design is reported under; ``mean`` is, too, as ``chamfer``."""
TARGET_SAMPLES = 10_000
"""Samples of the target aimed at for ``vertex``, and drawn for ``sampled`` (the paper's number)."""
MEAN_CELLS, SEARCH_CELLS = 4_000, 500
"""Cells that the target is cut into at least, for the figures and where ``mean`` is searched by; the sheet's have the
same area. Means by the second are about 1 % off."""
MOST_CELLS = 1_000
"""Cells of the target that are measured in a search, at most: a mesh may have more triangles."""
NEAR = 0.05
"""Part of the target's size within which a panel is near a place of the target."""
ALIKE = math.radians(20.0)
"""Angle between normals up to which it is like the target there."""


class ShapeObjective:
    """How well a folded sheet approximates a target surface.

    Parameters
    ----------
    target
        The target surface, in board cells, in the frame of the start pattern.
    distance
        ``vertex``, ``surface``, ``sampled`` or ``mean``; ``auto`` for ``surface`` where the target comes from a mesh
        file, else ``vertex``.
    tolerance
        Of the ``surface`` distance, in board cells.
    samples
        Number of samples for ``sampled``.
    sample_seed
        Seed of all sampling.
    compactness
        Weight of the penalty on the vertex that is furthest from the board's centre: what is lost for each board cell
        of its distance in space. It can only get worse, so it is part of the bound.
    """

    def __init__(
        self,
        target: Target,
        distance: Distance | Literal["auto"] = "vertex",
        tolerance: float = 1e-3,
        samples: int = TARGET_SAMPLES,
        sample_seed: int = 0,
        compactness: float = 0.0,
    ) -> None:
        if not isinstance(target, Target):
            raise InputError("target", target, "must be a target surface, such as target=bowl, for objective=shape")
        if distance == "auto":
            distance = "vertex" if target.units_per_cell is None else "surface"
        if distance not in get_args(Distance):
            raise InputError("objective.distance", distance, f"must be one of {', '.join(get_args(Distance))}, auto")
        if isinstance(tolerance, bool) or not isinstance(tolerance, int | float) or not 1e-6 <= tolerance < math.inf:
            raise InputError("objective.tolerance", tolerance, "must be a length in board cells, at least 1e-6")
        for name, number, low, high in (("samples", samples, 1, 10**7), ("sample_seed", sample_seed, 0, 2**63 - 1)):
            if isinstance(number, bool) or not isinstance(number, int) or not low <= number <= high:
                raise InputError(f"objective.{name}", number, f"must be a whole number from {low} to {high}")
        self.target = target
        self.distance: Distance = distance
        self.tolerance, self.samples, self.sample_seed = tolerance, samples, sample_seed
        self.compactness = checked_number("compactness", compactness, 0)

    @cached_property
    def cover(self) -> Bvh:
        """Tree over the target's samples for ``vertex``: a regular refinement of its mesh."""
        spacing = math.sqrt(2.0 * self.target.area / TARGET_SAMPLES)
        points = self.target.samples(spacing)
        return _point_tree(points)

    @cached_property
    def random_cover(self) -> Bvh:
        """Tree over the target's random samples for ``sampled``."""
        return _point_tree(self.target.sampled_points(self.samples, self.sample_seed))

    @cached_property
    def random_tree(self) -> WideTree:
        """The same for the folded vertices."""
        return build_wide_tree(self.random_cover)

    @cached_property
    def draws(self) -> NDArray[np.float64]:
        """(n, 3) what chooses the random samples of a folded sheet for ``sampled``."""
        draws = surface_draws(self.samples, np.random.default_rng(self.sample_seed))
        return draws[np.argsort(draws[:, 0], kind="stable")]

    @cached_property
    def cells(self) -> Cells:
        """The target in pieces, for the figures of a design."""
        return cells_of(self.target.triangles, self.target.area / MEAN_CELLS)

    @cached_property
    def search_cells(self) -> Cells:
        """The target in fewer pieces, for ``mean``."""
        return thinned(cells_of(self.target.triangles, self.target.area / SEARCH_CELLS), MOST_CELLS)

    def bind(self, game: Game) -> ShapeEvaluator:
        """The evaluator of this objective in a game."""
        return ShapeEvaluator(self, game)

    def up(self, design: CreasePattern) -> Direction | None:
        """As the target stands."""
        return self.target.up

    def front(self, design: CreasePattern) -> Direction | None:
        """As the target is looked at."""
        return self.target.front

    def report(self, game: Game, actions: tuple[int, ...], angle: int) -> dict[str, float]:
        """The figures of a design at one driving angle, without compactness: see :meth:`ShapeEvaluator.figures`."""
        return self.bind(game).figures(game.replay(actions), 0, angle)


class ShapeEvaluator:
    """The shape objective in one game."""

    def __init__(self, objective: ShapeObjective, game: Game) -> None:
        self._objective, self._game, self._rules = objective, game, game.rules.record
        self._yardstick = self._made_yardstick("sampled" if objective.distance == "sampled" else "vertex")
        bounds = objective.distance != "mean"
        self.compiled_bound = self._yardstick.target if bounds else None
        self.compiled_cover = self._yardstick.cover if bounds else None
        self.panels_bound = objective.distance == "surface"
        self._dtype = memo_dtype(len(game.angles))
        self._first = game.first_angle

    @property
    def compiled_score(self) -> ShapeScore | None:
        """What compiled searches ask, see :mod:`~.compiled_score`; None where Python measures."""
        measured_by_kernels = self._objective.distance in ("vertex", "sampled")
        return self._yardstick if measured_by_kernels and scores_itself(self) else None

    def _made_yardstick(self, distance: Distance) -> ShapeScore:
        """The measure of ``sampled``; that of ``vertex`` for any other distance."""
        objective, target = self._objective, self._objective.target
        solid, weight, hint = bool(target.closed), objective.compactness, np.zeros(1, dtype=np.int64)
        if distance == "sampled":  # random samples have no symmetry
            cover = objective.random_cover
            surface = Surface(objective.random_tree, target.bvh, solid, True, weight, nothing_known())
            return ShapeScore(surface, cover, objective.draws, hint)
        symmetric = target.has_symmetry(self._game.symmetry)
        cover = _playable_part(objective.cover, self._game, target.uncertainty) if symmetric else objective.cover
        surface = Surface(target.wide_tree, target.bvh, solid, not symmetric, weight, nothing_known())
        return ShapeScore(surface, cover, np.empty((0, 3)), hint)

    def new_memos(self, count: int) -> Memos:
        return np.zeros(count, dtype=self._dtype)

    def clear(self, memos: Memos, i: int) -> None:
        memos[i] = np.zeros((), dtype=self._dtype)

    def bound(self, states: States, memos: Memos, i: int, above: float = -math.inf) -> float:
        """−min over the angles of d→ of the vertices and the compactness penalty: they never move once placed.

        Under ``surface`` more points stray, so it is a bound there, too; under ``mean`` there is none.
        """
        if self._objective.distance == "mean":
            return math.inf
        return -float(stray_of(states, i, self._rules, memos, self._yardstick.target, -above))

    def score(self, states: States, memos: Memos, i: int, above: float = -math.inf) -> Score:
        if self._objective.distance == "mean":
            return self._score_by_mean(states, memos, i, above)
        if self._objective.distance == "surface":
            if not self.bound(states, memos, i, above) > above:
                return NO_SCORE
            return self._score_by_measuring(states, i, memos["stray"][i], memos["penalty"][i], above)
        value, angle = best_shape(states, i, self._rules, memos, i, self._yardstick, above)
        return Score(float(value), int(angle))

    def exact_value(self, states: States, memos: Memos, i: int) -> float:
        """The value of :meth:`score`, whatever it is; cheaper, as the angle is not asked for. Memos are only read."""
        if self._objective.distance in ("surface", "mean") or self._objective.compactness > 0.0:
            return self.score(states, memos.copy(), i).value
        return float(value_shape(states, i, self._rules, memos, i, self._yardstick))

    def _score_by_measuring(
        self, states: States, i: int, stray: NDArray[np.float64], penalty: NDArray[np.float64], above: float
    ) -> Score:
        best, angle = -above, -1
        at_least = stray + penalty
        reach = int(states["reach"][i])
        if int(states["n_triangles"][i]) == 0:
            return NO_SCORE
        _, cover, draws, hint = self._yardstick
        for k in sorted(range(self._first, reach), key=lambda k: float(at_least[k])):
            if at_least[k] < best:
                # samples that are not covered tell sooner than surfaces that it is no better; the distance of surfaces
                # may be measured too small by its tolerance
                limit = best - float(penalty[k]) + self._objective.tolerance
                line = states, i, self._rules, k, cover, draws
                if limit < math.inf and uncovered_of(*line, float(stray[k]), limit, hint) >= limit:
                    continue
                value = self.measure(states, i, k, self._objective.distance) + float(penalty[k])
                if value < best:
                    best, angle = value, k
        return Score(-best, angle) if angle >= 0 else NO_SCORE

    def _score_by_mean(self, states: States, memos: Memos, i: int, above: float) -> Score:
        if self._objective.compactness > 0.0:  # notes the penalty
            stray_of(states, i, self._rules, memos, self._yardstick.target, math.inf)
        best, angle = -above, -1
        for k in range(self._first, int(states["reach"][i])):
            penalty = float(memos["penalty"][i][k])
            value = self._mean(folded_triangles_of(states, i, self._rules, k), best - penalty) + penalty
            if value < best:
                best, angle = value, k
        return Score(-best, angle) if angle >= 0 else NO_SCORE

    def _mean(self, triangles: NDArray[np.float64], enough: float = math.inf, *, finely: bool = False) -> float:
        """The mean distance both ways of a folded sheet; infinite if it is no less than ``enough``."""
        objective, target = self._objective, self._objective.target
        if not len(triangles):
            return math.inf
        pieces, count = (objective.cells, MEAN_CELLS) if finely else (objective.search_cells, SEARCH_CELLS)
        uncovered_mean = mean_distance(pieces, build_bvh(triangles), False, 2.0 * enough)
        cells = cells_of(triangles, target.area / count)
        strays = mean_distance(cells, target.bvh, bool(target.closed), 2.0 * enough - uncovered_mean)
        return 0.5 * (float(uncovered_mean) + float(strays))

    def figures(self, states: States, i: int, angle: int) -> dict[str, float]:
        """What is reported of a design at one driving angle.

        Its return under each of three distances, ``chamfer`` (the mean distance both ways, in board cells),
        ``likeness`` (the share of the target's area that has a panel within 5 % of its size whose normal agrees within
        20 degrees), and the distance that the search used, as a return: in board cells, in percent of the target's size
        and, of a mesh, in the unit of its file.
        """
        objective = self._objective
        found = {f"return_{name}": -self.measure(states, i, angle, name) for name in REPORTED}
        triangles, size = folded_triangles_of(states, i, self._rules, angle), objective.target.size
        found["chamfer"] = chamfer = self._mean(triangles, finely=True)
        own = -chamfer if objective.distance == "mean" else found[f"return_{objective.distance}"]
        found["likeness"] = float(like_share(objective.cells, triangles, NEAR * size, math.cos(ALIKE)))
        found |= {"return_own": own, "return_percent": 100.0 * own / size}
        if objective.target.units_per_cell is not None:
            found["return_units"] = own * objective.target.units_per_cell
        return found

    def measure(self, states: States, i: int, angle: int, distance: Distance) -> float:
        """The distance to the target at one driving angle, in board cells, infinite for a sheet without area."""
        triangles = folded_triangles_of(states, i, self._rules, angle)
        if not len(triangles):
            return math.inf
        if distance == "mean":
            return self._mean(triangles)
        if distance == "surface":
            tolerance, shape = self._objective.tolerance, self._objective.target
            strays = directed_distance(triangles, shape.bvh, tolerance, solid=bool(shape.closed))
            return directed_distance(shape.triangles, build_bvh(triangles), tolerance, solid=False, start=strays)
        target, cover, draws, hint = self._made_yardstick(distance)
        strays = stray_at(states, i, self._rules, angle, target)
        return float(uncovered(cover, sample_surface(triangles, draws), strays, math.inf, hint))


def _point_tree(points: NDArray[np.float64]) -> Bvh:
    return build_bvh(np.ascontiguousarray(np.repeat(points[:, None, :], 3, axis=1)))


def _playable_part(cover: Bvh, game: Game, uncertainty: float) -> Bvh:
    """Where target and sheet have the game's symmetry, the samples over the playable area say it all.

    Those on its border may have come to lie outside it by as much as the target is uncertain.
    """
    points = cover.triangles[:, 0]
    if not len(game.symmetry.normals):
        return cover
    kept = (points[:, :2] @ game.symmetry.normals.T >= -max(1e-9, 2.0 * uncertainty)).all(axis=1)
    return _point_tree(points[kept])
