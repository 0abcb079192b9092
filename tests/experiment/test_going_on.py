"""Runs that go on: the same stages and seed give the same bits, wherever and by however many workers."""

from __future__ import annotations

import csv
import json
import shutil
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from origami_lab.config.compose import compose_settings
from origami_lab.config.instantiate import Parts, build_parts
from origami_lab.experiment.search_state import SearchState, read_state, state_of_bytes
from origami_lab.experiment.staged_search import search_in_stages, stage_generator
from origami_lab.runs.checkpoint import Checkpoint
from origami_lab.runs.run_folder import RunFolder
from origami_lab.runs.trial_row import TrialRow
from origami_lab.search.evolution import EvolutionarySearch
from origami_lab.search.neighbourhood.search import NeighbourhoodSearch
from origami_lab.search.problem import Problem
from tests.experiment.fakes import Counting
from tests.small_runs import TIMINGS, run

BASE = ("target=bowl", "symmetry=xyd", "tracking=none", "files=designs", "verbosity=quiet", "workers=1")
SEARCHERS: dict[str, tuple[tuple[str, ...], tuple[int, ...]]] = {
    "lns": (("search=lns",), (900, 1700, 2600)),
    "lns_any": (("search=lns", "objective.distance=mean"), (150, 250, 350)),
    "evo": (("search=evo", "search.population=12"), (900, 1700, 2600)),
    "bfts": (("search=bfts", "search.restarts=5"), (900, 1700, 2600)),
    "mcts": (("search=mcts", "search.simulations=20"), (900, 1700, 2600)),
    "rdm": (("search=rdm",), (900, 1700, 2600)),
}
"""Settings, and the budgets of three stages."""


def rows(folder: Path) -> dict[int, dict[str, Any]]:
    """What a run has found, without what a clock says."""
    found = RunFolder(folder).rows()
    return {seed: {k: v for k, v in row.values().items() if k not in TIMINGS} for seed, row in sorted(found.items())}


def designs(folder: Path) -> dict[str, Any]:
    """Actions, curve, and the state of the search but for its seconds, by trial."""
    found: dict[str, Any] = {}
    for trial in sorted(folder.glob("seed=*")):
        state = read_state(trial)
        assert state is not None
        searcher = {name: value.tolist() for name, value in state.searcher.items()}
        texts = [(trial / name).read_text() for name in ("actions.json", "curve.csv")]
        found[trial.name] = (texts, state.outcome, searcher)
    return found


@pytest.mark.parametrize("name", SEARCHERS)
def test_one_search_in_stages_is_one_that_went_on(name: str) -> None:
    """Each stage from the state that the one before it has written, or all of them in one go."""
    words, budgets = SEARCHERS[name]
    state, found = None, []
    for number, budget in enumerate(budgets):
        stages = ",".join(f"{{budget:{before}}}" for before in budgets[:number])
        settings = compose_settings([*BASE, *words, f"budget={budget}", f"stages=[{stages}]"])
        searched = played(settings, begun=state)
        state = state_of_bytes(searched.state.to_bytes())
        found.append(searched)
    whole = played(settings)
    assert whole.outcome == found[-1].outcome
    assert same_state(whole.state, found[-1].state)
    assert [one.outcome.interactions for one in found] == list(budgets)
    values = [one.outcome.value for one in found]
    assert values == sorted(values)
    episodes = [one.outcome.episodes for one in found]
    assert episodes == sorted(set(episodes))
    assert [(stage["budget"], stage["return"]) for stage in whole.record] == [
        (budget, one.outcome.value) for budget, one in zip(budgets, found, strict=True)
    ]
    assert bool(whole.state.searcher) == (name.partition("_")[0] in ("lns", "evo"))


@pytest.mark.slow
def test_a_run_that_went_on_is_one_in_stages(tmp_path: Path) -> None:
    """Begun, given more and another seed, or all at once from its configuration, by two workers."""
    words, budgets = (*BASE, "search=lns"), (900, 1700)
    assert run(tmp_path, *words, "seed=0", f"budget={budgets[0]}", "output=on") == 0
    first = rows(tmp_path / "on")[0]
    assert run(tmp_path, *words, "seed=0..1", f"budget={budgets[1]}", "output=on", "resume=true") == 0
    second = rows(tmp_path / "on")
    assert run(tmp_path, "on/config.yaml", "workers=2", "output=whole") == 0
    assert second == rows(tmp_path / "whole")
    assert designs(tmp_path / "on") == designs(tmp_path / "whole")
    assert first["return"] <= second[0]["return"]
    record = json.loads((tmp_path / "on/seed=0/result.json").read_text())["stages_of_search"]
    assert [stage["interactions"] for stage in record] == list(budgets)
    summary = json.loads((tmp_path / "on/summary.json").read_text())
    assert summary["budget"] == budgets[1]
    assert [stage["budget"] for stage in summary["stages"]] == [budgets[0]]
    # another time there is nothing to do
    before = (tmp_path / "on/seed=0/result.json").read_bytes()
    assert run(tmp_path, *words, f"budget={budgets[1]}", "output=on", "resume=true") == 0
    assert (tmp_path / "on/seed=0/result.json").read_bytes() == before


