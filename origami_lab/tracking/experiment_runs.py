"""The MLflow runs of one run folder: the parent, and a child for each seed."""

from __future__ import annotations

import csv
import json
import time
import uuid
from collections.abc import Collection, Iterator, Mapping
from contextlib import contextmanager
from pathlib import Path
from typing import TYPE_CHECKING, Any

from omegaconf import OmegaConf

from origami_lab.config.config_file import read_config_file
from origami_lab.config.node import FREE_TO_CHANGE, OF_STAGES, flatten
from origami_lab.config.seeds import format_seeds
from origami_lab.config.settings import Settings, read_settings
from origami_lab.errors import InputError
from origami_lab.file_names import (
    BEST,
    CERTIFICATE,
    CONFIG,
    CURVE,
    FILM,
    FOLDED_PNG,
    PATTERN_PNG,
    PATTERN_SVG,
    POLISHED,
    RESULT,
    STATE,
    SUMMARY,
    TRIALS,
    VIEWER,
    error_file,
    trial_folder,
)
from origami_lab.files import is_regular
from origami_lab.runs.locks import held, locked
from origami_lab.runs.multirun_folder import membership
from origami_lab.runs.run_folder import RunFolder, read_note, read_summary, write_note
from origami_lab.runs.trial_row import (
    NOT_CHECKED,
    STATUSES,
    STOPPED,
    VERDICTS,
    TrialRow,
    best_row,
    certificates,
    counts,
    spreads,
)
from origami_lab.tracking.descriptions import Artifacts, experiment_note, run_name, run_note, trial_note
from origami_lab.tracking.learning_curve import mean_curve
from origami_lab.tracking.mlflow_limits import LONGEST_NAME, fitting
from origami_lab.tracking.mlflow_log import CONTENT, PARENT, Logged, MlflowLog, digest, metrics_of
from origami_lab.tracking.moved_store import address_note, noted_store
from origami_lab.tracking.shown_view import CURVE as SHOWN_CURVE
from origami_lab.tracking.shown_view import NOTE, experiment_view
from origami_lab.tracking.store import RefusedError, absolute_uri

if TYPE_CHECKING:
    from mlflow.entities import Metric

FOLDER_ARTIFACTS = (CONFIG, TRIALS, SUMMARY)
OF_THE_BEST = (PATTERN_PNG, FOLDED_PNG, FILM, VIEWER, PATTERN_SVG, CERTIFICATE)
"""Files of the best trial that the parent has too."""


def read_run(folder: Path) -> Settings:
    """The settings that a run folder was made with.

    Raises
    ------
    InputError
        If its config.yaml cannot be read or is not one.
    """
    return read_settings(OmegaConf.create(read_config_file("configuration", folder / CONFIG)))


