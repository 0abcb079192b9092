"""The MLflow runs of one run folder: the parent, and a child for each seed.

:meth:`Runs.push` brings a store up to date with the folder, and is the only thing that writes to one: while the
trials run, at the end, on resume and for ``dashboard --sync``. It looks at what the store has before it adds to it:
a run bears the folder's key and a digest of what was logged, and counts as there if it also has ended. What does
not count is deleted and made anew. So nothing is there twice, wherever the last push was cut off.
"""

from __future__ import annotations

import csv
import math
import time
import uuid
from collections import defaultdict
from collections.abc import Callable, Mapping
from pathlib import Path
from typing import TYPE_CHECKING, Any

from origami_lab.config.node import FREE_TO_CHANGE, flatten
from origami_lab.config.seeds import format_seeds
from origami_lab.config.settings import Settings
from origami_lab.file_names import (
    BEST,
    CERTIFICATE,
    CONFIG,
    CURVE,
    FILM,
    FOLDED_PNG,
    PATTERN_PNG,
    PATTERN_SVG,
    RESULT,
    SUMMARY,
    TRIALS,
    VIEWER,
    error_file,
    trial_folder,
)
from origami_lab.runs.multirun_folder import membership
from origami_lab.runs.run_folder import RunFolder, read_note, read_summary, write_note
from origami_lab.runs.trial_row import STATUSES, STOPPED, VERDICTS, TrialRow, best_row, certificates, counts, spreads
from origami_lab.tracking.mlflow_log import BATCH, CONTENT, KEY, PARAMS, PARENT, _Logged, _logged, digest
from origami_lab.tracking.store import (
    RefusedError,
    StoreError,
    absolute_uri,
    experiment_id,
    explain,
    in_plain_words,
    open_client,
    probe,
    runs_with_tag,
)

if TYPE_CHECKING:
    from mlflow.entities import Metric

FOLDER_ARTIFACTS = (CONFIG, TRIALS, SUMMARY)
OF_THE_BEST = (PATTERN_PNG, FOLDED_PNG, FILM, VIEWER, PATTERN_SVG, CERTIFICATE)
"""Files of the best trial that the parent has too."""