@pytest.mark.slow
def test_less_is_refused_and_more_of_anything_else_is_too(tmp_path: Path, capfd: pytest.CaptureFixture[str]) -> None:
    words = (*BASE, "search=rdm", "output=on")
    assert run(tmp_path, *words, "budget=300") == 0
    for more, line in (
        ("budget=299", "error: budget=299: was 300 when the run in this folder was started"),
        ("max_crease_length=3", "max_crease_length was 2.9, is 3"),
        ("stages=[{budget:100}]", "error: stages="),
    ):
        capfd.readouterr()
        assert run(tmp_path, *words, *(("budget=300",) if "budget=" not in more[:7] else ()), more, "resume=true") == 2
        assert line in capfd.readouterr().err


@pytest.mark.slow
def test_a_run_without_states_goes_on_above_its_best(tmp_path: Path) -> None:
    """As those of before there were any: the counts add up, and the best stays unless there is a better one."""
    words = (*BASE, "search=evo", "search.population=12", "output=on")
    assert run(tmp_path, *words, "budget=1500") == 0
    before = rows(tmp_path / "on")[0]
    (tmp_path / "on/seed=0/search.npz").unlink()
    result = tmp_path / "on/seed=0/result.json"
    old = {k: v for k, v in json.loads(result.read_text()).items() if k not in ("stages", "ended", "chamfer")}
    result.write_text(json.dumps(old))
    assert run(tmp_path, *words, "budget=2500", "resume=true") == 0
    after = rows(tmp_path / "on")[0]
    assert after["interactions"] == 2500
    assert after["return"] >= before["return"]
    assert after["episodes"] > before["episodes"]
    assert after["stages"] == 2
    with (tmp_path / "on/seed=0/curve.csv").open() as file:
        steps = [int(line["interactions"]) for line in csv.DictReader(file)]
    assert steps == sorted(steps)
    assert before["interactions_to_best"] in steps


@pytest.mark.slow
def test_a_trial_ends_when_its_return_is_good_enough(tmp_path: Path, capfd: pytest.CaptureFixture[str]) -> None:
    words = ("target=pyramid", "search=lns", "tracking=none", "files=designs", "workers=1", "budget=20000")
    assert run(tmp_path, *words, "target_return=1.5", "output=on") == 0
    row = RunFolder(tmp_path / "on").rows()[0]
    assert row.ended == "target return"
    assert row.return_ >= -1.5
    assert row.interactions < 20_000
    assert "ended by target_return" in capfd.readouterr().out
    # as a part of its size it is reached at the same interaction: the pyramid is 2·√2 cells high
    assert run(tmp_path, *words, f"target_return={150 / 8**0.5}%", "output=percent") == 0
    assert RunFolder(tmp_path / "percent").rows()[0].interactions == row.interactions
    # without one it goes on
    assert run(tmp_path, *words, "output=on", "resume=true") == 0
    after = RunFolder(tmp_path / "on").rows()[0]
    assert (after.ended, after.interactions, after.stages) == ("budget", 20_000, 2)
    assert after.return_ >= row.return_


@pytest.mark.slow
def test_minutes_end_a_trial_and_are_recorded(tmp_path: Path, capfd: pytest.CaptureFixture[str]) -> None:
    words = ("target=bowl", "search=rdm", "tracking=none", "files=designs", "workers=1", "budget=1_000_000_000")
    assert run(tmp_path, *words, "minutes=0.01", "output=on") == 0
    said = capfd.readouterr()
    row = RunFolder(tmp_path / "on").rows()[0]
    assert row.ended == "minutes"
    assert row.status == "ok" or row.status == "no design"
    assert row.interactions < 10**9
    assert row.seconds >= 0.6
    assert "not reproducible by the seed alone" in said.err
    assert "not reproducible by the seed alone" in said.out
    summary = json.loads((tmp_path / "on/summary.json").read_text())
    assert summary["ended"] == {"minutes": 1}
    # its minutes are spent: there is nothing to do, and with more of them there is
    before = row
    assert run(tmp_path, *words, "minutes=0.01", "output=on", "resume=true") == 0
    assert RunFolder(tmp_path / "on").rows()[0] == before
    assert run(tmp_path, *words, "minutes=0.02", "output=on", "resume=true") == 0
    assert RunFolder(tmp_path / "on").rows()[0].interactions > before.interactions


