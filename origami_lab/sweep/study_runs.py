"""The MLflow runs of a study: one for the study, nested in it one for each trial, and in these one for each seed.

As with single experiments (:mod:`origami_lab.tracking.experiment_runs`) everything is read from the folder, and what
the store has is looked at first: whatever cut off a push, nothing is missing after the next one, and nothing twice.
"""

from __future__ import annotations

import platform
import time
from collections import defaultdict
from collections.abc import Callable, Mapping
from pathlib import Path
from typing import TYPE_CHECKING, Any

from origami_lab.config.checked_values import shown
from origami_lab.config.node import flatten
from origami_lab.runs.run_folder import read_summary
from origami_lab.sweep.study_record import read_record
from origami_lab.tracking.mlflow_log import BATCH, CONTENT, KEY, PARAMS, PARENT, digest
from origami_lab.tracking.store import experiment_id, in_plain_words, open_client, probe, runs_with_tag

if TYPE_CHECKING:
    from mlflow.entities import Metric, Run

TRIAL, SEED = "trial", "seed"
"""Tags: a trial's number in its study, and the seed of a run below it."""
ARTIFACTS = (
    *("best.yaml", "summary.md", "summary.json", "trials.csv"),
    *("held_out.png", "history.png", "importance.png", "slices.png"),
)
ENDINGS = {"complete": "FINISHED", "pruned": "KILLED", "failed": "FAILED"}