class Runs:
    """A run folder and its runs in one store.

    Parameters
    ----------
    keep
        The store that the folder notes already stays noted: this one gets a copy.

    Raises
    ------
    StoreError
        If the store does not answer; RefusedError if the folder cannot be written.
    """

    def __init__(self, settings: Settings, folder: Path, uri: str, keep: bool = False) -> None:
        self.settings, self.folder, self.uri = settings, folder, uri
        self.multirun = membership(folder)
        """All jobs of a multirun go to one experiment, where their names and tags say what differs."""
        self.parent: _Logged | None = None
        self.children: defaultdict[int, list[_Logged]] = defaultdict(list)
        self.unsure = True
        """Whether the store may hold something else than noted here."""
        with in_plain_words(self.uri):
            probe(uri)
        note = read_note(folder)
        self.key = str(note.get("key") or uuid.uuid4().hex)
        known = note.get("uri") if keep and note.get("key") else None
        changed = {"key": self.key, "uri": known or absolute_uri(uri)}
        if changed != note:
            try:
                write_note(folder, changed)
            except OSError as error:  # the folder's trouble, not the store's
                raise RefusedError(f"{folder} cannot be written ({error.strerror or error})") from error
        with in_plain_words(self.uri):
            self.client = open_client(uri)
            name = settings.tracking.experiment or (self.multirun[0].experiment if self.multirun else settings.task)
            self.experiment = experiment_id(self.client, uri, str(name))

    def push(self, live: bool, pushed: Callable[[int], None] = lambda seed: None) -> int:
        """Add what the store does not have yet.

        Parameters
        ----------
        live
            The trials still run: the parent is left running, and stopped trials, which will run again, wait.
        pushed
            Called for each trial that was added.

        Returns
        -------
        How many trials were added, or −1 if there was nothing to do at all.

        Raises
        ------
        StoreError
            If the store does not answer; RefusedError, after all others were added, if a trial could not be added.
        """
        rows = RunFolder(self.folder).known_rows()
        added, failure = 0, None
        with in_plain_words(self.uri):
            if self.unsure:
                self._look()
            parent = self._take_up_parent(live)
        for seed, row in sorted(rows.items()):
            if live and row.outcome == STOPPED:
                continue
            try:
                with in_plain_words(self.uri):
                    if self._push_trial(parent, seed, row):
                        added += 1
                        pushed(seed)
            except StoreError:
                raise
            except Exception as error:  # this trial's own trouble is none of the others'
                self.unsure = True
                failure = RefusedError(f"seed {seed} could not be added: {explain(error, self.uri)}")
        if not live:
            with in_plain_words(self.uri):
                ended = self._end_parent(parent, rows)
            added = added or (0 if ended else -1)
        if failure is not None:
            raise failure
        return added

    # --- what is there ---

    def _look(self) -> None:
        """Find the parent and the children by seed; superfluous parents are deleted."""
        found = runs_with_tag(self.client, self.experiment, KEY, self.key)
        parents = [run for run in found if PARENT not in run.data.tags]
        children = [run for run in found if PARENT in run.data.tags]
        used = {run.data.tags[PARENT] for run in children}
        # the answer to a request may be lost, and then there are two
        parents.sort(key=lambda run: (run.info.run_id not in used, run.info.start_time))
        for superfluous in parents[1:]:
            self.client.delete_run(superfluous.info.run_id)
        self.parent = _logged(parents[0]) if parents else None
        self.children.clear()
        for run in children:
            self.children[int(run.data.tags["seed"])].append(_logged(run))
        self.unsure = False

    # --- what is added ---

    def _take_up_parent(self, live: bool) -> str:
        if self.parent is None:
            name = self.multirun[1].name if self.multirun else f"{self.settings.task} {self.settings.method}"
            began = (self.folder / CONFIG).stat().st_mtime
            self.parent = _Logged(self._create(name, {}, {}, began), None)
        elif live and self.parent.content is not None:
            self.client.update_run(self.parent.run, status="RUNNING")
            self.parent = _Logged(self.parent.run, None)
        return self.parent.run

    def _push_trial(self, parent: str, seed: int, row: TrialRow) -> bool:
        """Log one trial as a child run, unless it is there; whether it was not."""
        from mlflow.entities import RunTag

        content = digest(row.values())
        there = [logged for logged in self.children[seed] if logged.content == content]
        for logged in self.children[seed]:
            if logged not in there[:1]:
                self.client.delete_run(logged.run)
        self.children[seed] = there[:1]
        if there:
            return False
        path = trial_folder(self.folder, seed)
        failed = row.has_failed
        error = error_file(self.folder, seed)
        source = path / RESULT if not failed else error
        ended = (source if source.is_file() else self.folder / TRIALS).stat().st_mtime
        tags = {PARENT: parent, "seed": str(seed), CONTENT: content}
        name = f"seed {seed} · {self.multirun[1].name}" if self.multirun else f"seed {seed}"
        run = self._create(name, tags, {"seed": seed}, ended - (row.seconds or 0.0))
        metrics = self._metrics({name: value for name, value in row.values().items() if name != "seed"}, ended)
        if path.is_dir() and not failed:
            metrics += self._curve(path / CURVE, ended)
        tag = [RunTag("status", row.status)]
        if row.certificate:
            tag.append(RunTag("certificate", row.certificate))
        for first in range(0, max(len(metrics), 1), BATCH):
            self.client.log_batch(run, metrics=metrics[first : first + BATCH], tags=tag)
        if path.is_dir() and not failed:
            self.client.log_artifacts(run, str(path))
            # the viewer shows JSON, not .fold
            self.client.log_text(run, (path / BEST).read_text(encoding="utf-8"), f"{BEST}.json")
        elif error.is_file():
            self.client.log_artifact(run, str(error))
        ending = "FAILED" if failed else "KILLED" if row.outcome == STOPPED else "FINISHED"
        self.client.set_terminated(run, ending, int(ended * 1000))
        self.children[seed] = [_Logged(run, content)]
        return True

    def _end_parent(self, run: str, rows: Mapping[int, TrialRow]) -> bool:
        """Log the experiment's figures, table and best pictures on the parent and end it; whether that was to do."""
        summary = read_summary(self.folder)
        whole = all(seed in rows and rows[seed].outcome != STOPPED for seed in self.settings.seeds)
        content = digest({"rows": {seed: row.values() for seed, row in rows.items()}, "summary": summary})
        if self.parent == _Logged(run, content):
            return False
        self._log_figures(run, rows, summary)
        for name in FOLDER_ARTIFACTS:
            if (self.folder / name).is_file():
                self.client.log_artifact(run, str(self.folder / name))
        best = best_row(rows.values())
        if best is not None:
            for name in OF_THE_BEST:
                if (file := trial_folder(self.folder, best.seed) / name).is_file():
                    self.client.log_artifact(run, str(file), "best")
        files = [self.folder / name for name in FOLDER_ARTIFACTS]
        ended = max(file.stat().st_mtime for file in files if file.is_file())
        self.client.set_tag(run, CONTENT, content)
        self.client.set_terminated(run, "FINISHED" if whole else "KILLED", int(ended * 1000))
        self.parent = _Logged(run, content)
        return True

    def _log_figures(self, run: str, rows: Mapping[int, TrialRow], summary: Mapping[str, Any]) -> None:
        """From the rows, because a run that was killed has no summary, or an old one."""
        from mlflow.entities import RunTag

        ended = counts(rows.values())
        figures: dict[str, Any] = {}
        for name, spread in spreads(rows.values()).items():  # the first one is what MLflow's comparison plots
            figures |= {f"{name}_mean": spread.mean, f"{name}_std": spread.std}
        figures["interactions"] = sum(row.interactions or 0 for row in rows.values())
        figures["seconds"] = summary.get("seconds")
        # all of them, so that none is left from before a resume
        for name in STATUSES:
            figures[f"trials_{name.replace(' ', '_')}"] = ended.get(name, 0)
        if found := certificates(rows.values()):
            figures |= {f"designs_{verdict.replace(' ', '_')}": len(found.get(verdict, [])) for verdict in VERDICTS}
        best = best_row(rows.values())
        if best is not None:
            figures |= {"best_return": best.return_, "best_seed": best.seed}
        tags = {"seeds": str(format_seeds(self.settings.seeds)), "command": str(summary.get("command", ""))}
        if best is not None and best.certificate:
            tags["certificate"] = best.certificate
        self.client.log_batch(
            run, metrics=self._metrics(figures, time.time()), tags=[RunTag(*item) for item in tags.items()]
        )

    # --- pieces ---

    def _create(self, name: str, tags: Mapping[str, str], own: Mapping[str, Any], began: float) -> str:
        """A new run with the configuration and its ``own`` values as parameters, which cannot change any more."""
        from mlflow.entities import Param

        settings = self.settings
        tags = {
            KEY: self.key,
            "task": settings.task,
            "search": settings.method,
            "folder": str(self.folder.absolute()),
            "seeds": str(format_seeds(settings.seeds)),
            "mlflow.source.name": "origami-lab",
            **self._multirun_tags(),
            **tags,
        }
        start = int(began * 1000)
        run = str(self.client.create_run(self.experiment, start, tags, name).info.run_id)
        fixed = {key: value for key, value in settings.config.items() if key not in FREE_TO_CHANGE}
        flat = flatten({**fixed, **own})
        params = [Param(key, str(value)) for key, value in flat.items()]
        for first in range(0, len(params), PARAMS):
            self.client.log_batch(run, params=params[first : first + PARAMS])
        return run

    def _multirun_tags(self) -> dict[str, str]:
        """What finds the runs of a multirun, and tells its jobs apart."""
        if self.multirun is None:
            return {}
        index, job = self.multirun
        return {"multirun": index.id, "job": str(index.jobs.index(job)), "differs": job.differs}

    def _metrics(self, values: Mapping[str, Any], when: float) -> list[Metric]:
        from mlflow.entities import Metric

        numbers = {k: v for k, v in values.items() if isinstance(v, int | float) and math.isfinite(v)}
        return [Metric(name, float(value), int(when * 1000), 0) for name, value in numbers.items()]

    def _curve(self, path: Path, when: float) -> list[Metric]:
        """The best return so far, with interactions as steps."""
        from mlflow.entities import Metric

        with path.open(newline="", encoding="utf-8") as file:
            return [
                Metric("best_return", float(row["return"]), int(when * 1000), int(row["interactions"]))
                for row in csv.DictReader(file)
            ]
