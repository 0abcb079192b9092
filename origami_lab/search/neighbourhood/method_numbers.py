"""The numbers of the method: how long runs are, what they are to reach, how they grow and change."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Annotated

from origami_lab.checks import Flag, Number, Whole, check_fields

Chance = Annotated[float, Number(0.0, 1.0)]
Again = Annotated[float, Number(0.0, 0.99)]
"""The probability of one more, again and again, so never for certain."""
Count = Annotated[int, Whole(1, 100_000)]
Actions = Annotated[int, Whole(4, 100_000)]
Part = Annotated[float, Number(1e-6, 1.0)]
Multiple = Annotated[float, Number(1.0, 1e6)]
Factor = Annotated[float, Number(0.01, 0.9999)]


@dataclass(kw_only=True)
class MethodNumbers:
    """Large-neighbourhood search: cut a part of a design away, grow it again, take what is better.

    Where the objective has samples to be covered (shape objectives) a run works under an aspiration threshold at one
    driving angle: nothing may stray beyond it, growth goes towards what is uncovered, and once nothing is the threshold
    is lowered. For any other objective growth is random and late acceptance decides. Designs are only ever extended by
    whole moves, so no episode ends inside an extension: ``stuck=penalise`` changes nothing.

    Parameters
    ----------
    runs, kept
        Fresh runs of a round, and how many of the best of them go on.
    run, kept_run
        Length of a fresh run as a part of the budget, and how many times that long the kept ones go on.
    first_run, growth
        Length of a fresh run in the first round, in interactions; from round to round it grows by this factor until
        it is full length.
    patience
        The best run of a round goes on until it has had no success for this many lengths of a fresh run.
    elite, first_elite, elite_part
        Probability that a fresh run has the driving angle of one of the best runs of the round before (before the
        full length is reached: the second one), and the part of the runs that are these best ones.
    threshold, first_threshold
        A fresh run is to reach this part of the best distance so far; the first, short ones the second.
    enough
        After a round of full length that improved the best return by less than this part of it, ``threshold`` becomes
        its square root.
    shrink
        A threshold that was reached is lowered to this part of the distance found.
    relax
        A best run that has come within this factor of its threshold goes on once more, under a threshold that it has
        nearly reached.
    regrowths
        Times that a changed design is grown again; the best outcome counts.
    temperature
        Of the annealing: samples uncovered, as a part of all samples.
    near, parent
        Probability that what is changed lies near an uncovered sample, and that it is then the move before it.
    shift, flip
        Probability that a vertex is shifted instead of moves cut away, and that then a mode is flipped instead.
    more
        Probability that another random move is cut away, too; and again.
    places, actions
        Places tried for each child of a leaf, and actions for one move, at most.
    wide, wide_places, wide_actions
        Part of the runs that try more: for boards without a maximum crease length, where one exact place may count.
    failures, goal_failures
        Moves that may fail in a row before growth ends; once it is no worse than before.
    idle
        Probability that a move need not cover anything new.
    source
        Probability that a driven crease is laid where one can be.
    noise
        Board cells, at most, that are added at random where the nearest leaf or move is looked for.
    idle_changes
        Changes in a row that may come to nothing at all before a run ends.
    panel_spacing
        Spacing of the points inside panels that must not stray either, in board cells, under ``distance=surface``.
    look
        Whether places that would stray, or whose outer panel would collide, are passed over: masked by their closed
        form, as the game's own rules are, and no interactions. If not, each of them counts as one when it is tried;
        those that are known to stray are not tried again.
    free
        Without coverage: the probability that nothing is cut away, only added.
    longer
        Without coverage: the probability that growth goes on after a move.
    attempts
        Without coverage: random moves that may fail in a row before growth ends.
    history
        Without coverage: a design is accepted if it is not worse than the one this many changes ago.
    """

    runs: Count = 24
    kept: Count = 6
    run: Part = 0.004
    kept_run: Multiple = 4.0
    first_run: Count = 60
    growth: Multiple = 2.5
    patience: Multiple = 20.0
    elite: Chance = 0.85
    first_elite: Chance = 0.5
    elite_part: Part = 0.25
    threshold: Factor = 0.75
    first_threshold: Factor = 0.5
    enough: Chance = 0.02
    shrink: Factor = 0.97
    relax: Multiple = 1.15
    regrowths: Count = 2
    temperature: Chance = 0.0017
    near: Chance = 0.5
    parent: Chance = 0.5
    shift: Chance = 0.3
    flip: Chance = 0.1
    more: Again = 0.3
    places: Count = 4
    actions: Actions = 24
    wide: Chance = 0.25
    wide_places: Count = 12
    wide_actions: Actions = 150
    failures: Count = 8
    goal_failures: Count = 1
    idle: Chance = 0.15
    source: Chance = 0.02
    noise: Annotated[float, Number(0.0, 1e06)] = 2.0
    idle_changes: Count = 20
    panel_spacing: Annotated[float, Number(0.01, 1e06)] = 0.8
    look: Annotated[bool, Flag()] = True
    free: Chance = 0.2
    longer: Again = 0.85
    attempts: Count = 6
    history: Count = 5

    def __post_init__(self) -> None:
        check_fields(self, "search")
