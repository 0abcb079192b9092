"""The MLflow runs of a study: one for the study, nested in it one for each trial, and in these one for each seed."""

from __future__ import annotations

import platform
import time
from collections.abc import Collection, Mapping
from pathlib import Path
from typing import Any

from origami_lab.config.checked_values import shown
from origami_lab.config.node import flatten
from origami_lab.files import is_regular
from origami_lab.runs.run_folder import read_note, read_summary
from origami_lab.sweep.study_record import read_record
from origami_lab.tracking.descriptions import study_note, study_run_note, study_trial_note
from origami_lab.tracking.mlflow_log import CONTENT, PARENT, Logged, MlflowLog, digest, metrics_of
from origami_lab.tracking.moved_store import noted_store
from origami_lab.tracking.shown_view import NOTE, study_view

ARTIFACTS = (
    *("best.yaml", "summary.md", "summary.json", "trials.csv"),
    *("held_out.png", "history.png", "importance.png", "slices.png"),
)
ENDINGS = {"complete": "FINISHED", "pruned": "KILLED", "failed": "FAILED"}


class StudyRuns(MlflowLog):
    """A study's folder and its runs in one store."""

    number_tag = "trial"
    source = "origami-lab sweep"
    shared = True

    def __init__(self, folder: Path, uri: str, keep: bool = False) -> None:
        self.record = read_record(folder)
        super().__init__(folder, uri, keep)

    # --- the folder ---

    @staticmethod
    def store_of(folder: Path) -> str | None:
        return noted_store(folder)

    def _take_up_key(self, keep: bool) -> str:
        """The key of the study, the same on all machines."""
        return str(self.record["key"])

    def _experiment_name(self) -> str:
        return str(read_note(self.folder).get("experiment") or f"sweep {self.record['study']}")

    def _entries(self, live: bool, numbers: Collection[int] | None) -> dict[int, Mapping[str, Any]]:
        """The trials that have ended. While the study goes on those of other machines are left to them."""
        self.record = read_record(self.folder)
        trials = {int(trial["trial"]): trial for trial in self.record["ended"]}
        chosen = trials.keys() if numbers is None else trials.keys() & numbers
        return {number: trials[number] for number in chosen if not live or self._is_ours(trials[number])}

    def _is_ours(self, trial: Mapping[str, Any]) -> bool:
        """Whether a worker of this machine played it, for this folder."""
        played = Path(trial["folder"])  # where it was then
        inside = played.is_relative_to(self.folder.absolute()) or (self.folder / "trials" / played.name).is_dir()
        return inside and trial["host"] in (platform.node(), "")

    # --- the runs ---

    def _take_up_root(self, live: bool) -> str:
        if self.root is None:
            record = self.record
            tags = {"study": record["study"], "folder": str(self.folder.absolute())}
            began = min((trial["began"] for trial in record["ended"]), default=time.time())
            self._create(str(record["study"]), tags, self._root_params(), began)
            view = study_view(list(record["declaration"]["space"]))
            self._show_as(view, study_note(str(record["study"]), self.experiment))
            self._look()  # another machine may have made it, too: all take the same one
            assert self.root is not None
        return self.root.run

    def _root_params(self) -> dict[str, str]:
        declared = self.record["declaration"]
        return _params({**declared, "task": " ".join(declared["task"])})

    def _push_entry(self, root: str, number: int, trial: Mapping[str, Any]) -> bool:
        content = digest(trial)
        if self._is_there(number, content):
            return False
        began, ended = trial["began"], trial["ended"]
        params = _params({**trial["point"], "searcher": self.record["declaration"]["searcher"]})
        tags = {PARENT: root, "trial": str(number), CONTENT: content, "folder": str(trial["folder"])}
        run = self._create(f"trial {number}", {**tags, "state": trial["state"]}, params, began)
        for seed, value in trial["returns"].items():
            below = self._create(f"trial {number} · seed {seed}", {PARENT: run, "seed": seed}, params, began)
            self._log(below, metrics_of({"return": value}, ended), {})
            self._end(below, "FINISHED", ended)
        metrics = []
        for step, value in enumerate(trial["returns"].values()):
            metrics += metrics_of({"seed_return": value}, ended, step)
        if trial["state"] == "complete":  # the mean of fewer seeds would stand among those of all
            metrics += metrics_of({"mean_return": trial["value"]}, ended)
        described = {NOTE: study_trial_note(trial)} | ({"reason": trial["reason"]} if trial["reason"] else {})
        self._log(run, metrics, described)
        self._end(run, ENDINGS[trial["state"]], ended)
        self.nested[number] = [Logged(run, content)]
        return True

    def _end_root(self, root: str, trials: Mapping[int, Mapping[str, Any]]) -> bool:
        """Log the study's figures and files on its run, and end it; whether that was to do."""
        summary = read_summary(self.folder)
        content = digest({"record": self.record, "summary": summary})
        if self.root == Logged(root, content):
            return False
        ended = max((trial["ended"] for trial in trials.values()), default=time.time())
        metrics, best = [], None
        for number, trial in trials.items():
            if trial["state"] == "complete" and (best is None or trial["value"] > best):
                best = trial["value"]
                metrics += metrics_of({"best_mean_return": best}, trial["ended"], number)
        states = [trial["state"] for trial in trials.values()]
        figures = {f"trials_{state}": states.count(state) for state in ENDINGS}
        held_out = summary.get("held_out") or {}
        for name, found in held_out.get("settings", {}).items():
            figures[f"held_out_{name}_mean"] = found["mean"]
        for name, found in held_out.get("differences", {}).items():
            figures |= {f"best_minus_{name}_{figure}": found[figure] for figure in ("mean", "low", "high", "p")}
        tags = {"command": str(summary.get("command", "")), "best_trial": str(self.record["best"])}
        tags[NOTE] = study_run_note(self.record["study"], summary)
        self._log(root, metrics + metrics_of(figures, ended), tags)
        for name in ARTIFACTS:
            if is_regular(self.folder / name):
                self.client.log_artifact(root, str(self.folder / name))
        self.client.set_tag(root, CONTENT, content)
        self._end(root, "FINISHED" if len(trials) >= int(self.record["trials"]) else "KILLED", ended)
        self.root = Logged(root, content)
        return True


def _params(values: Mapping[str, Any]) -> dict[str, str]:
    return {key: shown(value) for key, value in flatten(values).items()}
