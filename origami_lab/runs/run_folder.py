"""The run folder: what an experiment leaves on disk, and how it stays whole whenever the run is killed.

::

    config.yaml            the whole configuration; runs again with `origami-lab DIR/config.yaml`
    target.ply             the target's surface
    start.json             the moves of a start pattern that came from a file
    trials.csv             one row a finished trial
    summary.json           mean ± std, the best seed, versions, the command
    seed=N/                one finished trial, renamed into place as a whole
    seed=N.error.txt       the traceback of a trial that failed
    index.html             the page of the run; what it shows is in index.data
    seed=N.checkpoint      a search that is not finished, if its searcher saves itself

Everything visible is whole: written under a hidden name first, of which a resumed run clears what a killed one left.
"""

from __future__ import annotations

import errno
import json
import os
import re
import shlex
import tempfile
from collections.abc import Collection, Iterable, Iterator, Mapping
from contextlib import contextmanager, suppress
from datetime import datetime
from pathlib import Path
from typing import Any

from origami_lab.addresses import hidden, keep
from origami_lab.config.config_file import config_text, read_config_file
from origami_lab.config.earlier_versions import as_of_today, with_public_targets
from origami_lab.config.node import FREE_TO_CHANGE, OF_STAGES, Node, check_format, flatten
from origami_lab.config.settings import Settings
from origami_lab.errors import InputError
from origami_lab.file_names import (
    CONFIG,
    FOLDER_FORMAT,
    RESULT,
    SEED,
    START,
    SUMMARY,
    TARGET,
    TRACKING,
    TRIALS,
    error_file,
    trial_folder,
)
from origami_lab.files import on_disk, read_json, remove_files, remove_folder, require_no_link, write_whole
from origami_lab.runs.checkpoint import remove_checkpoints
from origami_lab.runs.kept_files import keep_others
from origami_lab.runs.locks import RUNNING, locked
from origami_lab.runs.target_file import HasTriangles, ply_bytes
from origami_lab.runs.trial_row import TrialRow, format_trials, read_trials

RESULTS = Path("results")
SPARE_BYTES = 2**20
"""Free bytes that rule out a full disk as the cause of a file that failed."""

_LEFTOVER = re.compile(
    r"\.((config\.yaml|index\.html|target\.ply|start\.json|trials\.csv|(summary|tracking)\.json|seed=\d+\.(error\.txt|checkpoint))\.\d+|seed=\d+\.(\d+|old))\.tmp"
)
"""Names of what is being written, or was when the run was killed."""


NO_ROOM = ("the disk is full", "the disk quota is used up")
_TROUBLES = {
    errno.ENOSPC: NO_ROOM[0],
    errno.EDQUOT: NO_ROOM[1],
    errno.EFBIG: "a file would be larger than allowed",
    errno.EROFS: "the file system is read-only",
    errno.ENOENT: "the folder is gone",
    errno.ENOTDIR: "the folder is gone",
}


class FolderError(Exception):
    """The run folder cannot be written any more; the message says why, in a few words."""

    def __init__(self, cause: OSError | str) -> None:
        self.why = cause if isinstance(cause, str) else _TROUBLES.get(cause.errno or 0, cause.strerror or str(cause))
        super().__init__(self.why)