class StudyRuns:
    """A study's folder and its runs in one store.

    Parameters
    ----------
    name
        The MLflow experiment; None for the study's task.

    Raises
    ------
    StoreError
        If the store does not answer; RefusedError if it does not take them.
    """

    def __init__(self, folder: Path, uri: str, name: str | None = None) -> None:
        self.folder, self.uri = folder, uri
        self.study: Run | None = None
        self.trials: defaultdict[int, list[Run]] = defaultdict(list)
        self.seeds: defaultdict[str, list[str]] = defaultdict(list)
        """The runs below each trial's, by its id."""
        record = read_record(folder)
        self.key = str(record["key"])
        self.unsure = True
        with in_plain_words(uri):
            probe(uri)
            self.client = open_client(uri)
            self.experiment = experiment_id(self.client, uri, name or f"sweep {record['study']}")

    def push(self, live: bool, pushed: Callable[[int], None] = lambda trial: None) -> int:
        """Add what the store does not have yet; how many trials.

        Parameters
        ----------
        live
            The study goes on: its run is left open, and trials of other machines are left to them.
        pushed
            Called for each trial that was added.
        """
        record, added = read_record(self.folder), 0
        with in_plain_words(self.uri):
            if self.unsure or not live:  # others may have pushed meanwhile
                self._look()
            study = self._study_run(record)
            for trial in record["ended"]:
                if (not live or self._is_ours(trial)) and self._push_trial(study, record, trial):
                    added += 1
                    pushed(int(trial["trial"]))
            if not live:
                self._end_study(study, record)
        return added

    def _is_ours(self, trial: Mapping[str, Any]) -> bool:
        """Whether a worker of this machine played it, for this folder."""
        inside = Path(trial["folder"]).is_relative_to(self.folder.absolute())
        return inside and trial["host"] in (platform.node(), "")

    def _look(self) -> None:
        """Find the study's run, the trials' by number, and those below; superfluous ones of the study are deleted."""
        found = runs_with_tag(self.client, self.experiment, KEY, self.key)
        nested = [run for run in found if TRIAL in run.data.tags]
        used = {run.data.tags[PARENT] for run in nested}
        studies = sorted(
            (run for run in found if PARENT not in run.data.tags),
            key=lambda run: (run.info.run_id not in used, run.info.start_time, run.info.run_id),
        )
        for superfluous in studies[1:]:  # of two machines that began at once
            if superfluous.info.run_id not in used:
                self.client.delete_run(superfluous.info.run_id)
        self.study = studies[0] if studies else None
        self.trials.clear()
        self.seeds.clear()
        for run in nested:
            self.trials[int(run.data.tags[TRIAL])].append(run)
        for run in found:
            if SEED in run.data.tags:
                self.seeds[run.data.tags[PARENT]].append(str(run.info.run_id))
        self.unsure = False

    def _study_run(self, record: Mapping[str, Any]) -> str:
        if self.study is None:
            tags = {"study": record["study"], "folder": str(self.folder.absolute())}
            began = min((trial["began"] for trial in record["ended"]), default=time.time())
            declared = {**record["declaration"], "task": " ".join(record["declaration"]["task"])}
            self._create(str(record["study"]), tags, declared, began)
            self._look()  # another machine may have made it, too: all take the same one
            assert self.study is not None
        return str(self.study.info.run_id)

    def _push_trial(self, study: str, record: Mapping[str, Any], trial: Mapping[str, Any]) -> bool:
        """Log one trial, unless it is there; whether it was not."""
        from mlflow.entities import RunTag

        number, content = int(trial["trial"]), digest(dict(trial))
        there = [
            run for run in self.trials[number] if run.data.tags.get(CONTENT) == content and run.info.status != "RUNNING"
        ]
        for run in self.trials[number]:
            if run not in there[:1]:
                for superfluous in (*self.seeds.pop(run.info.run_id, ()), run.info.run_id):
                    self.client.delete_run(superfluous)
        self.trials[number] = there[:1]
        if there:
            return False
        tags = {PARENT: study, TRIAL: str(number), CONTENT: content, "folder": str(trial["folder"])}
        tags["state"] = trial["state"]
        values = {**trial["point"], "searcher": record["declaration"]["searcher"]}
        run = self._create(f"trial {number}", tags, values, trial["began"])
        for seed, value in trial["returns"].items():
            below = self._create(f"trial {number} · seed {seed}", {PARENT: run, SEED: seed}, values, trial["began"])
            self.client.log_batch(below, metrics=[self._metric("return", value, trial["ended"])])
            self.client.set_terminated(below, "FINISHED", int(trial["ended"] * 1000))
            self.seeds[run].append(below)
        returns = trial["returns"].values()
        metrics = [self._metric("seed_return", value, trial["ended"], step) for step, value in enumerate(returns)]
        if trial["state"] == "complete":  # the mean of fewer seeds would stand among those of all
            metrics.append(self._metric("mean_return", trial["value"], trial["ended"]))
        reason = [RunTag("reason", trial["reason"])] if trial["reason"] else []
        for first in range(0, max(len(metrics), 1), BATCH):
            self.client.log_batch(run, metrics=metrics[first : first + BATCH], tags=reason)
        self.client.set_terminated(run, ENDINGS[trial["state"]], int(trial["ended"] * 1000))
        self.trials[number] = [self.client.get_run(run)]
        return True

    def _end_study(self, run: str, record: Mapping[str, Any]) -> None:
        """Log the study's figures and files on its run, and end it."""
        from mlflow.entities import RunTag

        assert self.study is not None
        summary = read_summary(self.folder)
        content = digest({"record": record, "summary": summary})
        if self.study.data.tags.get(CONTENT) == content and self.study.info.status != "RUNNING":
            return
        ended = max((trial["ended"] for trial in record["ended"]), default=time.time())
        metrics, best = [], None
        for trial in record["ended"]:
            if trial["state"] == "complete" and (best is None or trial["value"] > best):
                best = trial["value"]
                metrics.append(self._metric("best_mean_return", best, trial["ended"], trial["trial"]))
        for state in ENDINGS:
            count = sum(trial["state"] == state for trial in record["ended"])
            metrics.append(self._metric(f"trials_{state}", count, ended))
        held_out = summary.get("held_out") or {}
        for name, found in held_out.get("settings", {}).items():
            metrics.append(self._metric(f"held_out_{name}_mean", found["mean"], ended))
        for name, found in held_out.get("differences", {}).items():
            for figure in ("mean", "low", "high", "p"):
                metrics.append(self._metric(f"best_minus_{name}_{figure}", found[figure], ended))
        for first in range(0, len(metrics), BATCH):
            self.client.log_batch(run, metrics=metrics[first : first + BATCH])
        for name in ARTIFACTS:
            if (self.folder / name).is_file():
                self.client.log_artifact(run, str(self.folder / name))
        tags = {CONTENT: content, "command": str(summary.get("command", "")), "best_trial": str(record["best"])}
        self.client.log_batch(run, tags=[RunTag(*item) for item in tags.items()])
        done = len(record["ended"]) >= int(record["trials"])
        self.client.set_terminated(run, "FINISHED" if done else "KILLED", int(ended * 1000))
        self.study = self.client.get_run(run)

    def _create(self, name: str, tags: Mapping[str, str], values: Mapping[str, Any], began: float) -> str:
        from mlflow.entities import Param

        tags = {KEY: self.key, "mlflow.source.name": "origami-lab sweep", **tags}
        run = str(self.client.create_run(self.experiment, int(began * 1000), tags, name).info.run_id)
        params = [Param(key, shown(value)) for key, value in flatten(values).items()]
        for first in range(0, len(params), PARAMS):
            self.client.log_batch(run, params=params[first : first + PARAMS])
        return run

    def _metric(self, name: str, value: float, when: float, step: int = 0) -> Metric:
        from mlflow.entities import Metric

        return Metric(name, float(value), int(when * 1000), int(step))