class ExperimentRuns(MlflowLog):
    """A run folder and its runs in one store: the parent, and nested in it one for each seed."""

    number_tag = "seed"
    source = "origami-lab"

    def __init__(self, folder: Path, uri: str, keep: bool = False) -> None:
        self._read: tuple[object, Settings] | None = None
        """The settings, and the state of config.yaml when they were read."""
        self.multirun = membership(folder)
        """All jobs of a multirun go to one experiment, where their names and tags say what differs."""
        self.folder = folder
        _ = self.settings  # a folder that is no run's is refused before its store is opened
        super().__init__(folder, uri, keep)

    @property
    def settings(self) -> Settings:
        """The settings of the run; they are checked again only when config.yaml has changed."""
        try:
            file = (self.folder / CONFIG).stat()
            state = (file.st_mtime_ns, file.st_size, file.st_ino)
        except OSError:
            state = None
        if self._read is None or state is None or self._read[0] != state:
            self._read = (state, read_run(self.folder))
        return self._read[1]

    # --- the folder ---

    @staticmethod
    def store_of(folder: Path) -> str | None:
        configured = read_run(folder).tracking.uri
        return noted_store(folder, configured) or configured

    @staticmethod
    @contextmanager
    def alone(folder: Path) -> Iterator[bool]:
        try:
            with locked(folder):
                pass  # not kept: a run that is resumed now waits for this push, and need not be refused
        except InputError:
            yield False
            return
        with held(folder, wait=False) as free:
            yield free

    def _take_up_key(self, keep: bool) -> str:
        note = read_note(self.folder)
        key = str(note.get("key") or uuid.uuid4().hex)
        known = noted_store(self.folder) if keep and note.get("key") else None
        changed = {"key": key, **address_note(self.folder, known or absolute_uri(self.uri))}
        if changed != note:
            try:
                write_note(self.folder, changed)
            except OSError as error:  # the folder's trouble, not the store's
                raise RefusedError(f"{self.folder} cannot be written ({error.strerror or error})") from error
        return key

    def _experiment_name(self) -> str:
        job = self.multirun[0].experiment if self.multirun else None
        return str(self.settings.tracking.experiment or job or self.settings.task)

    def _entries(self, live: bool, numbers: Collection[int] | None) -> dict[int, TrialRow]:
        """The rows by seed. Stopped trials of a live run, which will run again, wait."""
        rows = RunFolder(self.folder).known_rows(numbers)
        return {seed: row for seed, row in rows.items() if not (live and row.outcome == STOPPED)}

    # --- the runs ---

    def _take_up_root(self, live: bool) -> str:
        if self.root is None:
            name = self.multirun[1].name if self.multirun else f"{self.settings.task} {self.settings.method}"
            began = (self.folder / CONFIG).stat().st_mtime
            self.root = Logged(self._create(name, self._tags(), self._root_params(), began), None)
            self._show_as(experiment_view(), experiment_note(self._experiment_name(), self.experiment))
        elif live and self.root.content is not None:
            self.client.update_run(self.root.run, status="RUNNING")
            self.root = Logged(self.root.run, None)
        return self.root.run

    def _root_params(self) -> dict[str, str]:
        """The configuration, but for settings that a resumed run may have changed; its budget is the first one."""
        changing = (*FREE_TO_CHANGE, *(key for key in OF_STAGES if key != "budget"))
        fixed = {key: value for key, value in self.settings.config.items() if key not in changing}
        return {key: str(value) for key, value in flatten(fixed).items()}

    def _push_entry(self, root: str, seed: int, row: TrialRow) -> bool:
        content = digest(row.said())
        if self._is_there(seed, content):
            return False
        path = trial_folder(self.folder, seed)
        failed = row.has_failed
        error = error_file(self.folder, seed)
        source = path / RESULT if not failed else error
        ended = (source if source.is_file() else self.folder / TRIALS).stat().st_mtime
        tags = self._tags() | {PARENT: root, "seed": str(seed), CONTENT: content}
        name = f"seed {seed} · {self.multirun[1].name}" if self.multirun else f"seed {seed}"
        run = self._create(name, tags, self._root_params() | {"seed": str(seed)}, ended - (row.seconds or 0.0))
        metrics = metrics_of({name: value for name, value in row.values().items() if name != "seed"}, ended)
        if path.is_dir() and not failed:
            metrics += _curve(path / CURVE, ended)
        words = ("certificate", "polish", "polished_certificate", "ended")
        found = path.is_dir() and not failed
        # a link may lead to what is not for others; the state is of use where the run goes on, in its folder
        files = [file for file in sorted(path.iterdir()) if is_regular(file) and file.name != STATE] if found else []
        note = trial_note(row, Artifacts(self.experiment, run), [file.name for file in files])
        tags = {"status": row.status, **{name: row[name] for name in words if row[name]}, NOTE: note}
        self._log(run, metrics, tags)
        if found:
            for file in files:
                self.client.log_artifact(run, str(file))
            # the viewer shows JSON, not .fold
            self.client.log_text(run, (path / BEST).read_text(encoding="utf-8"), f"{BEST}.json")
        elif is_regular(error):
            self.client.log_artifact(run, str(error))
        self._end(run, "FAILED" if failed else "KILLED" if row.outcome == STOPPED else "FINISHED", ended)
        self.nested[seed] = [Logged(run, content)]
        return True

    def _end_root(self, root: str, rows: Mapping[int, TrialRow]) -> bool:
        """Log the experiment's figures, table and best pictures on the parent and end it; whether that was to do."""
        summary = read_summary(self.folder)
        whole = all(seed in rows and rows[seed].outcome != STOPPED for seed in self.settings.seeds)
        content = digest({"rows": {seed: row.said() for seed, row in rows.items()}, "summary": summary})
        if self.root == Logged(root, content):
            return False
        self._log_figures(root, rows, summary)
        for name in FOLDER_ARTIFACTS:
            if is_regular(self.folder / name):
                self.client.log_artifact(root, str(self.folder / name))
        best, shown = best_row(rows.values()), list[str]()
        if best is not None:
            for name in OF_THE_BEST:
                if is_regular(file := trial_folder(self.folder, best.seed) / name):
                    self.client.log_artifact(root, str(file), "best")
                    shown.append(name)
        polished = best_row(rows.values(), "polished_return")
        if polished is not None:
            for file in sorted(trial_folder(self.folder, polished.seed).glob(f"{POLISHED}*")):
                self.client.log_artifact(root, str(file), "best_polished")
        self._describe(root, rows, best, summary, shown)
        files = [self.folder / name for name in FOLDER_ARTIFACTS]
        self.client.set_tag(root, CONTENT, content)
        ended = max(file.stat().st_mtime for file in files if file.is_file())
        self._end(root, "FINISHED" if whole else "KILLED", ended)
        self.root = Logged(root, content)
        return True

    def _describe(
        self,
        root: str,
        rows: Mapping[int, TrialRow],
        best: TrialRow | None,
        summary: Mapping[str, Any],
        shown: Collection[str],
    ) -> None:
        """Name and describe the experiment's run, and show its learning curve."""
        settings, spread = self.settings, spreads(rows.values()).get("return")
        command, seeds = str(summary.get("command") or ""), len(settings.seeds)
        name = self.multirun[1].name if self.multirun else run_name(settings.task, settings.method, command, seeds)
        self.client.update_run(root, name=fitting(name, LONGEST_NAME))
        note = run_note(name, spread, best, summary, Artifacts(self.experiment, root), shown)
        folders = [trial_folder(self.folder, row.seed) for row in rows.values() if row.spent_budget]
        curve = mean_curve([folder / CURVE for folder in folders])
        when = time.time()
        metrics = [metric for step, value in curve for metric in metrics_of({SHOWN_CURVE: value}, when, step)]
        self._log(root, metrics, {NOTE: note})
        self._show_as(experiment_view(), experiment_note(self._experiment_name(), self.experiment))

    def _log_figures(self, run: str, rows: Mapping[int, TrialRow], summary: Mapping[str, Any]) -> None:
        """From the rows, because a run that was killed has no summary, or an old one."""
        ended = counts(rows.values())
        figures: dict[str, Any] = {}
        for name, spread in spreads(rows.values()).items():  # the first one is what MLflow's comparison plots
            figures |= {f"{name}_mean": spread.mean, f"{name}_std": spread.std}
        for name in ("interactions", "places_evaluated"):
            figures[name] = sum(row[name] or 0 for row in rows.values())
        figures["seconds"] = summary.get("seconds")
        # all of them, so that none is left from before a resume
        for name in STATUSES:
            figures[f"trials_{name.replace(' ', '_')}"] = ended.get(name, 0)
        if found := certificates(rows.values()):
            said = (*VERDICTS, NOT_CHECKED)
            figures |= {f"designs_{verdict.replace(' ', '_')}": len(found.get(verdict, [])) for verdict in said}
        best = best_row(rows.values())
        if best is not None:
            figures |= {"best_return": best.return_, "best_seed": best.seed}
        polished = best_row(rows.values(), "polished_return")
        if polished is not None:
            figures |= {"best_polished_return": polished.polished_return, "best_polished_seed": polished.seed}
        tags = {"seeds": str(format_seeds(self.settings.seeds)), "command": str(summary.get("command", ""))}
        tags |= self._stage_tags()
        if best is not None and best.certificate:
            tags["certificate"] = best.certificate
        self._log(run, metrics_of(figures, time.time()), tags)

    def _stage_tags(self) -> dict[str, str]:
        """What the run has been given by now, where that is not its budget alone."""
        stages = [*self.settings.stages, self.settings.stage]
        if len(stages) == 1 and stages[0].target_return is None and stages[0].minutes is None:
            return {}
        return {"stages": json.dumps([stage.to_node() for stage in stages])}

    def _tags(self) -> dict[str, str]:
        """Tags of all runs; those of a multirun find its runs, and tell its jobs apart."""
        settings = self.settings
        tags = {
            "task": settings.task,
            "search": settings.method,
            "folder": str(self.folder.absolute()),
            "seeds": str(format_seeds(settings.seeds)),
            **self._stage_tags(),
        }
        if self.multirun is not None:
            index, job = self.multirun
            tags |= {"multirun": index.id, "job": str(index.jobs.index(job)), "differs": job.differs}
        return tags


def _curve(path: Path, when: float) -> list[Metric]:
    """The best return so far, with interactions as steps."""
    with path.open(newline="", encoding="utf-8") as file:
        return [
            metric
            for row in csv.DictReader(file)
            for metric in metrics_of({"best_return": float(row["return"])}, when, int(row["interactions"]))
        ]
