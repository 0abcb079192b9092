"""Runs of one folder in one MLflow store: a root, and numbered runs nested in it.

:meth:`MlflowLog.push` brings a store up to date with the folder, and is the only thing that writes to one: while the
trials run, at the end, on resume and for ``dashboard --sync``. It looks at the store before it adds to it: a run bears
the folder's key and a digest of its content, and counts as there if it also has ended. One that does not count is
deleted and made anew. So nothing is there twice, wherever the last push was cut off.
"""

from __future__ import annotations

import hashlib
import json
import math
from abc import ABC, abstractmethod
from collections import defaultdict
from collections.abc import Callable, Collection, Mapping, Sequence
from contextlib import AbstractContextManager
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any

from origami_lab.runs.locks import held
from origami_lab.tracking.descriptions import BEGINS
from origami_lab.tracking.mlflow_limits import LONGEST_NAME, LONGEST_PARAMETER, LONGEST_TAG, fitting
from origami_lab.tracking.shown_view import NOTE, TAG
from origami_lab.tracking.store import (
    RefusedError,
    StoreError,
    experiment_id,
    explain,
    in_plain_words,
    open_client,
    probe,
    runs_with_tag,
)

if TYPE_CHECKING:
    from mlflow.entities import Metric, Run

BATCH = 900
"""Metrics a call: MLflow's limit is 1000 items."""
PARAMS = 100
"""Parameters a call: MLflow's limit."""
KEY, CONTENT, PARENT = "run_key", "content", "mlflow.parentRunId"
"""Tags: the key of the folder that a run belongs to, a digest of its content, and MLflow's own for a nested run."""


@dataclass(frozen=True)
class Logged:
    """A run in the store."""

    run: str
    content: str | None
    """The digest of its content; None while the run has not ended."""


def digest(content: Mapping[Any, Any]) -> str:
    """A short name for a content: another content has another one."""
    return hashlib.sha256(json.dumps(content, sort_keys=True).encode()).hexdigest()[:16]


