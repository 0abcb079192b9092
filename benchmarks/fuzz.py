"""Hostile input: random overrides and mutated mesh files against the command; `python -m benchmarks.fuzz`.

Whatever is given, the command must end soon, in little memory, with exit code 0, 1 (a trial failed) or 2 (one line that
begins with "error:"), and never with a traceback. The bulk runs in one child process that stops before the first
trial; a sample of what was accepted then runs for real, each in a process of its own.
"""

from __future__ import annotations

import argparse
import contextlib
import io
import json
import os
import random
import re
import resource
import shlex
import signal
import subprocess
import sys
import tempfile
import time
from collections import Counter
from collections.abc import Iterator, Sequence
from dataclasses import asdict, dataclass, replace
from pathlib import Path
from typing import Any

FOUND = """## Found and mended, by it and by hand

* `+target.outer=1e9 +target.error=1e5`: the resolution of the bowl's mesh was searched for ever.
* `capacity=100000 driving_angle.count=100` (76 GB) and `workers=10000 seed=0..9999` were accepted.
* `+target.coefficient=1000`, `search.children=2.5` and `+objective.samples=1e9` were accepted.
* `board=null`, `=5`, numbers of 5000 digits, `max_crease_length=1e300`, `--resolve` alone: exit code 1 instead of 2.
* `hydra.run.dir=/dev/zero`: exit code 1, too.
* `--cfg` without a value: argparse's usage instead of one line.
* An OBJ whose `mtllib`, or a glTF whose buffer, is a pipe beside it: never ended.
* 1,000,000 triangles were parsed before they were counted, up to 9.4 s and 1950 MB (ASCII STL, 277 MB); now 0.1 s.
* A glTF of 6 MB that places one triangle 300,000 times: 21 s; now 0.4 s.
* Values of thousands of characters were repeated in full, with whatever control characters they held.
"""
SECONDS = 20
"""A case that takes longer hangs."""
ADDRESS_SPACE = 8 * 2**30
MEGABYTES = 1500
"""A child that needed more was led to it by its input: no test needs a third of that."""
GROUPS = {
    "target": ("bowl", "cube", "pyramid", "mesh", "none"),
    "board": ("9x9", "13x13", "25x25"),
    "symmetry": ("none", "x", "y", "xy", "xyd"),
    "start": ("square", "unit_square", "crease"),
    "search": ("rdm", "dfts", "bfts"),
    "objective": ("shape",),
    "tracking": ("none", "mlflow"),
    "experiment": ("none",),
}
KEYS = (
    *("board.width", "board.height"),
    *("board.size", "symmetry.name", "start.size", "start.position", "start._target_", "max_crease_length", "task"),
    *("source_action", "driving_angle.max", "driving_angle.count", "driving_angle.fixed", "driving_angle", "method"),
    *("objective.distance", "objective._target_", "objective.target", "+objective.samples", "+objective.tolerance"),
    *("target.path", "target.fit", "target.scale", "target.rotate", "target.translate", "target.align_z", "target"),
    *("target.closed", "target.max_faces", "target.edge", "target.apex", "target.half_width", "+target.outer"),
    *("+target.inner", "+target.error", "+target.coefficient", "+target.offset", "+target.name", "stuck", "certify"),
    *("capacity", "search.children", "search.restarts", "search._target_", "search", "budget", "seed", "workers"),
    *("output", "resume", "tracking.uri", "tracking.experiment", "tracking.kind", "tracking", "verbosity", "start"),
    *("board", "symmetry", "objective", "experiment", "+new", "++budget.deep", "hydra.job.name", "hydra.run.dir"),
)
VALUES = (
    *("0", "1", "-1", "2", "3", "9", "10", "1e3", "1e12", "1e30", "1e308", "-1e308", "1e-308", "0.5", "2.5", "nan"),
    *("inf", "-inf", "true", "false", "null", "", "'  '", "abc", "x.stl", "..", "../..", "/", "/dev/null", "/dev/zero"),
    *("/proc/self", "~", "[]", "[1]", "[0,0,0]", "[1e308,0,nan]", "[[1]]", "{}", "{a:1}", "{a:{b:[1]}}", "choose"),
    *("${budget}", "${seed}", "${nosuch}", "${oc.env:HOME}", "${oc.env:NOSUCH}", "${nosuch:1}", "${", "${target}"),
    *("0..9", "9..0", "0..99999", "0..9999999999", "[1,1]", "-5..5", "1,2", "a,b", "auto", "board", "'ä→∞'", "ä"),
    *("9" * 40, "9" * 5000, "x" * 3000, "[" * 60, "'\\n'", "'\\0'", "'\x1b[31m'", "os.system", "builtins.print"),
    *("origami_lab.game.Square", "origami_lab.targets.cube", "1_000", "0x10"),
    *("1e400", "choice(1,2)"),
)
MILD = (
    *(
        "board.size=5",
        "board.size=11",
        "board.size=1.1e1",
        "start.size=1",
        "start.size=choose",
        "max_crease_length=null",
    ),
    *("max_crease_length=1", "source_action=false", "driving_angle.max=1e-3", "driving_angle.max=90", "stuck=penalise"),
    *("driving_angle.fixed=45", "certify=none", "budget=1", "budget=1e3", "seed=7", "seed=[5,3]", "workers=99"),
    *("objective.distance=sampled", "objective.distance=surface", "+objective.samples=1", "search.children=1"),
    *("search.restarts=1e3", "task=a.b", "method=x", "verbosity=quiet", "verbosity=verbose", "+target.name=x"),
)
"""What is unusual, but allowed where it fits."""
FLAGS = (
    "-m",
    "--cfg",
    "--cfg job",
    "--resolve",
    "--info",
    "--help",
    "-x",
    "--config-name",
    "--config-dir /nosuch",
    "-c",
)
KINDS = ("stl", "ascii.stl", "obj", "ply", "ascii.ply", "off", "glb", "gltf")


