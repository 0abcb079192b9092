"""Are certificates true, and how long do they take? ``python -m benchmarks.certificates [--patterns 2000]``

Random patterns of all groups, boards and starts, made with and without the game's rule against collisions, are verified
and looked at densely: a thousand states by the game's closed forms and triangle test, a hundred times as densely around
the angle that the certificate names. Files that are made to be certified falsely are tried by the hundred. Every result
is a line of ``--rows``, so that a run goes on where it was stopped.
"""

from __future__ import annotations

import argparse
import json
import math
import os
import statistics
import tempfile
import time
from collections import Counter
from collections.abc import Callable, Iterator
from functools import partial
from pathlib import Path
from typing import Any

os.environ.setdefault("OMP_NUM_THREADS", "1")

import numpy as np

import origami_lab
from benchmarks import write_report
from tests.known_designs.fold_documents import write
from tests.verification.attacks import ATTACKS
from tests.verification.dense import STEPS, first_crossing, random_pattern

PAPER = Path(__file__).parents[1] / "results/paper/designs"
Row = dict[str, Any]
_CLOSE = 0.01
"""Degrees: how far the angle of a refutation may be from where the dense look first sees a crossing."""


def pattern_row(seed: int) -> Row:
    """A random pattern: the verdict, and what a dense look sees."""
    pattern = random_pattern(np.random.default_rng([1, seed]), collisions=bool(seed % 3))
    design = pattern.design()
    start = time.process_time()
    certificate = origami_lab.verify(design)
    seconds = time.process_time() - start
    near = [] if certificate.angle is None else [math.radians(certificate.angle)]
    try:
        first: float | None = math.degrees(first_crossing(pattern, STEPS, near))
    except ValueError:  # between two of its angles the game's motion does not exist
        first = None
    crossing = certificate["crossing"].numbers if certificate.has("crossing") else {}
    return {
        "kind": "pattern",
        "seed": seed,
        "rules": bool(seed % 3),
        "group": str(pattern.game.symmetry.name),
        "panels": len(design.panels),
        "verdict": certificate.verdict,
        "reason": certificate.reason,
        "angle": certificate.angle,
        "known first": bool(crossing.get("first", False)),
        "dense": None if first is None or math.isinf(first) else first,
        "motion": first is not None,
        "seconds": seconds,
    }


def attack_row(number: int, seed: int, folder: Path) -> Row:
    """A file that is made to be certified falsely, or an honest one of its kind."""
    attack = ATTACKS[number](np.random.default_rng([2, number, seed]))
    start = time.process_time()
    certificate = origami_lab.verify(write(folder / "attack.fold", attack.fold))
    return {
        "kind": ATTACKS[number].__name__,
        "seed": seed,
        "name": attack.name,
        "honest": attack.honest,
        "verdict": certificate.verdict,
        "reason": certificate.reason,
        "seconds": time.process_time() - start,
    }


def work(patterns: int, attacks: int, folder: Path) -> Iterator[tuple[tuple[str, int], Callable[[], Row]]]:
    """What is to be done, by kind and seed, the kinds in turn."""
    for seed in range(max(patterns, attacks)):
        if seed < patterns:
            yield ("pattern", seed), partial(pattern_row, seed)
        if seed < attacks:
            for number, attack in enumerate(ATTACKS):
                yield (attack.__name__, seed), partial(attack_row, number, seed, folder)


def outcome(row: Row) -> str:
    """What the dense look says of a verdict."""
    crosses, verdict = row["dense"] is not None, row["verdict"]
    if verdict == "certified":
        return "FALSE" if crosses or not row["motion"] else "agrees"
    if verdict == "not certifiable":
        return "open"
    if not row["motion"]:
        return "no motion"
    return "agrees" if crosses else "FALSE"


