"""Who plays what: every slot once, whoever dies, and whoever comes at the same moment."""

from __future__ import annotations

import sqlite3
from collections.abc import Callable
from dataclasses import replace
from pathlib import Path
from typing import Any

import optuna
import pytest
from optuna.storages import BaseStorage, JournalStorage
from optuna.trial import TrialState
from sqlalchemy import event
from sqlalchemy.exc import OperationalError

from origami_lab.errors import InputError
from origami_lab.sweep.storage import Database, JournalFile, check_same, open_storage, open_study
from origami_lab.sweep.trial_queue import FAILED, MOST_LOSSES, STOPPED, HeldTrial, TrialQueue
from origami_lab.sweep.worker_identity import Worker, is_gone
from tests.sweep.conftest import declare

HERE = Worker.this()
ELSEWHERE = Worker("another machine", 1, "", "a")
GONE = replace(HERE, pid=2**22 + 1, key="gone")
"""A process of this machine that is not there: above the largest number."""

Open = Callable[[], BaseStorage]


@pytest.fixture(params=["journal", "sqlite"])
def storage(request: pytest.FixtureRequest, tmp_path: Path) -> Open:
    """Opens the same storage anew each time, as another process would."""
    optuna.logging.set_verbosity(optuna.logging.ERROR)
    if request.param == "journal":
        return lambda: JournalStorage(JournalFile(str(tmp_path / "study.journal")))
    return lambda: optuna.storages.get_storage(f"sqlite:///{tmp_path}/study.db")


def join(storage: Open, worker: Worker = HERE, count: int = 3, lease_seconds: float = 60.0) -> TrialQueue:
    return TrialQueue(open_study(storage(), "small", {"a": 1}), count, worker, lease_seconds)


def play(held: HeldTrial | None, value: float = -1.0) -> int:
    assert held is not None
    held.end(TrialState.COMPLETE, value)
    return held.number


def states(queue: TrialQueue) -> list[str]:
    return [slot.state for slot in queue.look()]


def test_each_slot_is_taken_once_and_in_order(storage: Open) -> None:
    one, two = join(storage), join(storage, ELSEWHERE)
    one.fill()
    two.fill()
    taken = [queue.claim() for queue in (one, two, one, two, one)]
    assert [None if held is None else held.number for held in taken] == [0, 1, 2, None, None]
    for held in taken[:3]:
        play(held)
    one.fill()
    assert states(one) == states(two) == ["complete"] * 3
    assert len(one.study.trials) == 3


def test_a_dead_worker_s_trial_is_played_again_with_its_parameters(storage: Open) -> None:
    dead, alive = join(storage, GONE), join(storage)
    dead.fill()
    held = dead.claim()
    assert held is not None
    held.begin({"fixed_params": {"x": 7.0}}).suggest_float("x", 0, 10)
    assert alive.reap() == [0]
    assert alive.reap() == []
    alive.fill()
    again = alive.claim()
    assert again is not None
    assert again.number == 0
    assert again.begin({}).suggest_float("x", 0, 10) == 7.0
    assert again.frozen().user_attrs["retry_of"] == 0
    # the dead one was only asleep
    held.end(TrialState.COMPLETE, 5.0)
    assert held.lost
    play(again, -2.0)
    trial = alive.look()[0].trial
    assert trial is not None
    assert trial.value == -2.0


def test_of_two_who_replace_the_same_trial_one_is_surplus(storage: Open) -> None:
    dead, one, two = join(storage, GONE, count=1), join(storage, count=1), join(storage, ELSEWHERE, count=1)
    dead.fill()
    assert dead.claim() is not None
    assert one.reap() == [0]
    # both have seen the gap before either filled it
    for queue in (one, two):
        attributes = {"place": 0, "retry_of": 0}
        queue.study.add_trial(optuna.trial.create_trial(state=TrialState.WAITING, user_attrs=attributes))
    first = one.claim()
    assert first is not None
    assert two.claim() is None
    play(first)
    one.fill()
    assert one.claim() is None
    assert [trial.state for trial in one.study.trials] == [TrialState.FAIL, TrialState.COMPLETE, TrialState.FAIL]
    assert one.study.trials[2].user_attrs["end"] == "surplus"
    assert states(one) == ["complete"]


def test_a_lease_of_another_machine_ends_when_it_is_not_renewed(storage: Open, monkeypatch: pytest.MonkeyPatch) -> None:
    now = [0.0]
    monkeypatch.setattr("origami_lab.sweep.trial_queue.time.monotonic", lambda: now[0])
    far, near = join(storage, ELSEWHERE), join(storage)
    far.fill()
    held = far.claim()
    assert held is not None
    assert near.reap() == []
    now[0] = 59.0
    assert near.reap() == []
    held.renew()
    now[0] = 118.0
    assert near.reap() == []
    now[0] = 179.0
    assert near.reap() == [0]
    with held:
        pass
    held.fail(STOPPED)
    assert held.lost


def test_a_trial_that_kills_its_workers_is_given_up(storage: Open) -> None:
    queue, dead = join(storage, count=2), join(storage, GONE, count=2)
    for _ in range(MOST_LOSSES):
        queue.fill()
        held = dead.claim()
        assert held is not None
        assert held.number == 0
        assert queue.reap() == [0]
    queue.fill()
    first, second = queue.look()
    assert (first.state, second.state) == ("failed", "waiting")
    assert first.reason == f"{MOST_LOSSES} workers were lost with it"
    assert play(queue.claim()) == 1
    assert all(slot.done for slot in queue.look())


