"""Tracking: one MLflow run for the experiment, one below it for each seed.

Everything is read from the run folder, where results are complete before the tracker hears of them, and
nothing here can hurt them: MLflow works in a thread of its own, and whatever goes wrong there is one warning.
What was tracked is noted in ``tracking.json``, so that a resumed run adds what is missing.
"""

from __future__ import annotations

import csv
import json
import logging
import math
import os
import queue
import threading
import time
from collections.abc import Callable, Mapping
from pathlib import Path
from typing import TYPE_CHECKING, Any, Protocol

from origami_lab.experiment.folder import RESULTS, RunFolder, flatten, write_atomically
from origami_lab.experiment.seeds import format_seeds
from origami_lab.experiment.settings import Settings
from origami_lab.reporting.tables import FAILED, STOPPED, Row, spent_budget

if TYPE_CHECKING:
    from mlflow import MlflowClient

DEFAULT_STORE = RESULTS / "mlflow.db"
PATIENCE_SECONDS = 60.0
"""How long the end of an experiment waits for a slow tracking server."""
BATCH = 1000
"""Metrics a call: MLflow's limit."""
FOLDER_ARTIFACTS = ("config.yaml", "trials.csv", "summary.json")
PICTURES = ("pattern.png", "folded.png", "motion.gif")

Say = Callable[[str], None]


class Tracker(Protocol):
    """Hears of results that are complete on disk. Never raises, never blocks for long."""

    def trial(self, row: Row) -> None:
        """A trial ended; its folder, if it has one, is complete."""
        ...

    def finish(self, summary: Mapping[str, Any], *, patience: float = PATIENCE_SECONDS) -> None:
        """The experiment ended; all its files are complete. Waits ``patience`` seconds at most, or until Ctrl-C."""
        ...


class NullTracker:
    """Tracks nothing."""

    def trial(self, row: Row) -> None: ...
    def finish(self, summary: Mapping[str, Any], *, patience: float = PATIENCE_SECONDS) -> None: ...


def make_tracker(settings: Settings, folder: Path, say: Say) -> Tracker:
    """The tracker that the configuration asks for."""
    if settings.tracking["kind"] == "none":
        return NullTracker()
    return MlflowTracker(settings, folder, say)


def default_uri() -> str:
    """The store of the working directory."""
    return f"sqlite:///{DEFAULT_STORE.absolute()}"


class MlflowTracker:
    """Writes to an MLflow store from a thread of its own, so that no server can hold up a trial."""

    def __init__(self, settings: Settings, folder: Path, say: Say) -> None:
        self._say = say
        self._jobs: queue.SimpleQueue[Callable[[_Runs], None] | None] = queue.SimpleQueue()
        self._thread = threading.Thread(target=self._work, args=(settings, folder), daemon=True, name="tracking")
        self._warned = False
        self._thread.start()

    def trial(self, row: Row) -> None:
        self._jobs.put(lambda runs: runs.log_trial(row))

    def finish(self, summary: Mapping[str, Any], *, patience: float = PATIENCE_SECONDS) -> None:
        self._jobs.put(lambda runs: runs.log_summary(summary))
        self._jobs.put(None)
        deadline = time.monotonic() + patience
        try:
            self._thread.join(min(patience, 3.0))
            if self._thread.is_alive():
                self._say("writing to MLflow ...")
                self._thread.join(max(deadline - time.monotonic(), 0.0))
        except KeyboardInterrupt:
            pass
        if self._thread.is_alive():
            self._warn("MLflow did not answer in time")

    def _work(self, settings: Settings, folder: Path) -> None:
        """Open the store, then do what is asked in order; a step that fails does not stop the next."""
        runs: _Runs | None = None
        try:
            runs = _Runs(settings, folder)
        except Exception as error:
            self._warn(_reason(error))
        while (job := self._jobs.get()) is not None:
            if runs is None:
                continue
            try:
                job(runs)
            except Exception as error:
                self._warn(_reason(error))

    def _warn(self, reason: str) -> None:
        if not self._warned:
            self._warned = True
            self._say(f"warning: tracking: {reason}; the results on disk are complete")


