"""Folders for what can be computed again, also on a machine where the user has no home that can be written."""

from __future__ import annotations

import atexit
import getpass
import os
import shutil
import stat
import tempfile
from dataclasses import dataclass
from functools import cache
from pathlib import Path

from origami_lab.files import is_writable

KERNELS = "NUMBA_CACHE_DIR"
"""The variable of the environment that names the folder of kernels."""


@dataclass(frozen=True)
class KernelCache:
    """The folder in which compiled kernels are kept."""

    base: Path | None
    """Below it each version of the kernels has a folder of its own. None: there is no folder at all."""
    remark: str = ""
    """One line about it, where it is not the one that it should be."""


def kernel_cache() -> KernelCache:
    """Where kernels are kept: as the environment says, else in the user's home, else among the temporary files."""
    chosen = os.environ.get(KERNELS)
    wanted = Path(chosen) if chosen else _in_home("XDG_CACHE_HOME", ".cache", "origami-lab")
    if wanted is not None and is_writable(wanted):
        return KernelCache(wanted)
    why = "there is no home folder" if wanted is None else f"{wanted} cannot be written"
    place = temporary_folder()
    remedy = f"; {KERNELS} or XDG_CACHE_HOME may name another folder"
    if place is None:
        return KernelCache(None, f"{why}: every process compiles its kernels anew{remedy}")
    return KernelCache(place / "kernels", f"{why}: compiled kernels are kept in {place / 'kernels'}{remedy}")


@cache
def temporary_folder() -> Path | None:
    """A folder of this user's among the temporary files; None if there is no place for such.

    It is one for all processes, unless its name is taken by somebody else, who could put anything there: then it is a
    fresh one, which goes with this process.
    """
    try:
        place = Path(tempfile.gettempdir()) / f"origami-lab-{os.getuid() if hasattr(os, 'getuid') else 'cache'}"
        place.mkdir(mode=0o700, exist_ok=True)
        found = place.lstat()
        ours = not hasattr(os, "getuid") or found.st_uid == os.getuid()
        if stat.S_ISDIR(found.st_mode) and ours and not found.st_mode & 0o022 and is_writable(place):
            return place
    except FileExistsError:
        pass
    except OSError:
        return None
    fresh = tempfile.mkdtemp(prefix="origami-lab-")
    atexit.register(shutil.rmtree, fresh, ignore_errors=True)
    return Path(fresh)


def settle_matplotlib() -> None:
    """Name a folder for Matplotlib's settings and list of fonts, if its own cannot be written: it complains, else."""
    own = (_in_home("XDG_CONFIG_HOME", ".config", "matplotlib"), _in_home("XDG_CACHE_HOME", ".cache", "matplotlib"))
    if "MPLCONFIGDIR" not in os.environ and not all(place is not None and is_writable(place) for place in own):
        if (place := temporary_folder()) is not None:
            os.environ["MPLCONFIGDIR"] = str(place / "matplotlib")


def homeless() -> dict[str, str]:
    """Variables of the environment for libraries that cannot do without a home folder; empty where there is one."""
    found = {}
    try:
        there = Path.home().is_dir()
    except (RuntimeError, OSError):
        there = False
    if not there and (place := temporary_folder()) is not None:
        found["HOME"] = str(place)
    try:
        getpass.getuser()
    except (KeyError, OSError):  # a number that stands in no list of users
        found["USER"] = str(os.getuid())
    return found


def _in_home(variable: str, usual: str, name: str) -> Path | None:
    """A folder that a variable of the environment places, or the home folder; None if there is none."""
    try:
        return Path(os.environ.get(variable) or Path.home() / usual) / name
    except RuntimeError:
        return None
