"""A trial keeps no design that is refuted while it has another one, and all its files are of the one that is kept."""

from __future__ import annotations

import csv
import json
import math
import shutil
from contextlib import suppress
from dataclasses import dataclass, replace
from pathlib import Path
from types import MappingProxyType
from typing import Any

import pytest

from origami_lab.config.compose import compose_settings
from origami_lab.config.instantiate import Parts, build_parts
from origami_lab.experiment.kept_design import MOST_STEPS_BACK, keep_design
from origami_lab.experiment.runner import summarise
from origami_lab.experiment.staged_search import stage_generator
from origami_lab.experiment.trial import run_trial
from origami_lab.fold_format.writer import read_fold
from origami_lab.game.crease_pattern import CreasePattern
from origami_lab.runs.result import load
from origami_lab.runs.run_folder import RunFolder, read_summary
from origami_lab.runs.trial_row import TrialRow, read_trials
from origami_lab.search.problem import Improvement, Outcome, Problem, SearchEnded
from origami_lab.tracking.store import open_client
from origami_lab.verification import verify_design as checking
from origami_lab.verification.certificate import Certificate, Check
from origami_lab.verification.verify_design import verify
from tests.small_runs import TIMINGS, run
from tests.sweep.conftest import declare, play_here, write_file

CONF = Path(__file__).parent / "conf"
CARELESS = (
    *("objective=height", "search=careless", "board=13x13", "symmetry=none", "budget=6000"),
    *("driving_angle.count=2", "driving_angle.max=60", "straight_sectors=false"),
)
"""A search whose better designs pass through themselves between two driving angles."""
TRUSTED = "trust=origami-lab"
"""Installed to be developed in place, it has these tests, too."""
COMMAND = ("--config-dir", str(CONF), *CARELESS, "workers=1", "verbosity=quiet", "output=out", TRUSTED)
SEEDS = range(3)


@dataclass
class Found:
    """What a careless search finds, played and verified here."""

    parts: Parts
    outcome: Outcome
    verdicts: list[str]

    @property
    def kept(self) -> int:
        """The place of the last improvement that is not refuted."""
        return max(place for place, verdict in enumerate(self.verdicts) if verdict != "refuted")


@pytest.fixture(scope="module")
def found() -> list[Found]:
    outcomes = []
    for seed in SEEDS:
        parts = build_parts(compose_settings(CARELESS, CONF))
        problem = Problem(parts.game, parts.objective, 6000)
        with suppress(SearchEnded):
            parts.searcher.search(problem, stage_generator(seed, 0))
        outcome = problem.outcome()
        designs = [parts.game.design(step.actions, step.angle) for step in outcome.improvements]
        outcomes.append(Found(parts, outcome, [verify(design).verdict for design in designs]))
    # one goes back past others, to one that is certified or is not certifiable; one stays that is not certifiable
    assert {one.verdicts[one.kept] for one in outcomes if one.kept < len(one.verdicts) - 1} >= {"certified"}
    assert any(one.verdicts[-1] == "not certifiable" for one in outcomes)
    return outcomes


@pytest.fixture(scope="module")
def kept(tmp_path_factory: pytest.TempPathFactory) -> Path:
    folder = tmp_path_factory.mktemp("kept")
    assert run(folder, *COMMAND, "seed=0..2") == 0
    return folder


def untimed(row: TrialRow) -> dict[str, Any]:
    return {name: value for name, value in row.values().items() if name not in TIMINGS}


def check_trial(trial: Path, row: TrialRow, expected: Found) -> None:
    """All files of a trial are of the improvement that is to be kept."""
    place, steps = expected.kept, expected.outcome.improvements
    step, angles = steps[place], expected.parts.game.angles
    degrees = math.degrees(angles[step.angle])
    design = expected.parts.game.design(step.actions, step.angle)
    assert (row.return_, row.driving_angle, row.interactions_to_best) == (step.value, degrees, step.interaction)
    assert (row.vertices, row.panels, row.interactions) == (len(design.vertices), len(design.panels), 6000)
    assert row.certificate == expected.verdicts[place]
    saved = json.loads((trial / "actions.json").read_text())
    assert (tuple(saved["actions"]), saved["angle"], saved["return"]) == (step.actions, step.angle, step.value)
    with (trial / "curve.csv").open() as file:
        curve = [(int(at["interactions"]), float(at["return"])) for at in csv.DictReader(file)]
    assert curve == [*((one.interaction, one.value) for one in steps[: place + 1]), (6000, step.value)]
    best = read_fold(trial / "best.fold")
    assert best.metadata["return"] == step.value
    assert best.vertices.tolist() == design.vertices.tolist()
    assert math.degrees(read_fold(trial / "motion.fold").frames[-1].driving_angle) == pytest.approx(degrees)
    found = json.loads((trial / "certificate.json").read_text())
    assert found == {**verify(trial / "best.fold").to_json(), "file": "best.fold"}
    assert found["verdict"] == row.certificate
    result = json.loads((trial / "result.json").read_text())
    passed_over = result.get("passed_over", [])
    assert [one["return"] for one in passed_over] == [one.value for one in reversed(steps[place + 1 :])]
    assert all(one["certificate"] == "refuted" and one["reason"] for one in passed_over)