def test_a_stage_has_random_numbers_of_its_own() -> None:
    assert stage_generator(5, 0).random() == np.random.default_rng(np.random.SeedSequence(5)).random()
    draws = {stage_generator(seed, number).random() for seed in range(5) for number in range(5)}
    assert len(draws) == 25


def settings_of(*more: str) -> Any:
    return compose_settings([*BASE, "search=rdm", *more])


def same_state(one: SearchState, other: SearchState) -> bool:
    """Whether two states are the same but for their seconds."""
    arrays = one.searcher.keys() == other.searcher.keys() and all(
        np.array_equal(one.searcher[name], other.searcher[name]) for name in one.searcher
    )
    return arrays and one.stages == other.stages and one.outcome == other.outcome


def played(settings: Any, searcher: Any = None, begun: Any = None, stop: Any = None) -> Any:
    def make() -> Parts:
        parts = build_parts(settings)
        return parts if searcher is None else replace(parts, searcher=searcher())

    checkpoints = Checkpoint(Path("nowhere"), 0)  # none of these searchers saves itself on the way
    return search_in_stages(settings, 0, make(), make, begun, checkpoints, lambda problem, seconds: None, stop)


def test_a_searcher_of_the_user_s_may_save_and_load() -> None:
    whole = played(settings_of("budget=60", "stages=[{budget:20},{budget:40}]"), Counting)
    assert whole.state.searcher["searches"].tolist() == [3]
    assert whole.stages == 3
    first = played(settings_of("budget=20"), Counting)
    second = played(settings_of("budget=40", "stages=[{budget:20}]"), Counting, state_of_bytes(first.state.to_bytes()))
    third = played(
        settings_of("budget=60", "stages=[{budget:20},{budget:40}]"), Counting, state_of_bytes(second.state.to_bytes())
    )
    assert third.outcome == whole.outcome
    assert third.state.searcher["searches"].tolist() == [3]


def test_what_cannot_be_saved_costs_a_warning_and_no_trial() -> None:
    class Wrong(Counting):
        def save(self) -> dict[str, Any]:
            return {"self": object()}

    found = played(settings_of("budget=20"), Wrong)
    assert found.outcome.interactions == 20
    assert found.state.searcher == {}
    [warning] = found.warnings
    assert "not kept" in warning


def test_a_stage_that_is_stopped_keeps_the_one_before_it() -> None:
    first = played(settings_of("budget=20"), Counting)
    settings = settings_of("budget=100000", "stages=[{budget:20}]")
    stopped = played(settings, Counting, first.state, lambda: True)
    assert stopped.status == "stopped"
    assert stopped.stages == 1
    assert stopped.state == first.state
    assert stopped.outcome.interactions >= 20


@pytest.mark.parametrize("kind", [EvolutionarySearch, NeighbourhoodSearch])
def test_a_searcher_that_has_loaded_nothing_begins_anew(kind: Any) -> None:
    """The same object, used twice, searches as a fresh one does."""
    parts, searcher, found = build_parts(settings_of("budget=500")), kind(), []
    for _ in range(2):
        problem = Problem(parts.game, parts.objective, 500)
        searcher.search(problem, np.random.default_rng(3))
        found.append(problem.outcome())
    assert found[0] == found[1]


def test_a_row_says_whether_there_is_more_to_do() -> None:
    row = TrialRow(
        seed=0, return_=-1.0, interactions_to_best=5, interactions=100, status="ok", ended="budget", stages=1
    )
    assert row.has_gone_through(1, 100)
    assert not row.has_gone_through(2, 200)
    assert row.has_gone_through(2, 100)  # nothing more was asked for
    old = TrialRow(seed=0, return_=-1.0, interactions_to_best=5, interactions=60, status="ok")
    assert old.has_gone_through(1, 100)  # its searcher ended by itself, or it has been there
    assert not old.has_gone_through(2, 200)
    assert not TrialRow.failed(0, "it broke").has_gone_through(1, 1)


def test_a_damaged_state_is_none(tmp_path: Path) -> None:
    state = played(settings_of("budget=20"), Counting).state
    file = tmp_path / "search.npz"
    file.write_bytes(state.to_bytes())
    (tmp_path / "result.json").write_text(json.dumps({"stages_of_search": list(state.record)}))
    found = read_state(tmp_path)
    assert found is not None
    assert same_state(found, state)
    assert (found.record, found.seconds) == (state.record, pytest.approx(state.seconds, abs=1e-3))
    for content in (b"", state.to_bytes()[:-40], b"PK\x03\x04" + bytes(100)):
        file.write_bytes(content)
        assert read_state(tmp_path) is None
    shutil.rmtree(tmp_path)
    assert read_state(tmp_path) is None


def test_the_same_search_leaves_the_same_bytes() -> None:
    settings = compose_settings([*BASE, "search=evo", "search.population=12", "budget=400"])
    assert played(settings).state.to_bytes() == played(settings).state.to_bytes()