def _reason(error: Exception) -> str:
    lines = [line for line in str(error).splitlines() if line.strip()]
    return f"{type(error).__name__}: {lines[0] if lines else ''}"[:300]


class _Runs:
    """The MLflow runs of one experiment: the parent, and a child for each seed."""

    def __init__(self, settings: Settings, folder: Path) -> None:
        self.settings, self.folder = settings, folder
        uri = settings.tracking.get("uri") or default_uri()
        self.client = open_client(uri)
        self.known = _read_json(folder / "tracking.json")
        if self.known.get("uri") != uri:
            self.known = {"uri": uri, "parent": None, "trials": {}}
        self.experiment = self._experiment(str(settings.tracking.get("experiment") or settings.task), uri)
        if self.known["parent"] is None:
            self.known["parent"] = self._create(f"{settings.task} {settings.method}", {}, settings.config)
            self._remember()
        else:
            self.client.update_run(self.known["parent"], status="RUNNING")
            self.client.set_tag(self.known["parent"], "seeds", str(format_seeds(settings.seeds)))
        for _, row in sorted(RunFolder(folder).rows().items()):  # what an interrupted run could not log
            if spent_budget(row):
                self.log_trial(row)

    def log_trial(self, row: Row) -> None:
        """Log one trial as a child run, once."""
        seed = str(row["seed"])
        if seed in self.known["trials"]:
            return
        parent = {"mlflow.parentRunId": self.known["parent"]}
        run = self._create(f"seed {seed}", parent, {**self.settings.config, "seed": row["seed"]})
        path = self.folder / f"seed={seed}"
        status = str(row["status"])
        self.client.set_tag(run, "status", status)
        self._metrics(run, {name: value for name, value in row.items() if name != "seed"})
        if path.is_dir() and not status.startswith(FAILED):
            self._curve(run, path / "curve.csv")
            self.client.log_artifacts(run, str(path))
            # the viewer shows JSON, not .fold
            self.client.log_text(run, (path / "best.fold").read_text(encoding="utf-8"), "best.fold.json")
        elif (error := self.folder / f"seed={seed}.error.txt").is_file():
            self.client.log_artifact(run, str(error))
        ended = "FAILED" if status.startswith(FAILED) else "KILLED" if status == STOPPED else "FINISHED"
        self.client.set_terminated(run, ended)
        if ended == "FINISHED":  # the others run again when the run is resumed
            self.known["trials"][seed] = run
            self._remember()

    def log_summary(self, summary: Mapping[str, Any]) -> None:
        """Log the experiment's figures, table and best pictures on the parent, and end it."""
        run = self.known["parent"]
        figures: dict[str, Any] = {name: summary[name] for name in ("interactions", "seconds")}
        for name, spread in summary["returns"].items():
            figures |= {f"{name}_mean": spread["mean"], f"{name}_std": spread["std"]}
        figures |= {f"trials_{name.replace(' ', '_')}": n for name, n in summary["trials"].items()}
        best = summary["best"]
        if best is not None:
            figures |= {"best_return": best["return"], "best_seed": best["seed"]}
        self._metrics(run, figures)
        for name in FOLDER_ARTIFACTS:
            self.client.log_artifact(run, str(self.folder / name))
        if best is not None:
            for name in PICTURES:
                if (file := self.folder / f"seed={best['seed']}" / name).is_file():
                    self.client.log_artifact(run, str(file), "best")
        self.client.set_tag(run, "command", summary["command"])
        self.client.set_terminated(run, "KILLED" if summary["interrupted"] else "FINISHED")

    # --- pieces ---

    def _experiment(self, name: str, uri: str) -> str:
        found = self.client.get_experiment_by_name(name)
        if found is not None:
            return str(found.experiment_id)
        location = None
        if uri.startswith("sqlite:///"):  # beside the database, wherever the command runs
            database = Path(uri.removeprefix("sqlite:///"))
            location = (database.absolute().parent / "mlartifacts" / name).as_uri()
        try:
            tags = {"mlflow.experimentKind": "custom_model_development"}  # the dashboard opens on the runs
            return str(self.client.create_experiment(name, artifact_location=location, tags=tags))
        except Exception:  # another run made it in the meantime
            found = self.client.get_experiment_by_name(name)
            if found is None:
                raise
            return str(found.experiment_id)

    def _create(self, name: str, tags: Mapping[str, str], config: Mapping[str, Any]) -> str:
        from mlflow.entities import Param

        settings = self.settings
        tags = {
            "task": settings.task,
            "search": settings.method,
            "folder": str(self.folder.absolute()),
            "seeds": str(format_seeds(settings.seeds)),
            "mlflow.source.name": "origami-lab",
            **tags,
        }
        run = str(self.client.create_run(self.experiment, run_name=name, tags=tags).info.run_id)
        hidden = ("output", "resume", "verbosity", "tracking")
        params = flatten({key: value for key, value in config.items() if key not in hidden})
        self.client.log_batch(run, params=[Param(key, str(value)) for key, value in params.items()])
        return run

    def _metrics(self, run: str, values: Mapping[str, Any]) -> None:
        from mlflow.entities import Metric

        now = int(time.time() * 1000)
        numbers = {k: v for k, v in values.items() if isinstance(v, int | float) and math.isfinite(v)}
        self.client.log_batch(run, metrics=[Metric(name, float(v), now, 0) for name, v in numbers.items()])

    def _curve(self, run: str, path: Path) -> None:
        """The best return so far, with interactions as steps."""
        from mlflow.entities import Metric

        now = int(time.time() * 1000)
        with path.open(newline="", encoding="utf-8") as file:
            points = [
                Metric("best_return", float(row["return"]), now, int(row["interactions"]))
                for row in csv.DictReader(file)
            ]
        for first in range(0, len(points), BATCH):
            self.client.log_batch(run, metrics=points[first : first + BATCH])

    def _remember(self) -> None:
        write_atomically(self.folder / "tracking.json", json.dumps(self.known, indent=1) + "\n")