@pytest.mark.slow
def test_files_tables_and_mlflow_are_those_of_the_kept_design(kept: Path, found: list[Found]) -> None:
    rows = read_trials(kept / "out/trials.csv")
    client = open_client(f"sqlite:///{kept}/results/mlflow.db")
    experiment = client.get_experiment_by_name("height")
    runs = client.search_runs([experiment.experiment_id])
    for row, expected in zip(rows, found, strict=True):
        check_trial(kept / f"out/seed={row.seed}", row, expected)
        (child,) = [one for one in runs if one.data.tags.get("seed") == str(row.seed)]
        assert child.data.metrics["return"] == row.return_
        assert child.data.tags["certificate"] == row.certificate
        history = client.get_metric_history(child.info.run_id, "best_return")
        assert max(point.value for point in history) == row.return_
    values = [one.outcome.improvements[one.kept].value for one in found]
    (parent,) = [one for one in runs if "mlflow.parentRunId" not in one.data.tags]
    assert parent.data.metrics["best_return"] == max(values)
    assert parent.data.metrics["designs_refuted"] == parent.data.metrics["designs_not_checked"] == 0
    summary = json.loads((kept / "out/summary.json").read_text())
    assert summary["returns"]["return"]["mean"] == pytest.approx(sum(values) / 3)
    result = load(kept / "out")
    assert result.trials["certificate"].tolist() == [one.verdicts[one.kept] for one in found]
    for seed, expected in zip(SEEDS, found, strict=True):
        step = expected.outcome.improvements[expected.kept]
        design = expected.parts.game.design(step.actions, step.angle)
        assert result.designs[seed].folded.tolist() == design.folded.tolist()


@pytest.mark.slow
def test_a_run_that_is_resumed_keeps_the_same(kept: Path, found: list[Found], tmp_path: Path) -> None:
    shutil.copytree(kept / "out", tmp_path / "out")
    shutil.rmtree(tmp_path / "out/seed=1")
    # a trial of before a refuted best gave way stays as it is
    file = tmp_path / "out/seed=2/result.json"
    old = {**json.loads(file.read_text()), "return": 99.0, "certificate": "refuted"}
    file.write_text(json.dumps(old))
    assert run(tmp_path, *COMMAND, "tracking=none", "resume=true") == 0
    before, after = (read_trials(place / "out/trials.csv") for place in (kept, tmp_path))
    assert [untimed(row) for row in after[:2]] == [untimed(row) for row in before[:2]]
    assert (after[2].return_, after[2].certificate) == (99.0, "refuted")
    check_trial(tmp_path / "out/seed=1", after[1], found[1])


@pytest.mark.slow
@pytest.mark.parametrize("setting", ["files=designs", "certify=none"])
def test_where_nothing_is_verified_the_column_says_so(setting: str, found: list[Found], tmp_path: Path) -> None:
    quiet = [*CARELESS, setting, "tracking=none", "seed=0", f"output={tmp_path / 'out'}"]
    settings = compose_settings(quiet, CONF)
    with RunFolder.opened(settings) as folder:
        folder.begin(settings.config, None, None)
        row, warnings = run_trial(settings, 0, folder)
        folder.write_trials([row])
        folder.write_summary(summarise(settings, {0: row}, [], 1.0, False))
    assert (row.certificate, row.return_, warnings) == ("not checked", found[0].outcome.value, [])
    assert not (tmp_path / "out/seed=0/certificate.json").exists()
    assert read_summary(tmp_path / "out")["certificates"] == {"not checked": 1}
    assert load(tmp_path / "out").trials["certificate"].tolist() == ["not checked"]
    assert run(tmp_path, "report", "out") == 0
    assert "not checked" in (tmp_path / "out/report/index.html").read_text()


