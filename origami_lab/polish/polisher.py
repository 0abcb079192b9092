"""Polishing one design: where its vertices and its driving angle would be if there were no grid."""

from __future__ import annotations

import math
import time
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field, replace
from types import MappingProxyType
from typing import Any

import numpy as np

from origami_lab.errors import InputError
from origami_lab.game.crease_pattern import CreasePattern
from origami_lab.game.game import Game
from origami_lab.game.move_table import Points
from origami_lab.objectives.shape import ShapeObjective
from origami_lab.polish.energy import with_panels, yardstick_of
from origami_lab.polish.finer_board import FineBoard, fine_board
from origami_lab.polish.laid_design import folded_design, laid_in_cells
from origami_lab.polish.measured import all_returns, own_return
from origami_lab.polish.minimax import Minimax
from origami_lab.polish.softening import FIRST_SIZE, soften
from origami_lab.polish.tools import Placement, Tools, checked_distance, copy_place
from origami_lab.polish.variables import variables_of
from origami_lab.verification.certificate import CERTIFIED, Certificate
from origami_lab.verification.verify_design import verify

STEPS = 60_000
"""Designs that a polish lays by default: about half a minute."""
FINER = 512
"""Parts of a cell."""
SOFT_STEPS = 300
"""Designs laid on the way to where the next descent of the largest distance begins."""
SHARPNESS = (5.0, 30.0)
"""Least and largest sharpness of the energy on that way."""
ONLY_SHAPES = "cannot be polished: only objective=shape with a target can"


def can_be_polished(objective: Any) -> bool:
    """Whether designs for it can be: what a class of the user's own adds to a shape's return is not known here."""
    return type(objective) is ShapeObjective


@dataclass(frozen=True, eq=False)
class Polished:
    """A polished design, and what it was before."""

    design: CreasePattern
    """In board cells, off the grid; its driving angles are equal steps up to the one that was found."""
    returns: Mapping[str, float]
    """``return`` as the objective has it, and the other figures that are reported of a design."""
    returns_before: Mapping[str, float]
    driving_angle: float
    """Degrees."""
    driving_angle_before: float
    certificate: Certificate
    """Always certified."""
    steps: int
    """Designs that were laid."""
    whole: bool
    """Whether all the steps asked for were taken; False where the time limit ended them, or the caller."""
    seconds: float
    board: FineBoard = field(repr=False)
    """The design on its fine board."""


def polish_design(
    game: Game,
    objective: Any,
    actions: Sequence[int],
    angle: int,
    *,
    steps: int = STEPS,
    seed: int = 0,
    seconds: float | None = None,
    finer: int = FINER,
    metadata: Mapping[str, object] | None = None,
    thickness: float = 0.0,
    on_progress: Callable[[int, float], None] | None = None,
    should_stop: Callable[[], bool] | None = None,
) -> Polished:
    """Move the vertices, the start pattern's size and the driving angle of a design so that it fits its target better.

    Every rule of the game is kept at every step, the motion is checked densely, and the result is certified: if
    certification fails, the best design before it that passes is taken, the unpolished one at last. So the result is
    never worse than the start. The same arguments give the same result, unless ``seconds`` ends the work early.

    Parameters
    ----------
    game, objective
        What the design was made in and for: a :class:`~origami_lab.objectives.shape.ShapeObjective`.
    actions, angle
        Its actions and the index of its driving angle.
    steps
        Designs to lay.
    seconds
        A limit; None for none.
    finer
        Parts of a cell that coordinates are multiples of.
    metadata
        Facts to keep with the design.
    thickness
        In board cells: panels that share no vertex must keep this distance, or the design is not certified.
    on_progress
        Told the designs laid so far and the best return, a few times a second.
    should_stop
        Asked often; once it says yes the work ends with what it has.

    Raises
    ------
    InputError
        If the objective is not a shape, a number is out of range, the design has nothing to move, or it cannot be
        certified as it is.
    """
    check_numbers(steps, seed, seconds)
    if not can_be_polished(objective):
        raise InputError("objective", type(objective).__name__, ONLY_SHAPES)
    started = time.monotonic()
    board = fine_board(game, actions, finer)
    descent = Descent(board, objective, float(game.angles[angle]), steps, started, seconds, on_progress, should_stop)
    first = verify_at(board, descent.found[0], thickness)
    if first.verdict != CERTIFIED:
        raise InputError(
            "design", "unpolished", f"must be certified before it can be polished, and is not: {first.reason}"
        )
    descent.run(np.random.default_rng(np.random.SeedSequence(seed)))
    found, certificate = _best_certified(board, objective, descent.found, thickness)
    evaluator = objective.bind(game)
    kept = replace(board, points=found.points)
    before = all_returns(board, descent.found[0].angle, objective, evaluator)
    after = all_returns(kept, found.angle, objective, evaluator)
    facts = dict(metadata or {}) | {"return": after["return"], "driving_angle": math.degrees(found.angle)}
    facts["polished"] = {"from": before["return"], "steps": descent.steps, "seed": seed, "parts_of_a_cell": board.finer}
    return Polished(
        design=folded_design(kept, found.angle, MappingProxyType(facts)),
        returns=MappingProxyType(after),
        returns_before=MappingProxyType(before),
        driving_angle=math.degrees(found.angle),
        driving_angle_before=math.degrees(descent.found[0].angle),
        certificate=certificate,
        steps=descent.steps,
        whole=descent.whole,
        seconds=time.monotonic() - started,
        board=kept,
    )