def test_losses_after_further_seeds_do_not_count(storage: Open) -> None:
    queue, dead = join(storage, count=1), join(storage, GONE, count=1)
    for seeds in range(1, MOST_LOSSES + 3):
        queue.fill()
        held = dead.claim()
        assert held is not None
        trial = held.begin({})
        for seed in range(seeds):
            trial.report(-1.0, seed)
        assert queue.reap() == [0]
    assert states(queue) == ["waiting"]


def test_stopped_trials_wait_and_failed_ones_do_not(storage: Open) -> None:
    queue = join(storage, count=2)
    queue.fill()
    for why in (STOPPED, f"{FAILED}: the kettle is empty"):
        held = queue.claim()
        assert held is not None
        held.fail(why)
    queue.fill()
    assert states(queue) == ["waiting", "failed"]
    assert queue.look()[1].reason == "failed: the kettle is empty"


def test_more_trials_extend_a_study(storage: Open) -> None:
    queue = join(storage, count=1)
    queue.fill()
    play(queue.claim())
    more = join(storage, count=3)
    more.fill()
    assert states(more) == ["complete", "waiting", "waiting"]
    # one who asked for a single trial sees the others, too
    assert states(queue) == ["complete", "waiting", "waiting"]
    assert play(queue.claim()) == 1


def test_slots_to_be_left_alone(storage: Open) -> None:
    queue = join(storage)
    queue.fill()
    assert play(queue.claim(without={0, 1})) == 2
    assert queue.claim(without={0, 1}) is None
    assert play(queue.claim()) == 0


def test_a_study_that_was_declared_otherwise(storage: Open) -> None:
    open_study(storage(), "small", {"budget": 1, "space": {"x": {"low": 1}}})
    open_study(storage(), "small", {"budget": 1, "space": {"x": {"low": 1}}})
    with pytest.raises(InputError, match=r"space\.x\.low=2: was 1 when the study small was started"):
        open_study(storage(), "small", {"budget": 1, "space": {"x": {"low": 2}}})
    with pytest.raises(InputError, match=r"y=not there: was 3"):
        check_same("small", {"y": 3}, {})
    with pytest.raises(InputError, match=r"space=y, x: was in the order x, y"):
        check_same("small", {"space": {"x": 1, "y": 2}}, {"space": {"y": 2, "x": 1}})


@pytest.mark.parametrize("text", ["garbage\n", "[1]\n", "{}\n"])
def test_another_kind_of_file_is_no_journal(tmp_path: Path, text: str) -> None:
    (tmp_path / "it.journal").write_text(text)
    with pytest.raises(InputError, match="is no journal of Optuna's"):
        open_storage(declare(tmp_path, storage=str(tmp_path / "it.journal")))


def test_a_journal_in_a_folder_that_is_not_there(tmp_path: Path) -> None:
    with pytest.raises(InputError, match=r"must be a file that can be written \(No such file"):
        open_storage(declare(tmp_path, storage=str(tmp_path / "no" / "it.journal")))
    assert not (tmp_path / "no").exists()


def test_a_journal_whose_writer_was_killed_in_the_middle_of_a_line(tmp_path: Path) -> None:
    file = tmp_path / "study.journal"
    queue = join(lambda: JournalStorage(JournalFile(str(file))))
    queue.fill()
    whole = file.read_bytes()
    file.write_bytes(whole + whole.splitlines(keepends=True)[-1][:20])
    one, two = (join(lambda: JournalStorage(JournalFile(str(file)))) for _ in range(2))
    taken = [one.claim(), two.claim(), queue.claim()]
    assert [None if held is None else held.number for held in taken] == [0, 1, 2]


def test_a_database_that_is_away_for_a_while_is_waited_for(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """From joining a study to the end of a trial, now and then a statement fails."""
    monkeypatch.setattr("origami_lab.sweep.storage.time.sleep", lambda seconds: None)
    engine: Any = optuna.storages.get_storage(Database(f"sqlite:///{tmp_path}/study.db", patience=5.0))
    asked: list[bool] = []

    def break_now_and_then(*_: object) -> None:
        asked.append(True)
        if len(asked) % 17 == 0:
            raise OperationalError("SELECT", {}, sqlite3.OperationalError("connection refused"))

    event.listen(engine._backend.engine, "before_cursor_execute", break_now_and_then)
    queue = TrialQueue(open_study(engine, "small", {"a": 1}), 1, HERE)
    queue.fill()
    held = queue.claim()
    assert held is not None
    with held:
        held.note("folder", "here")
        trial = held.begin({"fixed_params": {"x": 7.0}})
        trial.suggest_float("x", 0, 10)
        trial.report(-1.0, 0)
        held.end(TrialState.COMPLETE, -1.0)
    assert [slot.state for slot in queue.look()] == ["complete"]
    assert len(asked) > 40


def test_who_is_gone() -> None:
    assert not is_gone(HERE, HERE)
    assert is_gone(GONE, HERE)
    assert is_gone(replace(HERE, began="1"), HERE)  # its number was given to us
    assert not is_gone(ELSEWHERE, HERE)