def _read_json(path: Path) -> dict[str, Any]:
    try:
        content = json.loads(path.read_text(encoding="utf-8"))
        return content if isinstance(content, dict) else {}
    except (OSError, ValueError):
        return {}


def open_client(uri: str) -> MlflowClient:
    """Connect to a store; a fresh SQLite one is made first, as a whole."""
    os.environ.setdefault("MLFLOW_DISABLE_TELEMETRY", "true")
    # a dead server should be noticed in seconds, not after MLflow's default of minutes
    os.environ.setdefault("MLFLOW_HTTP_REQUEST_MAX_RETRIES", "2")
    os.environ.setdefault("MLFLOW_HTTP_REQUEST_TIMEOUT", "20")
    for name in ("alembic", "mlflow.store.db.utils", "mlflow.utils.environment"):
        logging.getLogger(name).setLevel(logging.WARNING)
    from mlflow import MlflowClient

    if uri.startswith("sqlite:///"):
        create_database(Path(uri.removeprefix("sqlite:///")))
    return MlflowClient(tracking_uri=uri)


def create_database(path: Path) -> None:
    """Create an MLflow SQLite store, unless there is one.

    The tables are made in a temporary file that is linked into place, because MLflow's own first use is not
    safe when several processes do it at once: they run the migrations against each other.
    """
    if path.exists():
        return
    from mlflow.store.tracking.sqlalchemy_store import SqlAlchemyStore

    path = path.absolute()
    path.parent.mkdir(parents=True, exist_ok=True)
    temporary = path.with_name(f".{path.name}.{os.getpid()}.tmp")
    try:
        store = SqlAlchemyStore(f"sqlite:///{temporary}", (path.parent / "mlartifacts").as_uri())
        store.engine.dispose()
        try:
            os.link(temporary, path)
        except FileExistsError:  # another process was quicker
            pass
        except OSError:  # a file system without hard links
            if not path.exists():
                temporary.replace(path)
    finally:
        temporary.unlink(missing_ok=True)