def report(rows: list[Row]) -> list[str]:
    """The tables."""
    found = [row for row in rows if row["kind"] == "pattern"]
    sizes = [row["panels"] for row in found]
    lines = [
        "# Certificates",
        "",
        "`python -m benchmarks.certificates`: verdicts against a dense look, attacks; time in CPU seconds of one core.",
        "",
        f"## {len(found)} random patterns, {min(sizes)} to {max(sizes)} panels",
        "",
        "| made | patterns | certified | refuted | not certifiable | false certificates | false refutations |",
        "|---|---|---|---|---|---|---|",
    ]
    for rules, name in ((True, "by the game's rules"), (False, "without its rule against collisions")):
        some = [row for row in found if row["rules"] is rules]
        verdicts = Counter(row["verdict"] for row in some)
        wrong = Counter(row["verdict"] for row in some if outcome(row) == "FALSE")
        counts = [verdicts[verdict] for verdict in ("certified", "refuted", "not certifiable")]
        lines.append(
            f"| {name} | {len(some)} | {' | '.join(map(str, counts))} | {wrong['certified']} | {wrong['refuted']} |"
        )
    refuted = [row for row in found if row["verdict"] == "refuted" and row["dense"] is not None]
    known = [row for row in refuted if row["known first"]]
    late = [row for row in known if row["angle"] is None or abs(row["angle"] - row["dense"]) > _CLOSE]
    no_motion = [row for row in found if not row["motion"]]
    verdicts = Counter(row["verdict"] for row in no_motion)
    lines += [
        "",
        f"Of {len(refuted)} refutations {len(known)} name the angle of the first contact, {len(late)} of them more "
        f"than {_CLOSE}° off; the others say that it may be earlier.",
        f"Of {len(no_motion)} patterns the game's own motion does not exist between two of its angles: "
        + (", ".join(f"{count} {verdict}" for verdict, count in verdicts.items()) or "none")
        + ".",
        "",
        "## Files made to be certified falsely",
        "",
        "| kind | files | certified | refuted | not certifiable | wrong |",
        "|---|---|---|---|---|---|",
    ]
    for attack in ATTACKS:
        some = [row for row in rows if row["kind"] == attack.__name__]
        if some:
            verdicts = Counter(row["verdict"] for row in some)
            counts = [verdicts[verdict] for verdict in ("certified", "refuted", "not certifiable")]
            wrong_ones = sum((row["verdict"] == "certified") != row["honest"] for row in some)
            honest = " (honest)" if some[0]["honest"] else ""
            name = attack.__name__.replace("_", " ") + honest
            lines.append(f"| {name} | {len(some)} | {' | '.join(map(str, counts))} | {wrong_ones} |")
    seconds = sorted(row["seconds"] for row in rows)
    lines += [
        "",
        f"Median {statistics.median(seconds):.2f} s, 99 of 100 below {seconds[int(0.99 * (len(seconds) - 1))]:.1f} s, "
        f"the longest {seconds[-1]:.1f} s.",
    ]
    return lines


def speed() -> list[str]:
    """How long the published designs take, after one to warm up."""
    lines = ["", "## Published designs", "", "| design | panels | verdict | seconds |", "|---|---|---|---|"]
    files = sorted(PAPER.glob("*.fold"))
    origami_lab.verify(files[0])
    taken = []
    for file in files:
        start = time.process_time()
        certificate = origami_lab.verify(file)
        taken.append(time.process_time() - start)
        panels = certificate["sheet valid"].numbers["panels"]
        lines.append(f"| {file.stem} | {panels} | {certificate.verdict} | {taken[-1]:.2f} |")
    return [*lines, "", f"Median {statistics.median(taken):.2f} s."]


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--patterns", type=int, default=2000)
    parser.add_argument("--attacks", type=int, default=200, help="files of each kind")
    parser.add_argument("--rows", type=Path, default=Path("certificates.jsonl"), help="results so far, a line each")
    parser.add_argument("--out", type=Path, help="write the report there, too")
    options = parser.parse_args()
    rows: list[Row] = []
    if options.rows.exists():
        rows = [json.loads(line) for line in options.rows.read_text(encoding="utf-8").splitlines()]
    done = {(row["kind"], row["seed"]) for row in rows}
    with tempfile.TemporaryDirectory() as folder, options.rows.open("a", encoding="utf-8") as file:
        for name, make in work(options.patterns, options.attacks, Path(folder)):
            if name not in done:
                rows.append(make())
                file.write(json.dumps(rows[-1]) + "\n")
                file.flush()
    lines = report(rows) + speed()
    write_report(lines, options.out)
    print("\n".join(lines))


if __name__ == "__main__":
    main()
