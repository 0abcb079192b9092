"""The run folder: what an experiment leaves on disk, and how it stays whole whenever the run is killed.

::

    config.yaml            the whole configuration; runs again with `origami-lab DIR/config.yaml`
    target.ply             the target's surface
    start.json             the moves of a start pattern that came from a file
    trials.csv             one row a finished trial
    summary.json           mean ± std, the best seed, versions, the command
    seed=N/                one finished trial, renamed into place as a whole
    seed=N.error.txt       the traceback of a trial that failed

Everything visible is whole: it is written under a hidden name first. What a killed run leaves of those is cleared when
it is resumed.
"""

from __future__ import annotations

import errno
import json
import os
import re
import shutil
import tempfile
from collections.abc import Iterable, Iterator, Mapping
from contextlib import contextmanager, suppress
from datetime import datetime
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np
from omegaconf import OmegaConf
from omegaconf.errors import OmegaConfBaseException
from yaml import YAMLError  # type: ignore[import-untyped]

from origami_lab.errors import InputError
from origami_lab.experiment.locks import RUNNING, locked
from origami_lab.experiment.settings import Node, Settings
from origami_lab.reporting.tables import FAILED, Row, format_trials, read_trials, spent_budget

if TYPE_CHECKING:
    from origami_lab.objectives.targets import Target

RESULTS = Path("results")
FREE_TO_CHANGE = ("seed", "workers", "files", "objective_seconds", "tracking", "output", "resume", "verbosity")
"""Keys that may differ between a run and its resumption: they do not change what a trial finds."""