@dataclass(frozen=True)
class Case:
    """One command and how it ended."""

    arguments: list[str]
    code: int
    seconds: float
    megabytes: float
    error: str
    printed_traceback: bool

    @property
    def fault(self) -> str | None:
        """What was wrong about the way it ended; None if nothing was."""
        lines = self.error.splitlines()
        if self.printed_traceback:
            return "traceback"
        if self.code not in (0, 1, 2):
            return f"exit code {self.code}"
        if self.code == 2 and (len(lines) != 1 or not lines[0].startswith("error: ")):
            return "not one line that says error"
        if self.code == 1 and lines and lines[-1].startswith("error:"):
            return "an exception: " + lines[-1][:90]
        if self.megabytes > MEGABYTES:
            return "too much memory"
        return "too slow" if self.seconds > SECONDS else None


# --- what is tried ---------------------------------------------------------------------------------------------------


def override_cases(count: int, seed: int) -> Iterator[list[str]]:
    """Commands with random groups and hostile values, contradictions, deletions, and mangled valid commands."""
    rng = random.Random(seed)
    for number in range(count):
        groups = rng.sample(list(GROUPS), rng.randint(0, 3))
        command = [f"{group}={rng.choice(GROUPS[group])}" for group in groups if group != "target"]
        command.append("target=" + rng.choice(GROUPS["target"] if rng.random() < 0.3 else ("bowl", "cube")))
        kind = number % 6
        if kind < 3:  # one to three hostile values
            command += [f"{rng.choice(KEYS)}={rng.choice(VALUES)}" for _ in range(kind + 1)]
        elif kind == 3:  # the same key twice, or a key left out
            key = rng.choice(KEYS)
            command += [
                f"{key}={rng.choice(VALUES)}",
                rng.choice([f"~{key.lstrip('+')}", f"{key}={rng.choice(VALUES)}"]),
            ]
        elif kind == 4:  # allowed, if they suit each other
            command += rng.sample(MILD, rng.randint(1, 4))
        else:  # letters exchanged, dropped, doubled; a flag anywhere
            command = [_mangled(rng, word) for word in [*command, "budget=100", "seed=0..1"]]
            command[rng.randrange(len(command)) : 0] = rng.choice(FLAGS).split()
        rng.shuffle(command)
        yield [word for word in command if word]


def _mangled(rng: random.Random, word: str) -> str:
    if rng.random() < 0.5:
        return word
    i = rng.randrange(len(word))
    return rng.choice(
        [
            word[:i] + word[i + 1 :],
            word[:i] + 2 * word[i] + word[i + 1 :],
            word[:i] + rng.choice("=,.~+[{$ '\"") + word[i:],
        ]
    )


def mesh_cases(count: int, seed: int, folder: Path) -> Iterator[list[str]]:
    """Valid mesh files, mutated: bytes, length, numbers, counts."""
    rng = random.Random(seed)
    originals = list(_originals())
    for number in range(count):
        kind, data = originals[number % len(originals)]
        for _ in range(rng.choice((0, 1, 1, 1, 3, 10))):
            data = _mutated(rng, data)
        path = folder / f"part{number}.{kind.rpartition('.')[2]}"
        path.write_bytes(data)
        fit = rng.choice(("target.fit=board", "target.fit=null"))
        yield [
            "target=mesh",
            f"target.path={path}",
            fit,
            f"target.closed={rng.choice(('auto', 'true'))}",
            "tracking=none",
        ]


