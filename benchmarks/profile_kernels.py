"""Where searches spend their time, kernel by kernel: ``python -m benchmarks.profile_kernels [--out FILE]``.

Needs ``perf`` and ``nm``. Each search runs in a process of its own, on one core, warm, with a map of the machine code
of its kernels, so that samples of the processor's clock fall on kernels by name. A kernel that LLVM has put into its
caller counts as that.
"""

from __future__ import annotations

import argparse
import collections
import os
import re
import shutil
import subprocess
import sys
import tempfile
from pathlib import Path
from typing import Any

from benchmarks import write_report
from benchmarks.checkouts import CASES

PER_SECOND = 2000
SHOWN = 0.01
"""Kernels with a smaller share in all searches are left out."""
OTHERS = "Python, NumPy, numba's dispatch, memory"


def name_of(symbol: str) -> str | None:
    """The Python name of a kernel in a symbol of numba's; None for others."""
    begin, names = re.search(r"_ZN(?=\d)", symbol), []
    at = begin.end() if begin else len(symbol)
    while found := re.match(r"(\d+)", symbol[at:]):
        at += len(found[1])
        names.append(symbol[at : at + int(found[1])])
        at += int(found[1])
    return names[-1] if "origami_lab" in names else None


def write_map(libraries: list[tuple[Any, bytes]]) -> None:
    """Write the map of this process's kernels that ``perf`` reads."""
    lines = []
    for library, code in libraries:
        with tempfile.NamedTemporaryFile(suffix=".o") as file:
            file.write(code)
            file.flush()
            table = subprocess.run(["nm", "--print-size", "--defined-only", file.name], capture_output=True, text=True)
        words = [line.split() for line in table.stdout.splitlines()]
        symbols = [(int(each[0], 16), int(each[1], 16), each[2], each[3]) for each in words if len(each) == 4]
        own = next(((start, symbol) for start, _, kind, symbol in symbols if kind == "T"), None)
        if own is None:
            continue
        base = library.get_pointer_to_function(own[1]) - own[0]
        lines += [
            f"{base + start:x} {size:x} {name_of(symbol) or OTHERS}"
            for start, size, kind, symbol in symbols
            if kind in "TW"
        ]
    Path(f"/tmp/perf-{os.getpid()}.map").write_text("\n".join(lines) + "\n")


def search_forever(overrides: list[str]) -> None:
    """Warm up, write the map, say so, and search until killed."""
    from numba.core.codegen import CodeLibrary

    libraries: list[tuple[Any, bytes]] = []
    keep = CodeLibrary._set_compiled_object

    def kept(library: Any, code: bytes) -> None:
        libraries.append((library, code))
        keep(library, code)

    CodeLibrary._set_compiled_object = kept
    import numpy as np

    from origami_lab.config import build_parts, compose_settings
    from origami_lab.search.problem import Problem

    settings = compose_settings(overrides)
    seed, interactions = 0, 20_000
    while True:
        parts = build_parts(settings)
        problem = Problem(parts.game, parts.objective, interactions)
        parts.searcher.search(problem, np.random.default_rng(seed))
        if seed == 0:
            write_map(libraries)
            print("ready", flush=True)
        seed, interactions = seed + 1, 500_000


def shares(overrides: list[str], seconds: float) -> dict[str, float]:
    """The share of each kernel in the time of a search."""
    command = [sys.executable, "-m", "benchmarks.profile_kernels", "--search", *overrides]
    child = subprocess.Popen(command, stdout=subprocess.PIPE, text=True)
    assert child.stdout is not None
    with tempfile.TemporaryDirectory() as place:
        try:
            child.stdout.readline()
            data = f"{place}/perf.data"
            record = f"perf record -q -e cpu-clock -F {PER_SECOND} -p {child.pid} -o {data} -- sleep {seconds}"
            subprocess.run(record.split(), check=True, capture_output=True)
            shown = subprocess.run(
                ["perf", "script", "-i", data, "-F", "ip,sym,dso"], check=True, capture_output=True, text=True
            ).stdout
        finally:
            child.kill()
            child.wait()
            Path(f"/tmp/perf-{child.pid}.map").unlink(missing_ok=True)
    counts: collections.Counter[str] = collections.Counter()
    for line in shown.splitlines():
        _, symbol, home = line.split(maxsplit=2)
        counts[symbol if home.startswith("(/tmp/perf-") else OTHERS] += 1
    return {name: count / counts.total() for name, count in counts.items()}


def largest(found: dict[str, float]) -> list[tuple[str, float]]:
    return sorted(found.items(), key=lambda item: -item[1])


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--search", nargs="*", help=argparse.SUPPRESS)
    parser.add_argument("--seconds", type=float, default=20.0)
    parser.add_argument("--only", default="")
    parser.add_argument("--out", type=Path)
    chosen = parser.parse_args()
    if chosen.search is not None:
        search_forever(chosen.search)
    for tool in ("perf", "nm"):
        if shutil.which(tool) is None:
            parser.error(f"needs {tool}")
    cases = [case for case in CASES if not chosen.only or case.name in chosen.only.split(",")]
    load = os.getloadavg()[0]
    found = {}
    for case in cases:
        found[case.name] = shares([*case.overrides, "tracking=none"], chosen.seconds)
        print(
            case.name, *(f"{name} {share:.1%}" for name, share in largest(found[case.name])[:4]), sep="  ", flush=True
        )
    most = {name: max(each.get(name, 0.0) for each in found.values()) for each in found.values() for name in each}
    rows = [name for name, share in largest(most) if share >= SHOWN]
    lines = [
        "# Where searches spend their time, kernel by kernel",
        "",
        f"`perf`, {PER_SECOND} samples of the processor's clock a second, for {chosen.seconds:g} s each, in a warm"
        f" process on one core; load average {load:.2f}.",
        f"Shares of a search's time in percent; a dot is less than {SHOWN:.0%}.",
        "",
        f"| | {' | '.join(found)} |",
        f"|---|{'---:|' * len(found)}",
    ]
    for name in rows:
        cells = [f"{100 * each.get(name, 0.0):.0f}" if each.get(name, 0.0) >= SHOWN else "·" for each in found.values()]
        lines.append(f"| {name if name == OTHERS else f'`{name}`'} | {' | '.join(cells)} |")
    left = [1.0 - sum(each.get(name, 0.0) for name in rows) for each in found.values()]
    lines.append(f"| others | {' | '.join(f'{100 * share:.0f}' for share in left)} |")
    write_report(lines, chosen.out)


if __name__ == "__main__":
    main()
