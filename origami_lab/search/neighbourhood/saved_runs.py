"""The state of the rounds as arrays: what another search takes up, with a larger budget."""

from __future__ import annotations

from collections import deque
from collections.abc import Iterator, Mapping

import numpy as np
from numpy.typing import ArrayLike

from origami_lab.game.move_table import MOVE
from origami_lab.search.neighbourhood.one_run import NONE_YET, LocalRun, RunDesign
from origami_lab.search.neighbourhood.portfolio import Portfolio
from origami_lab.search.problem import SearcherState

_FIELDS = MOVE.names or ()


def save_portfolio(portfolio: Portfolio) -> Mapping[str, ArrayLike]:
    """How long fresh runs are by now and what they are to reach, and the best runs of the last round."""
    found: dict[str, ArrayLike] = {
        "length": portfolio.length,
        "factor": portfolio.factor,
        "best_angles": np.array(portfolio.best_angles, dtype=np.int64),
    }
    runs = [run for run in portfolio.runs if run.design is not None]
    runs.sort(key=portfolio.improver.rank)
    for number, run in enumerate(runs[: portfolio.settings.kept]):
        for name, value in run_arrays(run):
            found[f"{number}.{name}"] = value
    return found


def run_arrays(run: LocalRun) -> Iterator[tuple[str, ArrayLike]]:
    """What a run stands at, by names."""
    design = run.design
    assert design is not None
    yield "whole", np.array([run.angle, run.wide, run.lowest, design.own], dtype=np.int64)
    yield "real", np.array([run.threshold, run.value], dtype=np.float64)
    yield "accepted", np.array(run.accepted, dtype=np.float64)
    # one column a field: the layout of a record is the machine's own
    yield "moves", np.array([[move[name] for name in _FIELDS] for move in design.moves], dtype=np.int32)
    yield "points", design.points
    yield "places", design.places
    yield "uncovered", design.uncovered


def load_portfolio(portfolio: Portfolio, state: SearcherState) -> None:
    """Take up what :func:`save_portfolio` has made of a portfolio for the same game and objective."""
    portfolio.length, portfolio.factor = float(state["length"]), float(state["factor"])
    portfolio.best_angles = [int(angle) for angle in state["best_angles"]]
    portfolio.runs = []
    while f"{len(portfolio.runs)}.whole" in state:
        prefix = f"{len(portfolio.runs)}."
        own = {name.removeprefix(prefix): value for name, value in state.items() if name.startswith(prefix)}
        portfolio.runs.append(_run_of(own, portfolio.settings.history))


def _run_of(arrays: SearcherState, history: int) -> LocalRun:
    angle, wide, lowest, own = (int(number) for number in arrays["whole"])
    moves = np.zeros(len(arrays["moves"]), dtype=MOVE)
    for column, name in enumerate(_FIELDS):
        moves[name] = arrays["moves"].reshape(-1, len(_FIELDS))[:, column]
    design = RunDesign(
        moves=moves,
        points=arrays["points"].astype(np.int32),
        places=arrays["places"].astype(np.float64),
        own=own,
        uncovered=arrays["uncovered"].astype(np.int32),
    )
    return LocalRun(
        angle=angle,
        wide=bool(wide),
        threshold=float(arrays["real"][0]),
        design=design,
        value=float(arrays["real"][1]),
        lowest=min(lowest, NONE_YET),
        accepted=deque((float(value) for value in arrays["accepted"]), maxlen=history),
    )