class RunFolder:
    """The folder of one experiment."""

    def __init__(self, path: Path) -> None:
        self.path = path

    @classmethod
    @contextmanager
    def opened(cls, settings: Settings, now: datetime | None = None) -> Iterator[RunFolder]:
        """The folder of a new run or of one that is resumed, for this process alone.

        With ``resume``, a folder in which nothing has begun yet is a new run's: a batch system gives the same command
        again, whenever the first one was killed.

        Raises
        ------
        InputError
            If ``output`` holds something already and ``resume`` is false, if it is not the folder of a run or of one
            that was made with other settings, if it cannot be written, or if another process writes to it.
        """
        folder = cls._find(settings, now or datetime.now())
        with locked(folder.path):
            folder.clear_leftovers()
            try:
                yield folder
            finally:
                folder.clear_leftovers()

    @classmethod
    def _find(cls, settings: Settings, now: datetime) -> RunFolder:
        output = settings.output
        if settings.resume and output is None:
            runs = sorted((RESULTS / settings.task / settings.method).glob("*/config.yaml"))
            hint = f", e.g. output={runs[-1].parent}" if runs else ""
            raise InputError("resume", "true", f"must come with the folder to finish, output=DIR{hint}")
        try:
            folder = cls(fresh_folder(RESULTS / settings.task / settings.method, now) if output is None else output)
            if settings.resume and folder.has_begun:
                folder._check_same(settings)
            elif folder.path.exists() and not folder._is_empty():
                expected = "must be a new or empty folder; resume=true finishes the run in it"
                if settings.resume:
                    expected = "must be the folder of a run, there is no config.yaml in it"
                raise InputError("output", folder.path, expected)
            folder.path.mkdir(parents=True, exist_ok=True)
            tempfile.TemporaryFile(dir=folder.path).close()
            return folder
        except OSError as error:
            where = output or RESULTS
            reason = error.strerror or str(error)
            raise InputError("output", where, f"must be a folder that can be written ({reason})") from error

    def _is_empty(self) -> bool:
        return all(file.name == RUNNING or _LEFTOVER.fullmatch(file.name) for file in self.path.iterdir())

    def _check_same(self, settings: Settings) -> None:
        differing = _differences(self.config(), as_of_today(settings.config))
        if differing:
            raise InputError(
                "output",
                self.path,
                "cannot be resumed with other settings than it was started with: " + "; ".join(differing),
            )

    def clear_leftovers(self) -> None:
        """Remove what killed processes left, checkpoints of finished trials, too. A stopped trial comes back."""
        with suppress(OSError):
            remove_checkpoints(self.path, lambda seed: any(row.spent_budget for row in self.rows([seed]).values()))
            for leftover in [file for file in self.path.iterdir() if _LEFTOVER.fullmatch(file.name)]:
                final = self.path / leftover.name.removeprefix(".").removesuffix(".old.tmp")
                with suppress(OSError):
                    if leftover.name.endswith(".old.tmp") and not final.exists():
                        leftover.replace(final)
                    elif leftover.is_dir() and not leftover.is_symlink():
                        remove_folder(leftover)
                    else:
                        leftover.unlink()

    # --- what is on disk ---

    @property
    def has_begun(self) -> bool:
        """Whether a run was started in it: its configuration is the first thing written."""
        return (self.path / CONFIG).is_file()

    def config(self) -> dict[str, Any]:
        """The configuration the run was started with; raises InputError if it cannot be read."""
        try:
            config = read_config_file("output", self.path / CONFIG)
        except InputError as error:
            raise InputError("output", self.path, "must hold a run's config.yaml, this one cannot be read") from error
        check_format(config)
        return as_of_today(config)

    def trial(self, seed: int) -> Path:
        return trial_folder(self.path, seed)

    def rows(self, seeds: Iterable[int] | None = None) -> dict[int, TrialRow]:
        """The rows of the trials on disk, by seed; a folder without a readable result counts as missing.

        Parameters
        ----------
        seeds
            The trials to read; None for all.
        """
        found = {}
        every = self.path.glob(f"{SEED}*/{RESULT}")
        for file in every if seeds is None else [self.trial(seed) / RESULT for seed in seeds]:
            with suppress(OSError, ValueError, AttributeError):
                row = TrialRow.from_values(read_json(file))
                found[row.seed] = row
        return found

    def damaged_seeds(self) -> list[int]:
        """The seeds of trials that have a folder, and in it no result that can be read."""
        names = [path.name.removeprefix(SEED) for path in self.path.glob(f"{SEED}*") if path.is_dir()]
        return sorted({int(name) for name in names if name.isdigit()} - self.rows().keys())

    def known_rows(self, seeds: Collection[int] | None = None) -> dict[int, TrialRow]:
        """The rows that are known, by seed: of trials on disk, and of those that the table says have failed since.

        Parameters
        ----------
        seeds
            The trials to read; None for all. The table is not read if all of them ran to their end.
        """
        found = self.rows(seeds)
        if seeds is not None and all(seed in found and found[seed].spent_budget for seed in seeds):
            return dict(sorted(found.items()))
        with suppress(OSError, ValueError, KeyError):
            for row in read_trials(self.path / TRIALS):
                asked = seeds is None or row.seed in seeds
                if asked and row.has_failed and not (row.seed in found and found[row.seed].spent_budget):
                    found[row.seed] = row
        return dict(sorted(found.items()))

    # --- writing ---

    def begin(self, config: Node, target: HasTriangles | None, start: Node | None) -> None:
        """Write what a run begins with: its configuration, its target, and its start pattern if moves make it.

        Raises
        ------
        InputError
            If the run in the folder began with another target or start pattern.
        FolderError
            If the folder cannot be written.
        """
        files: dict[str, bytes] = {}
        if target is not None:
            files[TARGET] = ply_bytes(target.vertices, target.faces)
        if start is not None:
            files[START] = (json.dumps(start, indent=1) + "\n").encode()
        try:
            for name, content in files.items():
                self._check_kept(name, content)
            again = f"runs again with: origami-lab {shlex.quote(str(self.path / CONFIG))}"
            text = config_text([again], {**config, "folder_format": FOLDER_FORMAT})
            write_whole(self.path / CONFIG, text, sync=True)  # first: it makes the folder a run's
            for name, content in files.items():
                write_whole(self.path / name, content, sync=True)
        except OSError as error:
            raise FolderError(error) from error

    def check_target(self, target: HasTriangles) -> None:
        """Raise InputError if the target is not the one that the run was started with."""
        self._check_kept(TARGET, ply_bytes(target.vertices, target.faces))

    def _check_kept(self, name: str, content: bytes) -> None:
        """Raise InputError if a file of the run's beginning, when it is there, means something else."""
        file = self.path / name
        what, meaning = ("target", bytes) if name == TARGET else ("start pattern", _start_in)
        if file.is_file() and meaning(file.read_bytes()) != meaning(content):
            field = what.partition(" ")[0]
            raise InputError(field, file, f"is what the run was started with, and the {what} has changed since")

    def write_trials(self, rows: Iterable[TrialRow]) -> None:
        write_whole(self.path / TRIALS, format_trials(rows), sync=True)

    def write_summary(self, summary: Mapping[str, Any]) -> None:
        write_whole(self.path / SUMMARY, json.dumps(summary, indent=2) + "\n", sync=True)

    def write_error(self, seed: int, traceback: str) -> Path:
        path = error_file(self.path, seed)
        write_whole(path, hidden(traceback), sync=True)
        return path

    @contextmanager
    def new_trial(self, seed: int) -> Iterator[Path]:
        """A temporary folder that becomes ``seed=N`` when the block ends, and vanishes if it raises.

        Raises
        ------
        FolderError
            Instead of any OSError, those of the block included.
        """
        with self._hidden(seed) as temporary:
            yield temporary
            for file in temporary.iterdir():
                on_disk(file)
            (error_file(self.path, seed)).unlink(missing_ok=True)
            final = self.trial(seed)
            if final.exists():  # a stopped trial that ran again
                old = self.path / f".seed={seed}.old.tmp"
                remove_folder(old)
                require_no_link(self.path, final.name).replace(old)
                temporary.replace(final)
                keep_others(old, final)
            else:
                temporary.replace(final)

    @contextmanager
    def more_of_trial(self, seed: int, stem: str) -> Iterator[Path]:
        """A temporary folder whose files go into ``seed=N`` when the block ends, a new result last; none if it raises.

        Parameters
        ----------
        stem
            How their names begin: older files of the trial's that begin so, and are not among them, go.

        Raises
        ------
        FolderError
            Instead of any OSError, those of the block included.
        """
        with self._hidden(seed) as temporary:
            yield temporary
            files = sorted(temporary.iterdir(), key=lambda file: (file.name == RESULT, file.name))
            for file in files:
                on_disk(file)
            trial, names = require_no_link(self.path, self.trial(seed).name), {file.name for file in files}
            remove_files(trial, [old.name for old in trial.glob(f"{stem}*") if old.name not in names])
            for file in files:
                file.replace(trial / file.name)

    @contextmanager
    def _hidden(self, seed: int) -> Iterator[Path]:
        """An empty folder for files of a trial, which vanishes; an OSError within is a FolderError."""
        temporary = self.path / f".seed={seed}.{os.getpid()}.tmp"
        try:
            remove_folder(temporary)
            temporary.mkdir()
            yield temporary
        except OSError as error:
            raise FolderError(error) from error
        finally:
            remove_folder(temporary)

    def require_room(self, size: int = 0) -> None:
        """Raise OSError unless a file of so many bytes can be written, and some more: the disk may be full."""
        with tempfile.TemporaryFile(dir=self.path) as file:
            file.write(os.urandom(size + SPARE_BYTES))
            file.flush()
            os.fsync(file.fileno())