_LEFTOVER = re.compile(
    r"\.((config\.yaml|target\.ply|start\.json|trials\.csv|(summary|tracking)\.json|seed=\d+\.error\.txt)\.\d+|seed=\d+\.(\d+|old))\.tmp"
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
            folder = cls(_fresh_folder(settings, now) if output is None else output)
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
        differing = _differences(self.config(), settings.config)
        if differing:
            raise InputError(
                "output",
                self.path,
                "cannot be resumed with other settings than it was started with: " + "; ".join(differing),
            )

    def clear_leftovers(self) -> None:
        """Remove what a killed process was writing. A stopped trial that was being replaced comes back."""
        with suppress(OSError):
            for leftover in [file for file in self.path.iterdir() if _LEFTOVER.fullmatch(file.name)]:
                final = self.path / leftover.name.removeprefix(".").removesuffix(".old.tmp")
                with suppress(OSError):
                    if leftover.name.endswith(".old.tmp") and not final.exists():
                        leftover.replace(final)
                    elif leftover.is_dir():
                        shutil.rmtree(leftover)
                    else:
                        leftover.unlink()

    # --- what is on disk ---

    @property
    def has_begun(self) -> bool:
        """Whether a run was started in it: its configuration is the first thing written."""
        return (self.path / "config.yaml").is_file()

    def config(self) -> dict[str, Any]:
        """The configuration the run was started with; raises InputError if it cannot be read."""
        try:
            container = OmegaConf.to_container(OmegaConf.load(self.path / "config.yaml"), resolve=True)
        except (OSError, ValueError, OmegaConfBaseException, YAMLError) as error:
            raise InputError("output", self.path, "must hold a run's config.yaml, this one cannot be read") from error
        return {str(key): value for key, value in container.items()} if isinstance(container, dict) else {}

    def trial(self, seed: int) -> Path:
        return self.path / f"seed={seed}"

    def rows(self) -> dict[int, dict[str, Any]]:
        """The rows of the trials on disk, by seed; a folder without a readable result counts as missing."""
        found = {}
        for file in self.path.glob("seed=*/result.json"):
            try:
                row = json.loads(file.read_text(encoding="utf-8"))
                found[int(row["seed"])] = row
            except (OSError, ValueError, KeyError, TypeError):
                continue
        return found

    def known_rows(self) -> dict[int, Row]:
        """What is known of the trials, by seed: those on disk, and those that the table says have failed since."""
        on_disk, table = self.rows(), self.path / "trials.csv"
        rows: dict[int, Row] = dict(on_disk)
        for row in read_trials(table) if table.is_file() else []:
            if str(row["status"]).startswith(FAILED) and not spent_budget(on_disk.get(row["seed"], {})):
                rows[row["seed"]] = row
        return dict(sorted(rows.items()))

    def check_target(self, target: Target) -> None:
        """Raise InputError if the target is not the one that the run was started with."""
        file = self.path / "target.ply"
        if file.is_file() and file.read_bytes() != ply_bytes(target.vertices, target.faces):
            raise InputError("target", file, "is what the run was started with, and the target has changed since")

    def check_start(self, start: Node) -> None:
        """Raise InputError if the start pattern's file does not hold what the run was started with."""
        file = self.path / "start.json"
        if file.is_file() and file.read_text(encoding="utf-8") != _start_text(start):
            raise InputError("start", file, "is what the run was started with, and the start pattern has changed since")

    # --- writing ---

    def write_config(self, config: Node) -> None:
        text = OmegaConf.to_yaml(OmegaConf.create(dict(config)))
        head = f"# runs again with: origami-lab {self.path / 'config.yaml'}\n"
        write_atomically(self.path / "config.yaml", head + text)

    def write_target(self, target: Target) -> None:
        write_atomically(self.path / "target.ply", ply_bytes(target.vertices, target.faces))

    def write_start(self, start: Node) -> None:
        write_atomically(self.path / "start.json", _start_text(start))

    def write_trials(self, rows: Iterable[Row]) -> None:
        write_atomically(self.path / "trials.csv", format_trials(rows))

    def write_summary(self, summary: Mapping[str, Any]) -> None:
        write_atomically(self.path / "summary.json", json.dumps(summary, indent=2) + "\n")

    def write_error(self, seed: int, traceback: str) -> Path:
        path = self.path / f"seed={seed}.error.txt"
        write_atomically(path, traceback)
        return path

    @contextmanager
    def new_trial(self, seed: int) -> Iterator[Path]:
        """A temporary folder that becomes ``seed=N`` when the block ends, and vanishes if it raises.

        Raises
        ------
        FolderError
            Instead of any OSError, those of the block included.
        """
        temporary = self.path / f".seed={seed}.{os.getpid()}.tmp"
        try:
            shutil.rmtree(temporary, ignore_errors=True)
            temporary.mkdir()
            yield temporary
            for file in temporary.iterdir():
                _sync(file)
            (self.path / f"seed={seed}.error.txt").unlink(missing_ok=True)
            final = self.trial(seed)
            if final.exists():  # a stopped trial that ran again
                old = self.path / f".seed={seed}.old.tmp"
                shutil.rmtree(old, ignore_errors=True)
                final.replace(old)
                temporary.replace(final)
                shutil.rmtree(old, ignore_errors=True)
            else:
                temporary.replace(final)
        except OSError as error:
            raise FolderError(error) from error
        finally:
            shutil.rmtree(temporary, ignore_errors=True)

    def require_room(self, size: int) -> None:
        """Raise OSError unless a file of so many bytes can be written."""
        with tempfile.TemporaryFile(dir=self.path) as file:
            file.write(os.urandom(size))
            file.flush()
            os.fsync(file.fileno())


def failed_row(seed: int, reason: str) -> dict[str, Any]:
    """The row of a trial that has no result."""
    return {"seed": seed, "status": f"{FAILED}: {reason}"}


def write_atomically(path: Path, content: str | bytes) -> None:
    """Write a file so that a reader finds the old content or the new one, never a part."""
    temporary = path.with_name(f".{path.name}.{os.getpid()}.tmp")
    try:
        temporary.write_bytes(content if isinstance(content, bytes) else content.encode("utf-8"))
        _sync(temporary)
        temporary.replace(path)
    finally:
        with suppress(OSError):
            temporary.unlink(missing_ok=True)


def _sync(file: Path) -> None:
    """Have a file on the disk: some file systems only say then that there is no room for it."""
    with file.open("rb+") as stream:
        os.fsync(stream.fileno())


def ply_bytes(vertices: np.ndarray[Any, Any], faces: np.ndarray[Any, Any]) -> bytes:
    """A triangle mesh, (V, 3) and (F, 3), as binary PLY; by hand: importing trimesh takes a second."""
    header = (
        "ply\nformat binary_little_endian 1.0\n"
        f"element vertex {len(vertices)}\nproperty double x\nproperty double y\nproperty double z\n"
        f"element face {len(faces)}\nproperty list uchar int vertex_indices\nend_header\n"
    )
    records = np.empty(len(faces), dtype=[("count", "u1"), ("corners", "<i4", (3,))])
    records["count"] = 3
    records["corners"] = faces
    body = np.ascontiguousarray(vertices, dtype="<f8").tobytes() + records.tobytes()
    return header.encode("ascii") + body


def _fresh_folder(settings: Settings, now: datetime) -> Path:
    """results/<task>/<method>/<time>, numbered if another run started in the same second."""
    parent = RESULTS / settings.task / settings.method
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
    left, right = (flatten({k: v for k, v in c.items() if k not in FREE_TO_CHANGE}) for c in (old, new))
    missing = object()
    return [
        f"{key} was {left.get(key, 'not set')}, is {right.get(key, 'not set')}"
        for key in sorted(left.keys() | right.keys())
        if left.get(key, missing) != right.get(key, missing)
    ]


def flatten(node: Node, prefix: str = "") -> dict[str, Any]:
    """Nested keys as dotted ones; an empty mapping stays a value."""
    flat: dict[str, Any] = {}
    for key, value in node.items():
        if isinstance(value, Mapping) and value:
            flat.update(flatten(value, f"{prefix}{key}."))
        else:
            flat[f"{prefix}{key}"] = value
    return flat


def _start_text(start: Node) -> str:
    return json.dumps(start, indent=1) + "\n"
