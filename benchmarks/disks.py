"""Run folders on disks that fill up, become read-only or vanish: a part of :mod:`benchmarks.faults`."""

from __future__ import annotations

import os
import shutil
import subprocess
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from pathlib import Path

from benchmarks.runs import SMALL, UNTRACKED, Report, Run, expect, finished, problems_of, start, statuses, trials


@contextmanager
def small_disk(place: Path, kilobytes: int) -> Iterator[Path]:
    """A file system of its own with so much room."""
    mount = place / "disk"
    mount.mkdir(exist_ok=True)
    subprocess.run(["mount", "-t", "tmpfs", "-o", f"size={kilobytes}k", "none", str(mount)], check=True)
    try:
        yield mount
    finally:
        subprocess.run(["umount", "-l", str(mount)], check=True)


def disks(place: Path, report: Report) -> None:
    """Fill, lock and remove the output folder."""
    report.add("", "## Full, read-only and vanishing output folders", "")
    if shutil.which("mount") is None or os.getuid() != 0:
        report.add("Not run: mounting a small tmpfs needs root on Linux.")
        return
    wanted = _reference(place)
    report.add("tmpfs mounts with the given room left when the run starts; a trial takes about 1 MB.")
    report.table("what happens", "exit code", "trials.csv", "trials kept", "it says", "resumed with room")
    for left in (0, 4, 8, 16, 256, 1100, 2048):
        _full_from_start(place, report, left, wanted)
    _meanwhile(place, report, "full after the first trial", _fill, wanted)
    _meanwhile(place, report, "read-only after the first trial", _lock, wanted)
    _meanwhile(place, report, "removed after the first trial", _remove, wanted)
    _read_only(place, report)


def _reference(place: Path) -> object:
    run = start(place, [*SMALL, UNTRACKED, "output=reference"])
    run.wait()
    return trials(place / "reference")


def _full_from_start(place: Path, report: Report, left: int, wanted: object) -> None:
    with small_disk(place, 16384) as disk:
        folder = disk / "out"
        folder.mkdir()
        _fill(disk, left)
        run = start(place, [*SMALL, UNTRACKED, f"output={folder}", "resume=true"])
        _full_row(place, report, f"{left} kB left", run, folder, wanted)


def _meanwhile(place: Path, report: Report, name: str, fault: Callable[[Path], None], wanted: object) -> None:
    with small_disk(place, 16384) as disk:
        folder = disk / "out"
        run = start(place, [*SMALL, UNTRACKED, f"output={folder}", "workers=1"])
        run.wait_for(lambda: (folder / "seed=0").exists())
        fault(disk)
        _full_row(place, report, name, run, folder, wanted)


def _full_row(place: Path, report: Report, name: str, run: Run, folder: Path, wanted: object) -> None:
    """Wait for the end of a run whose disk failed, mend the disk and resume."""
    code, kept = run.wait(), finished(folder)
    run.wait_for(lambda: not run.alive())
    says = run.line("could not be written").replace(str(folder.parent), "/disk")
    problems = problems_of(run, folder, tidy=_writable(folder)) + expect("the exit code", code, 1)
    problems += [] if says else [f"it says only: {run.text()[-200:]}"]
    table = statuses(folder)
    _mend(folder.parent)
    again = start(place, [*SMALL, UNTRACKED, f"output={folder}", "resume=true"])
    problems += expect("the exit code after resuming", again.wait(), 0) + problems_of(again, folder)
    problems += expect("the table", trials(folder), wanted)
    lost = [seed for seed, written in kept.items() if finished(folder).get(seed) != written]
    problems += expect("finished trials run again", lost, [])
    report.row([name, code, table, len(kept), says, statuses(folder)], problems)


def _fill(disk: Path, left: int = 0) -> None:
    """Fill a disk up but for some kilobytes."""
    with (disk / "ballast").open("wb", buffering=0) as ballast:
        size = shutil.disk_usage(disk).free - 1024 * left
        os.posix_fallocate(ballast.fileno(), 0, max(size, 4096))


def _lock(disk: Path) -> None:
    """Make the folder read-only: by a mount over itself, as the disk has files that are open for writing."""
    out = str(disk / "out")
    subprocess.run(["mount", "--bind", out, out], check=True)
    subprocess.run(["mount", "-o", "remount,bind,ro", out], check=True)


def _mend(disk: Path) -> None:
    """Take back whatever was done."""
    subprocess.run(["umount", str(disk / "out")], capture_output=True)  # it fails where nothing was mounted
    (disk / "ballast").unlink(missing_ok=True)


def _remove(disk: Path) -> None:
    while (disk / "out").exists():
        shutil.rmtree(disk / "out", ignore_errors=True)


def _writable(folder: Path) -> bool:
    return os.access(folder, os.W_OK)


def _read_only(place: Path, report: Report) -> None:
    with small_disk(place, 16384) as disk:
        (disk / "out").mkdir()
        _lock(disk)
        run = start(place, [*SMALL, UNTRACKED, f"output={disk}/out"])
        code = run.wait()
        says = run.text().strip().replace(str(disk), "/disk")
        problems = expect("the exit code", code, 2) + expect("lines", len(says.splitlines()), 1)
        _mend(disk)
        report.row(["read-only from the start", code, "–", "–", says, "–"], problems)