class MlflowLog(ABC):
    """A folder and its runs in one store.

    Parameters
    ----------
    keep
        The store that the folder notes already stays noted: this one gets a copy.

    Raises
    ------
    StoreError
        If the store does not answer; RefusedError if it, or the folder, does not take what must be written.
    """

    number_tag: str
    """The tag with the number of a run nested in the root."""
    source: str
    """The command that made the runs, for MLflow."""
    shared = False
    """Whether other machines push to the same runs."""

    def __init__(self, folder: Path, uri: str, keep: bool = False) -> None:
        self.folder, self.uri = folder, uri
        self.root: Logged | None = None
        self.nested: defaultdict[int, list[Logged]] = defaultdict(list)
        """The runs in the root by their number: one each, unless a push was cut off."""
        self.below: defaultdict[str, list[str]] = defaultdict(list)
        """The ids of the runs nested in a run."""
        self.unsure = True
        """Whether the store may hold something else than noted here."""
        with in_plain_words(uri):
            probe(uri)
        self.key = self._take_up_key(keep)
        with in_plain_words(uri):
            self.client = open_client(uri)
            self.experiment = experiment_id(self.client, uri, self._experiment_name())

    # --- the folder, as a kind of log knows it ---

    @staticmethod
    @abstractmethod
    def store_of(folder: Path) -> str | None:
        """The URI of the store that a folder names, if it does; raises InputError if it cannot be read."""

    @staticmethod
    def alone(folder: Path) -> AbstractContextManager[bool]:
        """Keep other pushes out of a folder that nobody writes to; whether it could be had."""
        return held(folder, wait=False)

    @abstractmethod
    def _take_up_key(self, keep: bool) -> str:
        """The key that all runs of the folder bear."""

    @abstractmethod
    def _experiment_name(self) -> str: ...

    @abstractmethod
    def _entries(self, live: bool, numbers: Collection[int] | None) -> Mapping[int, Any]:
        """The trials to be in the store, by number: of these numbers only, if they are given."""

    @abstractmethod
    def _root_params(self) -> Mapping[str, str]:
        """The parameters of the root's run."""

    @abstractmethod
    def _take_up_root(self, live: bool) -> str:
        """The id of the root's run, which is made if it is not there."""

    @abstractmethod
    def _push_entry(self, root: str, number: int, entry: Any) -> bool:
        """Log one trial as a nested run, unless it is there; whether it was not."""

    @abstractmethod
    def _end_root(self, root: str, entries: Mapping[int, Any]) -> bool:
        """Log figures and files of all on the root's run and end it; whether that was to do."""

    # --- pushing ---

    def push(
        self,
        live: bool,
        numbers: Collection[int] | None = None,
        pushed: Callable[[int], None] = lambda number: None,
    ) -> int:
        """Add the trials that the store does not have yet.

        Parameters
        ----------
        live
            More trials run: the root is left running.
        numbers
            The trials that ended since the last push, while they run: the others are not read again. None for all,
            which are also looked at if the last push failed, and in the end.
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
        entries = self._entries(live, numbers if live and not self.unsure else None)
        with in_plain_words(self.uri):
            if self.unsure or (self.shared and not live):
                self._look()
            self.unsure = True  # until all went well
            root = self._take_up_root(live)
        added, failure = 0, None
        for number, entry in sorted(entries.items()):
            try:
                with in_plain_words(self.uri):
                    if self._push_entry(root, number, entry):
                        added += 1
                        pushed(number)
            except StoreError:
                raise
            except Exception as error:  # this trial's own trouble is none of the others'
                failure = RefusedError(f"{self.number_tag} {number} could not be added: {explain(error, self.uri)}")
        if not live:
            with in_plain_words(self.uri):
                ended = self._end_root(root, entries)
            added = added or (0 if ended else -1)
        if failure is not None:
            raise failure
        self.unsure = False
        return added

    def _look(self) -> None:
        """Find the root and the runs nested in it; superfluous roots are deleted."""
        found = runs_with_tag(self.client, self.experiment, KEY, self.key)
        self.nested.clear()
        self.below.clear()
        for run in found:
            if PARENT in run.data.tags:
                self.below[run.data.tags[PARENT]].append(str(run.info.run_id))
                if self.number_tag in run.data.tags:
                    self._note_nested(run)
        roots = [run for run in found if PARENT not in run.data.tags]
        # the answer to a request may be lost, or two machines begin at once, and then there are two
        roots.sort(key=lambda run: (run.info.run_id not in self.below, run.info.start_time, run.info.run_id))
        for superfluous in roots[1:]:
            if superfluous.info.run_id not in self.below:
                self.client.delete_run(superfluous.info.run_id)
        self.root = _logged(roots[0]) if roots else None
        if roots:  # it is never made anew, as a nested run is
            known = roots[0].data.params
            missing = {key: value for key, value in self._root_params().items() if key not in known}
            self._log_params(str(roots[0].info.run_id), missing)

    def _note_nested(self, run: Run) -> None:
        self.nested[int(run.data.tags[self.number_tag])].append(_logged(run))

    def _is_there(self, number: int, content: str) -> bool:
        """Whether a trial's run is in the store, and has ended; others of the same number are deleted."""
        there = [logged for logged in self.nested[number] if logged.content == content][:1]
        for logged in self.nested[number]:
            if logged not in there:
                for run in (*self.below.pop(logged.run, ()), logged.run):
                    self.client.delete_run(run)
        self.nested[number] = there
        return bool(there)

    # --- pieces of a run ---

    def _show_as(self, view: str, note: str) -> None:
        """Have MLflow's pages show the experiment in a view of ours; a description of a person's stays."""
        tags = self.client.get_experiment(self.experiment).tags
        if tags.get(TAG) != view:
            self.client.set_experiment_tag(self.experiment, TAG, view)
        if tags.get(NOTE, BEGINS).startswith(BEGINS) and tags.get(NOTE) != note:
            self.client.set_experiment_tag(self.experiment, NOTE, note)

    def _create(self, name: str, tags: Mapping[str, str], params: Mapping[str, str], began: float) -> str:
        """A new run's id. Its parameters cannot change any more."""
        tags = {KEY: self.key, "mlflow.source.name": self.source, **tags}
        tags = {key: fitting(value, LONGEST_TAG) for key, value in tags.items()}
        name = fitting(name, LONGEST_NAME)
        run = str(self.client.create_run(self.experiment, int(began * 1000), tags, name).info.run_id)
        if PARENT in tags:
            self.below[tags[PARENT]].append(run)
        self._log_params(run, params)
        return run

    def _log_params(self, run: str, params: Mapping[str, str]) -> None:
        from mlflow.entities import Param

        items = [Param(key, fitting(value, LONGEST_PARAMETER)) for key, value in params.items()]
        for first in range(0, len(items), PARAMS):
            self.client.log_batch(run, params=items[first : first + PARAMS])

    def _log(self, run: str, metrics: Sequence[Metric], tags: Mapping[str, str]) -> None:
        """Log metrics, and tags, in batches."""
        from mlflow.entities import RunTag

        items = [RunTag(key, fitting(value, LONGEST_TAG)) for key, value in tags.items()]
        for first in range(0, max(len(metrics), 1), BATCH):
            self.client.log_batch(run, metrics=metrics[first : first + BATCH], tags=items)

    def _end(self, run: str, status: str, when: float) -> None:
        self.client.set_terminated(run, status, int(when * 1000))


def metrics_of(values: Mapping[str, Any], when: float, step: int = 0) -> list[Metric]:
    """MLflow's metrics of those values that are finite numbers.

    Parameters
    ----------
    when
        Seconds since 1970.
    """
    from mlflow.entities import Metric

    numbers = {k: v for k, v in values.items() if isinstance(v, int | float) and math.isfinite(v)}
    return [Metric(name, float(value), int(when * 1000), step) for name, value in numbers.items()]


def _logged(run: Run) -> Logged:
    return Logged(str(run.info.run_id), None if run.info.status == "RUNNING" else run.data.tags.get(CONTENT))
