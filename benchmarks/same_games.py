"""Whether two versions of the code play the same games, bit for bit: every searcher on every target and objective.

``python benchmarks/same_games.py write FILE`` plays with this checkout and keeps what it found;
``python benchmarks/same_games.py compare FILE`` plays again and says for each cell whether it is the same, with exit
code 1 if one is not. Another checkout is played with ``--checkout DIR``, some cells only with ``--only evo``;
``--also straight_sectors=false`` gives settings to all of them, such as one that came later and has to be off. It knows
nothing of the code but ``origami_lab.run`` and the files of a run folder, so that it runs on versions whose modules
have moved. Compare on one machine, with the same libraries: compiled code may round differently on another.
"""

from __future__ import annotations

import argparse
import hashlib
import json
import os
import subprocess
import sys
import tempfile
from collections.abc import Iterator, Sequence
from pathlib import Path
from typing import Any

ROOT = Path(__file__).resolve().parents[1]
INTERACTIONS = 20_000
SEED = 0

SEARCHERS: dict[str, list[str]] = {
    **{name: [f"budget={INTERACTIONS}"] for name in ("rdm", "dfts", "bfts", "mcts", "evo", "lns")},
    "ppo": ["budget=600", "search.batch=200"],  # learns three times
}
TASKS: dict[str, list[str]] = {
    **{name: [f"target={name}"] for name in ("pyramid", "cube", "bowl", "face")},
    "mesh": [
        "target=mesh",
        "target.path=part.obj",
        "target.scale=0.5",
        "target.translate=[0,0,0]",
        "symmetry=y",
        "board.size=15",
        "start.size=2",
    ],
    **{name: [f"objective={name}"] for name in ("bucket", "shelf", "table", "chair", "packaging")},
}
# an open tray that mirrors left and right, not front and back, in half board cells
PART = """\
v -4 -4 0
v 4 -4 0
v 4 4 0
v -4 4 0
v -9 -10 4
v 9 -10 4
v 9 8 5
v -9 8 5
f 1 2 3
f 1 3 4
f 1 5 6
f 1 6 2
f 2 6 7
f 2 7 3
f 3 7 8
f 3 8 4
f 4 8 5
f 4 5 1
"""
COMMON = [f"seed={SEED}", "workers=1", "files=designs", "tracking=none", "verbosity=quiet"]

Cell = dict[str, Any]


def cells(only: str | None, also: Sequence[str] = ()) -> dict[str, list[str]]:
    """Name and overrides of each cell, ``also`` among them."""
    every = {
        f"{task} {searcher}": [*asked, f"search={searcher}", *budget, *COMMON, *also]
        for task, asked in TASKS.items()
        for searcher, budget in SEARCHERS.items()
    }
    return {name: overrides for name, overrides in every.items() if only is None or only in name.split()}


def play_all(checkout: Path, wanted: dict[str, list[str]]) -> Iterator[tuple[str, Cell]]:
    """Play the cells in one process; where that dies, the cell at fault is noted and another process goes on."""
    left = list(wanted)
    while left:
        with tempfile.TemporaryDirectory() as folder:
            (Path(folder) / "part.obj").write_text(PART, encoding="utf-8")
            command = [sys.executable, "-P", str(Path(__file__).resolve()), "play", str(checkout)]
            environment = {**os.environ, "PYTHONPATH": str(checkout)}
            with subprocess.Popen(
                command, cwd=folder, env=environment, stdin=subprocess.PIPE, stdout=subprocess.PIPE, text=True
            ) as child:
                assert child.stdin is not None
                assert child.stdout is not None
                child.stdin.write(json.dumps([[name, wanted[name]] for name in left]))
                child.stdin.close()
                for line in child.stdout:
                    name, cell = json.loads(line)
                    left.remove(name)
                    yield name, cell
            if left and child.returncode == NOT_THIS_CODE:
                sys.exit(NOT_THIS_CODE)
            if left:
                yield left.pop(0), {"died": child.returncode}


NOT_THIS_CODE = 3
"""Exit code of a process that would play with another code than the checkout's."""


def play(checkout: Path) -> None:
    """In the process that plays: read cells from stdin, write a line of JSON for each."""
    import origami_lab

    if checkout not in Path(origami_lab.__file__).resolve().parents:
        print(f"origami_lab is imported from {origami_lab.__file__}, not from {checkout}", file=sys.stderr)
        sys.exit(NOT_THIS_CODE)
    for name, overrides in json.loads(sys.stdin.read()):
        try:
            result = origami_lab.run(overrides)
            cell = digest(
                {str(name): value for name, value in result.trials.loc[SEED].items()}, result.folder / f"seed={SEED}"
            )
        except origami_lab.InputError as error:
            cell = {"refused": str(error)}
        except Exception as error:
            cell = {"raised": f"{type(error).__name__}: {error}"}
        print(json.dumps([name, cell]), flush=True)


