"""The run folder: what an experiment leaves on disk, and how it stays whole whenever the run is killed.

::

    config.yaml            the whole configuration; runs again with `origami-lab DIR/config.yaml`
    target.ply             the target's surface
    trials.csv             one row a finished trial
    summary.json           mean ± std, the best seed, versions, the command
    seed=N/                one finished trial, renamed into place as a whole
    seed=N.error.txt       the traceback of a trial that failed
"""

from __future__ import annotations

import json
import os
import shutil
from collections.abc import Iterable, Iterator, Mapping
from contextlib import contextmanager
from datetime import datetime
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np
from omegaconf import OmegaConf

from origami_lab.errors import InputError
from origami_lab.experiment.settings import Node, Settings
from origami_lab.reporting.tables import FAILED, Row, format_trials

if TYPE_CHECKING:
    from origami_lab.objectives.targets import Target

RESULTS = Path("results")
FREE_TO_CHANGE = ("seed", "workers", "tracking", "output", "resume", "verbosity")
"""Keys that may differ between a run and its resumption: they do not change what a trial finds."""


class RunFolder:
    """The folder of one experiment."""

    def __init__(self, path: Path) -> None:
        self.path = path

    @classmethod
    def create(cls, settings: Settings, now: datetime | None = None) -> RunFolder:
        """Make the folder of a new run, or take up the one of a run that is resumed.

        Raises
        ------
        InputError
            If ``output`` holds something already and ``resume`` is false, if there is nothing to resume or
            it was made with other settings, or if the folder cannot be written.
        """
        try:
            if settings.resume:
                return cls._resume(settings)
            if settings.output is None:
                return cls(_fresh_folder(settings, now or datetime.now()))
            if settings.output.exists() and any(settings.output.iterdir()):
                raise InputError(
                    "output",
                    settings.output,
                    "must be a new or empty folder; resume=true finishes the run in it",
                )
            settings.output.mkdir(parents=True, exist_ok=True)
            if not os.access(settings.output, os.W_OK):
                raise PermissionError(13, "Permission denied")
            return cls(settings.output)
        except OSError as error:
            where = settings.output or RESULTS
            reason = error.strerror or str(error)
            raise InputError("output", where, f"must be a folder that can be written ({reason})") from error

    @classmethod
    def _resume(cls, settings: Settings) -> RunFolder:
        if settings.output is None:
            runs = sorted((RESULTS / settings.task / settings.method).glob("*/config.yaml"))
            hint = f", e.g. output={runs[-1].parent}" if runs else ""
            raise InputError("resume", "true", f"must come with the folder to finish, output=DIR{hint}")
        folder = cls(settings.output)
        if not (folder.path / "config.yaml").is_file():
            raise InputError("output", settings.output, "must be the folder of a run, there is no config.yaml in it")
        differing = _differences(folder.config(), settings.config)
        if differing:
            raise InputError(
                "output",
                settings.output,
                "cannot be resumed with other settings than it was started with: " + "; ".join(differing),
            )
        for leftover in folder.path.glob(".seed=*.tmp"):
            shutil.rmtree(leftover, ignore_errors=True)
        return folder

    # --- what is on disk ---

    def config(self) -> dict[str, Any]:
        """The configuration the run was started with."""
        container = OmegaConf.to_container(OmegaConf.load(self.path / "config.yaml"), resolve=True)
        assert isinstance(container, dict)
        return {str(key): value for key, value in container.items()}

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

    # --- writing ---

    def write_config(self, config: Node) -> None:
        text = OmegaConf.to_yaml(OmegaConf.create(dict(config)))
        head = f"# runs again with: origami-lab {self.path / 'config.yaml'}\n"
        write_atomically(self.path / "config.yaml", head + text)

    def write_target(self, target: Target) -> None:
        write_ply(self.path / "target.ply", target.vertices, target.faces)

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
        """A temporary folder that becomes ``seed=N`` when the block ends, and vanishes if it raises."""
        temporary = self.path / f".seed={seed}.{os.getpid()}.tmp"
        shutil.rmtree(temporary, ignore_errors=True)
        temporary.mkdir()
        try:
            yield temporary
            final = self.trial(seed)
            if final.exists():  # a stopped trial that ran again
                old = self.path / f".seed={seed}.old.tmp"
                shutil.rmtree(old, ignore_errors=True)
                final.replace(old)
                temporary.replace(final)
                shutil.rmtree(old, ignore_errors=True)
            else:
                temporary.replace(final)
            (self.path / f"seed={seed}.error.txt").unlink(missing_ok=True)
        finally:
            shutil.rmtree(temporary, ignore_errors=True)


def failed_row(seed: int, reason: str) -> dict[str, Any]:
    """The row of a trial that has no result."""
    return {"seed": seed, "status": f"{FAILED}: {reason}"}


def write_atomically(path: Path, text: str) -> None:
    """Write a file so that a reader finds the old text or the new one, never a part."""
    temporary = path.with_name(f".{path.name}.{os.getpid()}.tmp")
    try:
        with temporary.open("w", encoding="utf-8") as file:
            file.write(text)
            file.flush()
            os.fsync(file.fileno())
        temporary.replace(path)
    finally:
        temporary.unlink(missing_ok=True)


def write_ply(path: Path, vertices: np.ndarray[Any, Any], faces: np.ndarray[Any, Any]) -> None:
    """Write a triangle mesh, (V, 3) and (F, 3), as binary PLY; by hand: importing trimesh takes a second."""
    header = (
        "ply\nformat binary_little_endian 1.0\n"
        f"element vertex {len(vertices)}\nproperty double x\nproperty double y\nproperty double z\n"
        f"element face {len(faces)}\nproperty list uchar int vertex_indices\nend_header\n"
    )
    records = np.empty(len(faces), dtype=[("count", "u1"), ("corners", "<i4", (3,))])
    records["count"] = 3
    records["corners"] = faces
    body = np.ascontiguousarray(vertices, dtype="<f8").tobytes() + records.tobytes()
    path.write_bytes(header.encode("ascii") + body)


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
