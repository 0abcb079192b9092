"""A stand-in for an MLflow store that counts requests and can break at any of them, and folders to push to it."""

from __future__ import annotations

import itertools
import json
from pathlib import Path
from types import SimpleNamespace
from typing import Any

import pytest

from origami_lab.config.compose import compose_settings
from origami_lab.runs.run_folder import RunFolder
from origami_lab.sweep.study_record import write_record
from origami_lab.tracking import mlflow_log
from tests.small_runs import trial_row


class LostError(ConnectionError):
    """The store broke; the words are those of a real one."""

    def __init__(self) -> None:
        super().__init__("Connection refused")


class Store:
    """The runs of one experiment, as :class:`MlflowClient` answers for them."""

    def __init__(self) -> None:
        self.runs: dict[str, Any] = {}
        self.tags: dict[str, str] = {}
        """Those of the experiment."""
        self.requests: list[str] = []
        self._ids = itertools.count()
        self.break_at: int | None = None
        """The request that breaks."""
        self.answer_lost = False
        """Whether it is carried out before."""

    def __getattr__(self, name: str) -> Any:
        carry_out = getattr(type(self), f"do_{name}")

        def request(*arguments: Any, **named: Any) -> Any:
            number = len(self.requests)
            self.requests.append(name)
            if number == self.break_at and not self.answer_lost:
                raise LostError
            answer = carry_out(self, *arguments, **named)
            if number == self.break_at:
                raise LostError
            return answer

        return request

    def do_search_runs(self, experiments: list[str], query: str, page_token: str | None) -> Any:
        class Page(list[Any]):
            token = None

        key = query.split("'")[1]
        return Page(run for run in self.runs.values() if run.data.tags["run_key"] == key)

    def do_create_run(self, experiment: str, start: int, tags: dict[str, str], name: str) -> Any:
        run = f"run {next(self._ids)}"
        info = SimpleNamespace(run_id=run, start_time=start, status="RUNNING", run_name=name)
        data = SimpleNamespace(tags=dict(tags), params={}, metrics=[], files=[])
        self.runs[run] = SimpleNamespace(info=info, data=data)
        return self.runs[run]

    def do_log_batch(self, run: str, metrics: Any = (), params: Any = (), tags: Any = ()) -> None:
        assert len(metrics) + len(params) + len(tags) <= 1000  # MLflow's limit
        assert len(params) <= 100
        data = self.runs[run].data
        data.metrics += [(metric.key, metric.step, metric.value) for metric in metrics]
        data.params |= {param.key: param.value for param in params}
        data.tags |= {tag.key: tag.value for tag in tags}

    def do_set_tag(self, run: str, key: str, value: str) -> None:
        self.runs[run].data.tags[key] = value

    def do_update_run(self, run: str, status: str | None = None, name: str | None = None) -> None:
        info = self.runs[run].info
        info.status, info.run_name = status or info.status, name or info.run_name

    def do_get_experiment(self, experiment: str) -> Any:
        return SimpleNamespace(tags=dict(self.tags))

    def do_set_experiment_tag(self, experiment: str, key: str, value: str) -> None:
        self.tags[key] = value

    def do_set_terminated(self, run: str, status: str, when: int) -> None:
        self.runs[run].info.status = status

    def do_delete_run(self, run: str) -> None:
        del self.runs[run]

    def do_log_artifact(self, run: str, file: str, folder: str = "") -> None:
        self.runs[run].data.files.append(f"{folder}/{Path(file).name}")

    def do_log_artifacts(self, run: str, folder: str) -> None:
        self.runs[run].data.files += [f"/{file.name}" for file in sorted(Path(folder).iterdir())]

    def do_log_text(self, run: str, text: str, name: str) -> None:
        self.runs[run].data.files.append(f"/{name}")

    def contents(self) -> list[Any]:
        """The runs as a person sees them, but for times: the name, what is in it, and the one that it is nested in."""
        names = {run: found.info.run_name for run, found in self.runs.items()}
        return sorted(
            (
                found.info.run_name,
                names.get(found.data.tags.get("mlflow.parentRunId", ""), ""),
                found.info.status,
                sorted(found.data.params.items()),
                sorted(set(found.data.metrics)),
                sorted(set(found.data.files)),
            )
            for found in self.runs.values()
        )


@pytest.fixture
def store(monkeypatch: pytest.MonkeyPatch) -> Store:
    """The store that is found at every URI."""
    found = Store()
    monkeypatch.setattr(mlflow_log, "probe", lambda uri: None)
    monkeypatch.setattr(mlflow_log, "open_client", lambda uri: found)
    monkeypatch.setattr(mlflow_log, "experiment_id", lambda client, uri, name: name)
    return found


def begin_run(folder: Path, seeds: str) -> None:
    """The beginning of a run whose trials nobody plays."""
    folder.mkdir()
    settings = compose_settings(["target=pyramid", "search=rdm", f"seed={seeds}"])
    RunFolder(folder).begin(settings.config, None, None)


def add_trial(folder: Path, seed: int) -> None:
    """Put a finished trial into a run folder: its folder first, then its line of the table."""
    run = RunFolder(folder)
    trial = run.trial(seed)
    trial.mkdir()
    (trial / "best.fold").write_text("{}")
    (trial / "curve.csv").write_text("interactions,return\n" + "".join(f"{i},{-1 / (i + seed)}\n" for i in range(1, 9)))
    row = trial_row(seed, -1.0 - seed)
    (trial / "result.json").write_text(json.dumps(row.values()))
    run.write_trials(run.known_rows().values())


def write_study(folder: Path, ended: int, trials: int) -> None:
    """The record of a study of which some trials have ended: complete, pruned and failed by turns."""
    folder.mkdir(exist_ok=True)
    states = itertools.cycle(["complete", "pruned", "failed"])
    record = {
        "study": "small",
        "key": "0123abcd",
        "declaration": {"task": ["target=pyramid"], "searcher": "evo", "space": {"search.elite": {"choices": [0, 1]}}},
        "trials": trials,
        "best": 0 if ended else None,
        "ended": [
            {
                "trial": number,
                "state": state,
                "value": None if state == "failed" else -1.0 - number,
                "point": {"search.elite": number % 2},
                "returns": {} if state == "failed" else {"0": -1.0, "1": -1.0 - 2 * number},
                "lost_before": 0,
                "reason": "" if state == "complete" else "why",
                "began": 1000.0 + number,
                "ended": 2000.0 + number,
                "folder": str(folder.absolute() / "trials" / f"{number:04d}"),
                "host": "",
            }
            for number, state in zip(range(ended), states, strict=False)
        ],
    }
    write_record(folder, record)