def _originals() -> Iterator[tuple[str, bytes]]:
    import trimesh
    from trimesh.exchange import ply, stl

    two = trimesh.Scene([trimesh.creation.box((2, 1, 1)), trimesh.creation.icosphere(1).apply_translation([3, 0, 0])])
    for mesh in (trimesh.creation.box((4, 2, 1)), trimesh.creation.icosphere(1), two.to_mesh()):
        yield "ascii.stl", stl.export_stl_ascii(mesh).encode()
        yield "ascii.ply", ply.export_ply(mesh, encoding="ascii")
        for kind in ("stl", "obj", "ply", "off", "glb"):
            data = mesh.export(file_type=kind)
            yield kind, data.encode() if isinstance(data, str) else data
        files = trimesh.Scene([mesh]).export(file_type="gltf", embed_buffers=True)
        yield "gltf", files["model.gltf"]


def _mutated(rng: random.Random, data: bytes) -> bytes:
    if not data:
        return data
    i, j = sorted((rng.randrange(len(data)), rng.randrange(len(data))))
    what = rng.randrange(7)
    if what == 0:
        return data[:i] + bytes([rng.randrange(256)]) + data[i + 1 :]
    if what == 1:
        return data[:i]
    if what == 2:
        return data[:j] + data[i:]  # a part twice
    if what == 3:
        return data[:i] + data[i + min(j - i, 40) :]
    if what == 4:  # four bytes of a binary number: a count, an index, a float
        extreme = (b"\xff\xff\xff\xff", b"\0\0\0\x80", b"\0\0\xc0\x7f", b"\0\0\x80\x7f", b"\xff\xff\xff\x7f")
        return data[:i] + rng.choice(extreme) + data[i + 4 :]
    numbers = list(re.finditer(rb"-?\d+(\.\d+)?(e[-+]?\d+)?", data[:200_000]))
    if not numbers:
        return data[::-1]
    # the first ones are the counts
    found = rng.choice(numbers[:8] if what == 5 else numbers)
    extreme_texts = (b"nan", b"inf", b"1e308", b"-1", b"0", b"999999999", b"99999999999999999999", b"1e-300", b"x", b"")
    return data[: found.start()] + rng.choice(extreme_texts) + data[found.end() :]


# --- how it is run ---------------------------------------------------------------------------------------------------


class Late(BaseException):
    """Time is up: no ``Exception``, nobody shall handle it."""


def run_inside(arguments: Sequence[str]) -> Case:
    """The command in this process, up to the first trial: its worker processes are not started."""
    from origami_lab import cli
    from origami_lab.config.checked_values import Tracking
    from origami_lab.experiment import runner
    from origami_lab.tracking.tracker import make_tracker

    def late(*_: object) -> None:
        raise Late

    out, err = io.StringIO(), io.StringIO()
    untracked = lambda settings, *rest: make_tracker(replace(settings, tracking=Tracking("none")), *rest)  # noqa: E731
    vars(runner).update(TrialPool=_NoPool, make_tracker=untracked)
    before = signal.signal(signal.SIGALRM, late)
    signal.alarm(SECONDS)
    began = time.perf_counter()
    try:
        with contextlib.redirect_stdout(out), contextlib.redirect_stderr(err):
            code = cli.main(arguments)
    except Late:
        code = -1
    except SystemExit as ended:
        code = -2 if not isinstance(ended.code, int) else ended.code
    except BaseException as error:
        code = -3
        err.write(f"Traceback: {error!r}")
    finally:
        signal.alarm(0)
        signal.signal(signal.SIGALRM, before)
    seconds = time.perf_counter() - began
    text = err.getvalue()
    memory = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss / 1024
    return Case(list(arguments), code, seconds, memory, text[-2000:], "Traceback" in text + out.getvalue())


class _NoPool:
    """Stands in for the worker processes: no trial runs."""

    stopping = False

    def __init__(self, *_: object) -> None: ...
    def __enter__(self) -> _NoPool:
        return self

    def __exit__(self, *_: object) -> None: ...
    def close(self) -> None: ...
    def checked_parts(self) -> None: ...
    def run(self, *_: object) -> Iterator[Any]:
        return iter(())


def run_for_real(arguments: Sequence[str], folder: Path) -> Case:
    """The command in a process of its own, with a small budget and time for it."""
    command = [sys.executable, "-m", "origami_lab", *arguments, "tracking=none", "workers=1", "seed=0", "budget=50"]
    environment = {**os.environ, "PYTHONPATH": str(Path(__file__).parents[1])}
    began = time.perf_counter()
    try:
        done = subprocess.run(
            command, cwd=folder, env=environment, capture_output=True, text=True, timeout=600, check=False
        )
        code, text = done.returncode, done.stderr
    except subprocess.TimeoutExpired:
        code, text = -1, ""
    # the trial itself is no concern here: numba compiles anew for every capacity
    seconds = min(time.perf_counter() - began, SECONDS) if code >= 0 else time.perf_counter() - began
    memory = resource.getrusage(resource.RUSAGE_CHILDREN).ru_maxrss / 1024
    return Case(list(arguments), code, seconds, memory, text[-2000:], "Traceback" in text)


