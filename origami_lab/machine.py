"""Cores and memory of this machine, and the share that a trial takes."""

from __future__ import annotations

import os
from pathlib import Path

CGROUP = Path("/sys/fs/cgroup")
WORKER_BYTES = 400 * 2**20
"""Bytes of a worker process besides the states of its search, most of it libraries and kernels."""


def usable_cores() -> int:
    """Cores that ``workers=auto`` takes."""
    return len(os.sched_getaffinity(0)) if hasattr(os, "sched_getaffinity") else os.cpu_count() or 1


def container_cores() -> float | None:
    """The processor time that a container may use, in cores."""
    try:
        quota, period = (CGROUP / "cpu.max").read_text().split()
    except (OSError, ValueError):
        try:
            quota, period = ((CGROUP / f"cpu/cpu.cfs_{name}_us").read_text().strip() for name in ("quota", "period"))
        except OSError:
            return None
    return None if quota in ("max", "-1") else int(quota) / int(period)


def physical_memory() -> int:
    """Bytes of memory; a terabyte where the system does not tell."""
    try:
        return int(os.sysconf("SC_PAGE_SIZE") * os.sysconf("SC_PHYS_PAGES"))
    except (AttributeError, OSError, ValueError):
        return 2**40


def free_memory() -> tuple[int | None, int | None]:
    """Bytes that are free and bytes there are, within the limit of a container."""
    try:
        lines = (line.split() for line in Path("/proc/meminfo").read_text().splitlines())
        known = {line[0]: int(line[1]) * 1024 for line in lines if len(line) > 1}
        free, total = known["MemAvailable:"], known["MemTotal:"]
    except (OSError, ValueError, KeyError):
        return None, None
    for limit, usage in (
        ("memory.max", "memory.current"),
        ("memory/memory.limit_in_bytes", "memory/memory.usage_in_bytes"),
    ):
        try:
            most = int((CGROUP / limit).read_text())
            used = int((CGROUP / usage).read_text())
        except (OSError, ValueError):  # no limit ("max"), or none of this kind
            continue
        if most < total:
            free, total = min(free, max(most - used, 0)), most
    return free, total