@pytest.mark.slow
@pytest.mark.parametrize("files", [["files=all"], []])
def test_the_value_of_a_sweeps_trial_is_that_of_the_kept_designs(
    files: list[str], found: list[Found], tmp_path: Path
) -> None:
    task = [setting for setting in CARELESS if not setting.startswith(("search", "budget"))] + files
    changes = {"task": task, "searcher": "careless", "budget": 6000, "seeds": "0..2", "trials": 1}
    changes |= {"config_dir": str(CONF), "space": {"search.skip": {"choices": [0]}}}
    if files:  # in processes of its own
        file = write_file(tmp_path, **changes, held_out={"seeds": "50..51", "budget": 100})
        assert run(tmp_path, "sweep", str(file), TRUSTED) == 0
        (trial,) = csv.DictReader((tmp_path / "out/trials.csv").open())
        value = float(trial["value"])
    else:
        (slot,) = play_here(declare(tmp_path, **changes))
        value = slot.trial.value
    assert value == pytest.approx(sum(one.outcome.improvements[one.kept if files else -1].value for one in found) / 3)
    rows = read_trials(tmp_path / "out/trials/0000/trials.csv")
    verdicts = [one.verdicts[one.kept] for one in found] if files else ["not checked"] * 3
    assert [row.certificate for row in rows] == verdicts


@pytest.fixture(scope="module")
def many(found: list[Found]) -> tuple[Parts, Outcome]:
    """A search with thirty improvements, all of them the same design."""
    first = found[0].outcome.improvements[0]
    steps = tuple(Improvement(10 * k, float(k), first.angle, first.actions) for k in range(30))
    last = steps[-1]
    return found[0].parts, replace(found[0].outcome, value=last.value, improvements=steps, interactions_to_best=290)


@pytest.mark.parametrize("refuted", [0, 1, MOST_STEPS_BACK, MOST_STEPS_BACK + 1, 30])
@pytest.mark.parametrize("other", ["certified", "not certifiable", "raises"])
def test_at_most_twenty_are_looked_at(
    refuted: int, other: str, many: tuple[Parts, Outcome], tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    parts, outcome = many
    looked: list[float] = []

    def planted(file: Path, thickness: float = 0.0) -> Certificate:
        value = float(read_fold(file).metadata["return"])  # type: ignore[arg-type]
        looked.append(value)
        if value > 29.5 - refuted:
            return Certificate(str(file), (Check("crossing", "refuted", f"panels {value:g} and 2 cross"),))
        if other == "raises":
            raise RecursionError("too deep")
        return Certificate(str(file), (Check("motion", "ok" if other == "certified" else "not decidable", "so it is"),))

    def make(earlier: Outcome) -> CreasePattern:
        design = parts.game.design(earlier.actions, earlier.angle)
        return replace(design, metadata=MappingProxyType({"return": earlier.value, "driving_angle": 7.0}))

    monkeypatch.setattr(checking, "verify", planted)
    kept = keep_design(tmp_path, outcome, make, verifies=True)
    # the best one and twenty before it
    assert looked == [29.0 - k for k in range(min(refuted, 20) + 1)]
    goes_back = refuted <= 20
    value = 29.0 - refuted if goes_back else 29.0
    assert kept.outcome.value == kept.design.metadata["return"] == read_fold(tmp_path / "best.fold").metadata["return"]
    assert (kept.outcome.value, kept.outcome.interactions_to_best) == (value, 10 * value)
    assert [step.value for step in kept.outcome.improvements] == [float(k) for k in range(int(value) + 1)]
    verdict = ("not checked" if other == "raises" else other) if goes_back else "refuted"
    assert kept.verdict == verdict
    assert [one["return"] for one in kept.passed_over] == ([29.0 - k for k in range(refuted)] if goes_back else [])
    file = tmp_path / "certificate.json"
    assert file.exists() == (verdict != "not checked")
    if file.exists():
        assert json.loads(file.read_text())["verdict"] == verdict
    texts = " ".join(kept.warnings)
    assert ("panels 29 and 2 cross" in texts) == (refuted > 0)
    assert ("too deep" in texts) == (verdict == "not checked")
    assert len(kept.warnings) == (refuted > 0) + (verdict == "not checked")


def test_without_a_design_there_is_nothing_to_verify(many: tuple[Parts, Outcome], tmp_path: Path) -> None:
    parts, outcome = many
    nothing = replace(outcome, succeeded=False, improvements=(), actions=parts.game.bare_start(), angle=-1)
    kept = keep_design(tmp_path, nothing, lambda one: parts.game.design(one.actions, one.angle), verifies=True)
    assert (kept.outcome, kept.verdict, kept.warnings) == (nothing, None, ())
    assert (tmp_path / "best.fold").is_file()
    assert not (tmp_path / "certificate.json").exists()