def check_numbers(steps: int, seed: int, seconds: float | None) -> None:
    """Raise InputError unless the numbers of a polish are such."""
    for name, value, low, high in (("steps", steps, 1, 10**9), ("seed", seed, 0, 2**63 - 1)):
        if isinstance(value, bool) or not isinstance(value, int) or not low <= value <= high:
            raise InputError(name, value, f"must be a whole number from {low} to {high}")
    if seconds is not None and not 0 < seconds < math.inf:
        raise InputError("seconds", seconds, "must be a number above 0")


@dataclass(frozen=True, eq=False)
class Found:
    """A design on the way, free of collisions densely."""

    distance: float
    """The largest distance, in cells, as the descent measures it."""
    points: Points
    angle: float
    """Radians."""


class Descent:
    """Descents of the largest distance, each from where the energy leads from the best design so far."""

    def __init__(
        self,
        board: FineBoard,
        objective: ShapeObjective,
        angle: float,
        steps: int,
        started: float,
        seconds: float | None,
        on_progress: Callable[[int, float], None] | None,
        should_stop: Callable[[], bool] | None,
    ) -> None:
        self._board, self._limit, self._started, self._seconds = board, steps, started, seconds
        self._on_progress, self._told, self._should_stop = on_progress, started, should_stop
        self.steps = 0
        self.whole = True
        stick = yardstick_of(objective, board)
        if objective.distance == "surface":
            stick = with_panels(stick, laid_in_cells(board, angle), board.rules)
        self._tools = Tools(
            states=board.new_states(),
            rules=board.rules.copy(),
            layout=board.layout,
            notes=board.new_notes(),
            variables=variables_of(board),
            stick=stick,
            nearest=np.zeros(len(stick.samples), dtype=np.int64),
            largest_angle=float(board.game.angles[-1]),
        )
        self._best = self._place(angle)
        free, distance = checked_distance(self._tools, self._best)
        if not free:
            raise InputError("design", "unpolished", "must fold without collisions before it can be polished")
        self.found = [Found(distance, board.points.copy(), angle)]
        """The best design so far is the last one, the unpolished one the first."""

    def run(self, rng: np.random.Generator) -> None:
        """Descend until the steps are taken or the time is up."""
        tools, minimax = self._tools, Minimax(self._tools, self._spend)
        angle = self.found[0].angle
        current, trial = self._place(angle), self._place(angle)
        minimax.descend(current)
        self._note(current)
        low, high = SHARPNESS
        while self._spend(SOFT_STEPS):
            copy_place(current, self._best)
            sharpness = low * (high / low) ** rng.random()
            draws = np.column_stack([rng.random(SOFT_STEPS), rng.standard_normal((SOFT_STEPS, 2))])
            sizes = np.full(len(tools.variables.members), FIRST_SIZE)
            soften(tools, current, trial, sizes, draws, max(self.found[-1].distance, 1e-9), sharpness)
            if minimax.descend(current) < self.found[-1].distance:
                self._note(current)

    def _place(self, angle: float) -> Placement:
        return Placement(self._board.points.copy(), np.array([angle]))

    def _note(self, place: Placement) -> None:
        free, distance = checked_distance(self._tools, place)
        if free and distance < self.found[-1].distance:
            copy_place(self._best, place)
            self.found.append(Found(distance, place.points.copy(), float(place.angle[0])))

    def _spend(self, designs: int) -> bool:
        """Count designs that are about to be laid; whether they may be."""
        now = time.monotonic()
        late = self._seconds is not None and now - self._started > self._seconds
        if late or (self._should_stop is not None and self._should_stop()):
            self.whole = False
            return False
        if self.steps + designs > self._limit:
            return False
        self.steps += designs
        if self._on_progress is not None and now - self._told > 0.25:
            self._told = now
            self._on_progress(self.steps, -self.found[-1].distance)
        return True


def _best_certified(
    board: FineBoard, objective: ShapeObjective, found: Sequence[Found], thickness: float
) -> tuple[Found, Certificate]:
    """The best design by the objective's own measure that is certified; the first one is known to be."""
    evaluator = objective.bind(board.game)
    values = [own_return(replace(board, points=one.points), one.angle, objective, evaluator) for one in found]
    better = [i for i in range(len(found)) if values[i] > values[0]]
    for i in [*sorted(better, key=lambda i: (-values[i], -i)), 0]:
        certificate = verify_at(board, found[i], thickness)
        if certificate.verdict == CERTIFIED:
            break
    return found[i], certificate


def verify_at(board: FineBoard, found: Found, thickness: float = 0.0) -> Certificate:
    """The certificate of a design on a fine board."""
    return verify(folded_design(replace(board, points=found.points), found.angle, {}), thickness)
