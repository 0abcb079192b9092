"""The shape objective's score under ``vertex`` and ``sampled`` as compiled searches ask for it."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from origami_lab.game.kernels.state import States
from origami_lab.geometry.bvh import Bvh
from origami_lab.jit import bare
from origami_lab.objectives.compiled_score import answered_by
from origami_lab.objectives.known_places import Surface
from origami_lab.objectives.shape_kernels import least_distance, stray, vertex_distance


@bare
def bound_shape(states: States, i: int, rules: States, memos: States, j: int, score: ShapeScore, above: float) -> float:
    """See :data:`~.compiled_score.Bound`: minus d→ and the compactness penalty, which only grow."""
    return -stray(states[i], rules[0], memos[j], score.target, -above)


@bare
def best_shape(
    states: States, i: int, rules: States, memos: States, j: int, score: ShapeScore, above: float
) -> tuple[float, int]:
    """See :data:`~.compiled_score.Best`."""
    s, r, memo, enough = states[i], rules[0], memos[j], -above
    if not stray(s, r, memo, score.target, enough) < enough:
        return -np.inf, -1
    distance, angle = vertex_distance(s, r, memo, score.cover, score.draws, enough, score.hint)
    return -distance, angle


@bare
def value_shape(states: States, i: int, rules: States, memos: States, j: int, score: ShapeScore) -> float:
    """See :data:`~.compiled_score.Value`: what the memo has no d→ of need not be measured at every angle."""
    if score.target.compactness > 0.0:
        return best_shape(states, i, rules, memos, j, score, -np.inf)[0]
    return -least_distance(states[i], rules[0], memos[j], score.target, score.cover, score.draws, score.hint)


@answered_by(bound_shape, best_shape, value_shape)
class ShapeScore(NamedTuple):
    """The measure of ``vertex`` or ``sampled``.

    Attributes
    ----------
    target
        What the vertices stray from.
    cover
        Tree over the samples of the target that are to be covered.
    draws
        (n, 3) what chooses the points of the folded sheet that cover; none: all of it covers.
    hint
        (1,) the sample that decided last; it changes no result.
    """

    target: Surface
    cover: Bvh
    draws: NDArray[np.float64]
    hint: NDArray[np.int64]
