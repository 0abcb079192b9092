"""What a person reads of a sweep while it runs, line by line."""

from __future__ import annotations

import io
from typing import Any

from optuna.trial import FrozenTrial, TrialState, create_trial
from rich.console import Console

from origami_lab.sweep.sweep_display import SweepDisplay
from origami_lab.sweep.trial_queue import Slot


def trial(state: TrialState, value: float | None = None, **attributes: Any) -> FrozenTrial:
    return create_trial(state=state, value=value, user_attrs=attributes)


def test_the_lines_of_a_sweep() -> None:
    written = io.StringIO()
    display = SweepDisplay(Console(file=written, width=200), quiet=False, seeds=3)

    def lines() -> list[str]:
        found = written.getvalue().splitlines()
        written.truncate(0)
        written.seek(0)
        return found

    running = Slot(1, trial(TrialState.RUNNING), 0, given_up=False)
    display.resume([Slot(0, trial(TrialState.COMPLETE, -1.0), 0, given_up=False), running], asked=1)
    assert lines() == [
        "1 of 2 trials are done",
        "the study was given 2 trials before, which trials=1 does not take back",
    ]
    display.show([running], warm=True)
    assert lines() == []
    again = Slot(1, trial(TrialState.RUNNING), 1, given_up=False)
    display.show([again], warm=True)
    display.show([again], warm=True)
    assert lines() == ["trial 1: its worker is gone; it is played again"]
    pruned = trial(TrialState.PRUNED, -2.0, returns=[-1.5, -2.5], pruned="below -1.0000")
    display.show([Slot(1, pruned, 1, given_up=False)], warm=True)
    assert lines() == ["trial 1: -2.0000, given up after 2 of 3 seeds: below -1.0000, interrupted 1×"]

    waiting, best = (Slot(number, None, 0, given_up=False) for number in (0, 1))
    display.compare({"best": best, "defaults": waiting})
    assert lines() == ["comparing on held-out seeds: best, defaults"]
    played = Slot(0, trial(TrialState.COMPLETE, -0.5), 0, given_up=False)
    broken = Slot(1, trial(TrialState.FAIL, end="failed: the kettle is empty"), 0, given_up=False)
    display.compare({"best": played, "defaults": waiting})
    display.compare({"best": played, "defaults": broken})
    assert lines() == [
        "best: mean return -0.5000 on held-out seeds",
        "defaults: failed: the kettle is empty on held-out seeds",
    ]
    display.stopped([played, running], ["origami-lab", "sweep", "a.yaml", "storage=postgresql://me:secret@host/x"])
    assert lines() == ["1 of 2 trials are done; to go on: origami-lab sweep a.yaml storage=postgresql://me@host/x"]
