"""Files that are wrong in every way, and a process of its own that reads them: `python -m tests.verification.fuzz DIR`.

It has as much memory as it may need and an alarm for every file. A file that hangs or eats memory ends it, and the last
line that it wrote names the file.
"""

from __future__ import annotations

import contextlib
import io
import json
import random
import resource
import signal
import sys
import traceback
from collections.abc import Callable, Iterator, Mapping
from pathlib import Path
from typing import Any

from origami_lab.cli import main
from origami_lab.fold_format.writer import to_fold
from tests.known_designs import closed_forms as designs
from tests.known_designs.fold_documents import foreign, known_chair, known_design, miura_sheet

PAPER = Path(__file__).parents[2] / "results/paper/designs"
SECONDS = 120
"""Far beyond what any file takes: what is caught are hangs, not slowness."""
ADDRESS_SPACE = 6 * 2**30
"""The machine's protection; what counts is the memory that was really used."""
FORMATS = ("fold", "svg", "glb", "html")
ODD = [None, True, -1, 0, 3, 1e9, -1e300, 0.5, "B", "", "\ud800", "x" * 10_000, [], [[]], {}, [0, 1], [[0, 0]], 10**30]
NUMBERS = ("NaN", "Infinity", "-Infinity", "1e400", "-1e308", "1e-320", "9" * 40, "9" * 6000, "-0", "00", "0x1")
LARGEST = 15 * 2**20
"""Bytes, about: what the giants are made of must not itself take the memory that is looked for."""
MARK = 123454321
"""Stands for what JSON cannot be made to say."""

Fold = dict[str, Any]


def sources() -> dict[str, Fold]:
    """Twenty files by name: the paper's designs, known ones, and such as other programs write them."""
    found = {path.stem: json.loads(path.read_text(encoding="utf-8")) for path in sorted(PAPER.glob("*.fold"))}
    for fold in found.values():  # a few of ten states: enough to go wrong
        fold["file_frames"] = fold["file_frames"][-3:]
    found |= {name: to_fold(known_design(name)) for name in ("pyramid", "cube")}
    found["chair"] = to_fold(known_chair(30.0, 80.0))
    found["valley"], found["valley, foreign"] = (change(designs.single_valley()) for change in (to_fold, foreign))
    found["miura"], found["miura, foreign"] = (change(designs.miura()) for change in (to_fold, foreign))
    found["degree four, foreign"] = foreign(designs.degree_four())
    found["miura sheet"] = miura_sheet(3, 4, 60.0, 60.0)
    return found


def place(fold: Fold, rng: random.Random) -> tuple[Any, Any]:
    """A dict or list somewhere in the object, and one of its keys."""
    at: Any = fold
    while True:
        key = rng.choice(list(at) if isinstance(at, dict) else range(len(at)))
        if not (isinstance(at[key], dict | list) and at[key] and rng.random() < 0.8):
            return at, key
        at = at[key]


def _list(fold: Fold, rng: random.Random) -> list[Any]:
    """One of the lists that make the pattern."""
    frames = [frame for frame in [fold, *fold.get("file_frames", [])] if isinstance(frame, dict)]
    found = [value for frame in frames for value in frame.values() if isinstance(value, list) and value]
    return rng.choice(found)


def bytes_flipped(fold: Fold, rng: random.Random) -> bytes:
    data = bytearray(json.dumps(fold).encode())
    for _ in range(rng.choice((1, 1, 3, 30))):
        data[rng.randrange(len(data))] ^= 1 << rng.randrange(8)
    return bytes(data)


def truncated(fold: Fold, rng: random.Random) -> bytes:
    data = json.dumps(fold).encode()
    return data[: rng.randrange(len(data))]


def key_removed(fold: Fold, rng: random.Random) -> Fold:
    del fold[rng.choice(list(fold))]
    return fold


def item_removed(fold: Fold, rng: random.Random) -> Fold:
    at, key = place(fold, rng)
    del at[key]
    return fold


def type_changed(fold: Fold, rng: random.Random) -> Fold:
    at, key = place(fold, rng)
    at[key] = rng.choice(ODD)
    return fold