def digest(row: dict[str, Any], trial: Path) -> Cell:
    """What must stay: figures of a trial's row, and hashes of its game and its learning curve."""
    if not (trial / "actions.json").is_file():
        return {"failed": str(row["status"])}
    saved = json.loads((trial / "actions.json").read_text(encoding="utf-8"))
    return {
        "return": repr(float(row["return"])),
        "driving_angle": repr(float(row["driving_angle"])),
        "interactions": int(row["interactions"]),
        "status": str(row["status"]),
        "actions": len(saved["actions"]),
        "hash of actions": sha(json.dumps(saved["actions"])),
        "hash of moves": sha(json.dumps(list(numbers(saved["moves"])))),
        "hash of curve": sha((trial / "curve.csv").read_text(encoding="utf-8")),
    }


def numbers(value: Any) -> Iterator[float]:
    """All numbers of a JSON value in their order: keys and words may be renamed."""
    if isinstance(value, dict):
        value = list(value.values())
    if isinstance(value, list):
        for item in value:
            yield from numbers(item)
    elif isinstance(value, int | float):
        yield value


def sha(text: str) -> str:
    return hashlib.sha256(text.encode()).hexdigest()[:16]


def libraries() -> dict[str, str]:
    """What the bits depend on besides our code."""
    from importlib.metadata import version
    from platform import machine, python_version

    names = ("numba", "numpy", "scipy", "torch", "stable-baselines3")
    return {"python": python_version(), "machine": machine(), **{name: version(name) for name in names}}


def shown(cell: Cell) -> str:
    """A cell in a few words."""
    for trouble in ("refused", "raised", "failed", "died"):
        if trouble in cell:
            return f"{trouble}: {cell[trouble]}"
    return f"return {cell['return']}, {cell['interactions']} interactions, {cell['actions']} actions"


def write(file: Path, checkout: Path, wanted: dict[str, list[str]]) -> int:
    found: dict[str, Cell] = {}
    for name, cell in play_all(checkout, wanted):
        found[name] = cell
        print(f"{name:16}  {shown(cell)}", flush=True)
    document = {"libraries": libraries(), "cells": found}
    file.write_text(json.dumps(document, indent=1) + "\n", encoding="utf-8")
    print(f"{len(found)} cells, {sum('return' in cell for cell in found.values())} played")
    return 0


def compare(file: Path, checkout: Path, wanted: dict[str, list[str]]) -> int:
    before = json.loads(file.read_text(encoding="utf-8"))
    for name, version in libraries().items():
        if version != before["libraries"].get(name):
            print(f"warning: {name} is {version} and was {before['libraries'].get(name)}: bits may differ for that")
    same, count = 0, 0
    for name, cell in play_all(checkout, wanted):
        count += 1
        was = before["cells"].get(name)
        if was is None:
            print(f"{name:16}  is not in {file}", flush=True)
        elif was == cell:
            same += 1
            print(f"{name:16}  the same: {shown(cell)}", flush=True)
        else:
            keys = [key for key in {**was, **cell} if was.get(key) != cell.get(key)]
            changes = "; ".join(f"{key} was {was.get(key)}, is {cell.get(key)}" for key in keys)
            print(f"{name:16}  DIFFERS: {changes}", flush=True)
    print(f"{count} cells, {same} the same")
    return 0 if same == count > 0 else 1


def main(arguments: Sequence[str] | None = None) -> int:
    given = list(sys.argv[1:] if arguments is None else arguments)
    if given[:1] == ["play"]:
        play(Path(given[1]))
        return 0
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("what", choices=["write", "compare"])
    parser.add_argument("file", type=Path)
    parser.add_argument("--checkout", type=Path, default=ROOT, help="the code that plays (default: this checkout)")
    parser.add_argument("--only", help="cells of this task or searcher only")
    parser.add_argument("--also", nargs="+", default=[], metavar="KEY=VALUE", help="settings for every cell")
    options = parser.parse_args(given)
    work = write if options.what == "write" else compare
    return work(options.file, options.checkout.resolve(), cells(options.only, options.also))


if __name__ == "__main__":
    sys.exit(main())