def fresh_folder(parent: Path, now: datetime) -> Path:
    """A new folder named by the time, numbered if another run started in the same second; raises OSError."""
    stem = now.strftime("%Y-%m-%d_%H-%M-%S")
    parent.mkdir(parents=True, exist_ok=True)
    for number in range(1, 1000):
        path = parent / (stem if number == 1 else f"{stem}_{number}")
        try:
            path.mkdir()
            return path
        except FileExistsError:
            continue
    raise FileExistsError(17, "too many runs started in the same second")


def _differences(old: Node, new: Node) -> list[str]:
    """The keys whose values differ, but for those that may."""
    free = (*FREE_TO_CHANGE, *OF_STAGES)  # a run may go on
    left, right = (flatten({k: v for k, v in c.items() if k not in free}) for c in (old, new))
    missing = object()
    return [
        f"{key} was {left.get(key, 'not set')}, is {right.get(key, 'not set')}"
        for key in sorted(left.keys() | right.keys())
        if left.get(key, missing) != right.get(key, missing)
    ]


def _start_in(content: bytes) -> Any:
    """The start pattern in a start.json; what cannot be read as one differs from every other."""
    try:
        return with_public_targets(json.loads(content))
    except ValueError:
        return content


def read_note(folder: Path) -> dict[str, Any]:
    """The contents of tracking.json: the ``key`` of a run folder and the ``uri`` of its store; {} if there is none."""
    try:
        content = read_json(folder / TRACKING)
    except (OSError, ValueError):
        return {}
    if isinstance(content, dict) and isinstance(content.get("uri"), str):  # version 0.1.0 wrote what it was given
        content["uri"] = keep(content["uri"])
    return content if isinstance(content, dict) else {}


def write_note(folder: Path, content: Mapping[str, Any]) -> None:
    write_whole(folder / TRACKING, json.dumps(content, indent=1) + "\n", sync=True)


def read_summary(folder: Path) -> dict[str, Any]:
    """The contents of summary.json; {} if there is none."""
    content: object = None
    with suppress(OSError, ValueError):
        content = read_json(folder / SUMMARY)
    return content if isinstance(content, dict) else {}