def child(overrides: int, meshes: int, seed: int) -> None:
    """Run all cases in this process and print each as a line of JSON."""
    resource.setrlimit(resource.RLIMIT_AS, (ADDRESS_SPACE, ADDRESS_SPACE))
    with tempfile.TemporaryDirectory() as name:
        folder = Path(name)
        os.chdir(name)
        for arguments in (*override_cases(overrides, seed), *mesh_cases(meshes, seed, folder)):
            print(json.dumps(asdict(run_inside(arguments))), flush=True)


# --- the report ------------------------------------------------------------------------------------------------------


def table(head: Sequence[str], rows: Sequence[Sequence[object]]) -> str:
    lines = [head, ["---"] * len(head), *rows]
    return "\n".join("| " + " | ".join(str(cell).replace("|", "\\|") for cell in line) + " |" for line in lines)


def shown(case: Case) -> str:
    text = shlex.join([re.sub(r"/\S*/part", "part", word) for word in case.arguments])
    return f"`{ascii(text)[1:-1][:150].replace('`', ' ')}`"


def _has_flag(arguments: Sequence[str]) -> bool:
    return any(word.startswith("-") for word in arguments)


def report(title: str, cases: Sequence[Case]) -> str:
    """Outcomes, the slowest, and what was wrong."""
    codes = Counter(case.code for case in cases)
    reasons = Counter(
        re.sub(r"^error: [^:]*?=.*?: ", "", case.error.splitlines()[-1])[:60]
        for case in cases
        if case.code == 2 and case.error
    )
    faults = [case for case in cases if case.fault]
    slowest = sorted(cases, key=lambda case: -case.seconds)[:5]
    parts = [
        f"## {title}: {len(cases)} cases, {len(faults)} faults",
        table(("exit code", "cases"), sorted(codes.items())),
        f"Largest memory of the process: {max(case.megabytes for case in cases):.0f} MB.",
        table(("slowest", "s", "exit code"), [(shown(case), f"{case.seconds:.2f}", case.code) for case in slowest]),
        table(
            ("most frequent refusals", "cases"),
            [(ascii(text)[1:-1], number) for text, number in reasons.most_common(8)],
        ),
    ]
    if faults:
        parts.append(table(("fault", "case"), [(case.fault, shown(case)) for case in faults]))
    return "\n\n".join(parts)


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--overrides", type=int, default=500)
    parser.add_argument("--meshes", type=int, default=200)
    parser.add_argument("--real", type=int, default=20)
    parser.add_argument("--seed", type=int, default=0)
    parser.add_argument("--out", type=Path, help="write the report there, too")
    parser.add_argument("--child", action="store_true", help=argparse.SUPPRESS)
    options = parser.parse_args()
    if options.child:
        child(options.overrides, options.meshes, options.seed)
        return
    command = [sys.executable, "-m", "benchmarks.fuzz", "--child", "--seed", str(options.seed)]
    command += ["--overrides", str(options.overrides), "--meshes", str(options.meshes)]
    done = subprocess.run(command, capture_output=True, text=True, check=False)
    cases = [Case(**json.loads(line)) for line in done.stdout.splitlines()]
    if len(cases) < options.overrides + options.meshes:
        sys.exit(f"the child process died after {len(cases)} cases: {done.stderr[-500:]}")
    with tempfile.TemporaryDirectory() as name:
        folder = Path(name)
        inputs = [*override_cases(options.overrides, options.seed), *mesh_cases(options.meshes, options.seed, folder)]
        # what was understood: the rest ends the same way in a process of its own
        accepted = [words for words, case in zip(inputs, cases, strict=True) if case.code == 0 and not _has_flag(words)]
        sample = [
            run_for_real(words, folder)
            for words in random.Random(options.seed).sample(accepted, min(options.real, len(accepted)))
        ]
    commit = subprocess.run(["git", "rev-parse", "--short", "HEAD"], capture_output=True, text=True, check=False)
    call = f"python -m benchmarks.fuzz --overrides {options.overrides} --meshes {options.meshes}"
    call += f" --real {options.real} --seed {options.seed}"
    text = "\n\n".join(
        [
            "# Hostile input",
            f"`{call}` at {commit.stdout.strip()}. {' '.join((__doc__ or '').split('`.', 1)[1].split())}",
            report("Overrides", cases[: options.overrides]),
            report("Mesh files", cases[options.overrides :]),
            report("Accepted commands, for real", sample),
            FOUND.strip(),
        ]
    )
    print(text)
    if options.out:
        options.out.write_text(text + "\n", encoding="utf-8")


if __name__ == "__main__":
    main()
