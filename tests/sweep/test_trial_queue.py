"""Who plays what: every place once, whoever dies, and whoever comes at the same moment."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from pathlib import Path

import optuna
import pytest
from optuna.storages import BaseStorage, JournalStorage
from optuna.trial import TrialState

from origami_lab.errors import InputError
from origami_lab.sweep.storage import JournalFile, check_same, open_storage, open_study
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


def play(claim: HeldTrial | None, value: float = -1.0) -> int:
    assert claim is not None
    claim.end(TrialState.COMPLETE, value)
    return claim.place


def states(places: TrialQueue) -> list[str]:
    return [place.state for place in places.look()]


def test_each_place_is_taken_once_and_in_order(storage: Open) -> None:
    one, two = join(storage), join(storage, ELSEWHERE)
    one.fill()
    two.fill()
    claims = [places.claim() for places in (one, two, one, two, one)]
    assert [None if claim is None else claim.place for claim in claims] == [0, 1, 2, None, None]
    for claim in claims[:3]:
        play(claim)
    one.fill()
    assert states(one) == states(two) == ["complete"] * 3
    assert len(one.study.trials) == 3


def test_a_dead_worker_s_trial_is_played_again_with_its_parameters(storage: Open) -> None:
    dead, alive = join(storage, GONE), join(storage)
    dead.fill()
    claim = dead.claim()
    assert claim is not None
    claim.begin({"fixed_params": {"x": 7.0}}).suggest_float("x", 0, 10)
    assert alive.reap() == [0]
    assert alive.reap() == []
    alive.fill()
    again = alive.claim()
    assert again is not None
    assert again.place == 0
    assert again.begin({}).suggest_float("x", 0, 10) == 7.0
    assert again.frozen().user_attrs["retry_of"] == 0
    # the dead one was only asleep
    claim.end(TrialState.COMPLETE, 5.0)
    assert claim.lost
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
    for places in (one, two):
        attributes = {"place": 0, "retry_of": 0}
        places.study.add_trial(optuna.trial.create_trial(state=TrialState.WAITING, user_attrs=attributes))
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
    claim = far.claim()
    assert claim is not None
    assert near.reap() == []
    now[0] = 59.0
    assert near.reap() == []
    claim.renew()
    now[0] = 118.0
    assert near.reap() == []
    now[0] = 179.0
    assert near.reap() == [0]
    with claim:
        pass
    claim.fail(STOPPED)
    assert claim.lost


def test_a_trial_that_kills_its_workers_is_given_up(storage: Open) -> None:
    places, dead = join(storage, count=2), join(storage, GONE, count=2)
    for _ in range(MOST_LOSSES):
        places.fill()
        claim = dead.claim()
        assert claim is not None
        assert claim.place == 0
        assert places.reap() == [0]
    places.fill()
    first, second = places.look()
    assert (first.state, second.state) == ("failed", "waiting")
    assert first.reason == f"{MOST_LOSSES} workers were lost with it"
    assert play(places.claim()) == 1
    assert all(place.done for place in places.look())


def test_losses_after_further_seeds_do_not_count(storage: Open) -> None:
    places, dead = join(storage, count=1), join(storage, GONE, count=1)
    for seeds in range(1, MOST_LOSSES + 3):
        places.fill()
        claim = dead.claim()
        assert claim is not None
        trial = claim.begin({})
        for seed in range(seeds):
            trial.report(-1.0, seed)
        assert places.reap() == [0]
    assert states(places) == ["waiting"]


def test_stopped_trials_wait_and_failed_ones_do_not(storage: Open) -> None:
    places = join(storage, count=2)
    places.fill()
    for why in (STOPPED, f"{FAILED}: the kettle is empty"):
        claim = places.claim()
        assert claim is not None
        claim.fail(why)
    places.fill()
    assert states(places) == ["waiting", "failed"]
    assert places.look()[1].reason == "failed: the kettle is empty"


def test_more_trials_extend_a_study(storage: Open) -> None:
    places = join(storage, count=1)
    places.fill()
    play(places.claim())
    more = join(storage, count=3)
    more.fill()
    assert states(more) == ["complete", "waiting", "waiting"]
    # one who asked for a single trial sees the others, too
    assert states(places) == ["complete", "waiting", "waiting"]
    assert play(places.claim()) == 1


def test_places_to_be_left_alone(storage: Open) -> None:
    places = join(storage)
    places.fill()
    assert play(places.claim(without={0, 1})) == 2
    assert places.claim(without={0, 1}) is None
    assert play(places.claim()) == 0


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
    places = join(lambda: JournalStorage(JournalFile(str(file))))
    places.fill()
    whole = file.read_bytes()
    file.write_bytes(whole + whole.splitlines(keepends=True)[-1][:20])
    one, two = (join(lambda: JournalStorage(JournalFile(str(file)))) for _ in range(2))
    claims = [one.claim(), two.claim(), places.claim()]
    assert [None if claim is None else claim.place for claim in claims] == [0, 1, 2]


def test_who_is_gone() -> None:
    assert not is_gone(HERE, HERE)
    assert is_gone(GONE, HERE)
    assert is_gone(replace(HERE, began="1"), HERE)  # its number was given to us
    assert not is_gone(ELSEWHERE, HERE)