def number_changed(fold: Fold, rng: random.Random) -> bytes:
    frame = rng.choice([fold, *fold.get("file_frames", [])])
    at = (frame.get("edges_foldAngle") if rng.random() < 0.5 else None) or rng.choice(frame["vertices_coords"])
    key = rng.randrange(len(at))
    if rng.random() < 0.7:
        at[key] = rng.choice((-at[key], at[key] * 1e6, at[key] + 1, round(at[key]), at[key] * 1e-12))
        return json.dumps(fold).encode()
    at[key] = MARK
    return json.dumps(fold).replace(str(MARK), rng.choice(NUMBERS)).encode()


def doubled(fold: Fold, rng: random.Random) -> Fold:
    items = _list(fold, rng)
    items.insert(rng.randrange(len(items) + 1), rng.choice(items))
    return fold


def swapped(fold: Fold, rng: random.Random) -> Fold:
    lists = [key for key, value in fold.items() if isinstance(value, list)]
    one, other = rng.sample(lists, 2)
    fold[one], fold[other] = fold[other], fold[one]
    return fold


def deep(fold: Fold, rng: random.Random) -> bytes:
    at, key = place(fold, rng)
    at[key] = MARK
    depth, (opening, closing) = rng.choice((50, 3000, 200_000)), rng.choice((("[", "]"), ('{"a":', "}")))
    return json.dumps(fold).replace(str(MARK), opening * depth + "0" + closing * depth).encode()


def giant(fold: Fold, rng: random.Random) -> Fold:
    items = _list(fold, rng)
    item = rng.choice(items)
    size = min(rng.choice((300, 3000, 100_000, 600_000)), LARGEST // len(json.dumps(item)))
    items.extend([item] * size if rng.random() < 0.5 else items[:1000] * (size // 1000 + 1))
    return fold


MUTATIONS: tuple[Callable[[Fold, random.Random], Fold | bytes], ...] = (
    *(bytes_flipped, truncated, key_removed, item_removed, type_changed),
    *(number_changed, doubled, swapped, deep, giant),
)


def files(seed: int = 0) -> Iterator[tuple[str, bytes]]:
    """Every source changed in each of the ten ways, with what was done to it."""
    rng = random.Random(seed)
    for name, fold in sources().items():
        for mutate in MUTATIONS:
            data = good = json.dumps(fold).encode()
            while data == good:  # as −0 for 0 may leave it
                spoiled = mutate(json.loads(good), rng)
                data = spoiled if isinstance(spoiled, bytes) else json.dumps(spoiled).encode()
            yield f"{name}: {mutate.__name__}", data


def judge(arguments: list[str]) -> tuple[int | str, str]:
    """The exit code of a command and what it says on stderr; a traceback where it raises."""
    said, signed = io.StringIO(), signal.alarm(SECONDS)
    assert signed == 0
    try:
        with contextlib.redirect_stderr(said), contextlib.redirect_stdout(io.StringIO()):
            return main(arguments), said.getvalue()
    except BaseException:
        return "raised", traceback.format_exc()
    finally:
        signal.alarm(0)


def used() -> int:
    """The most memory that this process has had, in bytes."""
    status = Path("/proc/self/status").read_text(encoding="ascii")
    [line] = [line for line in status.splitlines() if line.startswith("VmHWM:")]
    return int(line.split()[1]) * 1024


def run(folder: Path) -> None:
    """Read all files of a folder; a line of JSON for each and command: before, what is read, then what came of it."""
    resource.setrlimit(resource.RLIMIT_AS, (ADDRESS_SPACE, ADDRESS_SPACE))
    for file in sorted(folder.glob("*.fold")):
        for command in (
            ["verify", str(file)],
            ["export", str(file), *(f"--to={name}" for name in FORMATS), f"--output={folder}"],
        ):
            _say({"file": file.name, "command": command[0]}, " ")
            code, said = judge(command)
            _say({"code": code, "said": said[-3000:], "memory": used()}, "\n")


def _say(facts: Mapping[str, object], end: str) -> None:
    sys.stdout.write(json.dumps(facts) + end)
    sys.stdout.flush()


if __name__ == "__main__":
    run(Path(sys.argv[1]))
