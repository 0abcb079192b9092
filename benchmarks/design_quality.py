"""How good the designs of a searcher are: one command a row of the table.

    python -m benchmarks.design_quality bowl lns seeds=100..109 search.look=false
    python -m benchmarks.design_quality saddle lns distance=surface
    python -m benchmarks.design_quality --table

The first words are the task and the searcher; then ``seeds=A..B``, ``budget=N``, ``distance=NAME`` and any of the
searcher's own numbers. Every trial is a line of ``benchmarks/design_quality.jsonl`` (``--log FILE``), written as soon
as it ends, and a trial that is there already is not repeated. ``--table`` prints mean ± sample standard deviation and
the best for each row of the log. The best return of a trial is measured by vertices and by surface, whatever it was
led by. Trials end early at the known optimum of the cube and the pyramid, where the interactions count.
"""

from __future__ import annotations

import argparse
import json
import os
import statistics
import sys
import time
from collections import defaultdict
from collections.abc import Callable
from pathlib import Path
from typing import Any

os.environ.setdefault("OMP_NUM_THREADS", "1")

import numpy as np

from benchmarks import height_fields
from origami_lab.game.game import Game
from origami_lab.game.start_from_moves import FromFile
from origami_lab.game.start_patterns import Crease, Square
from origami_lab.objectives.chair import ChairObjective
from origami_lab.objectives.objective import report
from origami_lab.objectives.shape import ShapeObjective
from origami_lab.objectives.shelf import ShelfObjective
from origami_lab.search.branch_and_bound import BreadthFirstSearch, DepthFirstSearch
from origami_lab.search.evolution import EvolutionarySearch
from origami_lab.search.mcts import MonteCarloTreeSearch
from origami_lab.search.neighbourhood.search import NeighbourhoodSearch
from origami_lab.search.problem import Problem, Searcher
from origami_lab.search.random_search import RandomSearch
from origami_lab.targets.face_surface import face
from origami_lab.targets.solids import bowl, cube, pyramid
from origami_lab.targets.target import Target

LOG = Path(__file__).with_name("design_quality.jsonl")

SEARCHERS: dict[str, Callable[..., Searcher]] = {
    "rdm": RandomSearch,
    "dfts": DepthFirstSearch,
    "bfts": BreadthFirstSearch,
    "mcts": MonteCarloTreeSearch,
    "evo": EvolutionarySearch,
    "lns": NeighbourhoodSearch,
}


def _shape(target: Callable[[], Target], game: Callable[[], Game]) -> Callable[[str], tuple[Game, Any]]:
    return lambda distance: (game(), ShapeObjective(target(), distance))  # type: ignore[arg-type]


def _curved(symmetry: str) -> Callable[[], Game]:
    return lambda: Game(25, symmetry, Square("choose"), max_crease_length=2.9)


TASKS: dict[str, Callable[[str], tuple[Game, Any]]] = {
    "bowl": _shape(bowl, _curved("xyd")),
    "face": _shape(lambda: face(spacing=0.25, align_z=True), lambda: Game(25, "y", Crease(0), max_crease_length=2.9)),
    "vault": _shape(height_fields.vault, _curved("y")),
    "dome": _shape(height_fields.dome, _curved("y")),
    "saddle": _shape(height_fields.saddle, _curved("xy")),
    "pyramid": _shape(pyramid, lambda: Game(9, "xy", Square(1))),
    "cube": _shape(cube, lambda: Game(9, "xy", Square(1), max_crease_length=2)),
    "chair": lambda _: (
        Game(13, "y", FromFile("chair"), source_action=False, driving_angle_fixed="start"),
        ChairObjective(),
    ),
    "shelf": lambda _: (Game(13, "xy", Square("choose"), source_action=False), ShelfObjective()),
    "wave": _shape(height_fields.wave, _curved("y")),
    "funnel": _shape(height_fields.funnel, _curved("xyd")),
    "leaf": _shape(height_fields.leaf, _curved("y")),
    "ripple": _shape(height_fields.ripple, _curved("xyd")),
    "scarf": _shape(height_fields.scarf, _curved("xy")),
    "canopy": _shape(height_fields.canopy, _curved("y")),
}
OPTIMA = {"cube": -0.00226, "pyramid": -0.08}
"""Returns at which a trial ends."""


def trial(task: str, searcher: str, distance: str, budget: int, seed: int, numbers: dict[str, Any]) -> dict[str, Any]:
    """One trial as a line of the log."""
    game, objective = TASKS[task](distance)
    enough = OPTIMA.get(task, np.inf)
    problem = Problem(game, objective, budget, should_stop=lambda: problem.best_value >= enough)
    begun = time.process_time()
    SEARCHERS[searcher](**numbers).search(problem, np.random.default_rng(np.random.SeedSequence(seed)))
    seconds = time.process_time() - begun
    found = problem.outcome()
    return {
        "task": task,
        "searcher": searcher,
        "distance": distance,
        "budget": budget,
        "numbers": numbers,
        "seed": seed,
        "value": found.value,
        "angle": found.angle,
        "interactions": found.interactions,
        "to_best": found.interactions_to_best,
        "places_evaluated": found.places_evaluated,
        "rejected": found.rejected,
        "seconds": round(seconds, 2),
        "actions": list(found.actions),
        **report(objective, game, found.actions, found.angle),
    }


def key_of(row: dict[str, Any]) -> tuple[str, ...]:
    """What makes a row of the table."""
    numbers = " ".join(f"{name}={value}" for name, value in sorted(row["numbers"].items()))
    return row["task"], row["searcher"], row["distance"], str(row["budget"]), numbers


def read_log(log: Path) -> list[dict[str, Any]]:
    return [json.loads(line) for line in log.read_text(encoding="utf-8").splitlines()] if log.exists() else []


def table(rows: list[dict[str, Any]]) -> list[str]:
    """Markdown: a row for each task, searcher and its numbers."""
    groups: dict[tuple[str, ...], list[dict[str, Any]]] = defaultdict(list)
    for row in rows:
        groups[key_of(row)].append(row)
    names = ("task", "searcher", "led by", "budget", "numbers", "seeds", "return", "best", "by vertices", "by surface")
    lines = [f"| {' | '.join((*names, 'median to best', 'places evaluated', 'interactions/s'))} |", "|---" * 13 + "|"]
    for key, group in sorted(groups.items()):
        group = list({row["seed"]: row for row in group}.values())
        values = [row["value"] for row in group]
        cells = [
            *key,
            str(len(group)),
            spread(values),
            f"{max(values):.4f}",
            *(spread([row[name] for row in group if name in row]) for name in ("return_vertex", "return_surface")),
            f"{statistics.median(row['to_best'] for row in group):,.0f}",
            f"{statistics.mean(row['places_evaluated'] for row in group):,.0f}",
            f"{sum(row['interactions'] for row in group) / max(sum(row['seconds'] for row in group), 1e-9):,.0f}",
        ]
        lines.append(f"| {' | '.join(cells)} |")
    return lines


def spread(values: list[float]) -> str:
    """Mean ± sample standard deviation."""
    if not values:
        return "–"
    if len(values) == 1:
        return f"{values[0]:.4f}"
    return f"{statistics.mean(values):.4f} ± {statistics.stdev(values):.4f}"


def value_of(text: str) -> Any:
    try:
        return json.loads(text)
    except json.JSONDecodeError:
        return text


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("words", nargs="*", help="task, searcher, settings")
    parser.add_argument("--log", type=Path, default=LOG)
    parser.add_argument("--table", action="store_true", help="print the table of the log")
    options = parser.parse_args()
    if options.words:
        task, searcher, *settings = options.words
        given = {name.removeprefix("search."): value for name, value in (word.split("=", 1) for word in settings)}
        first, _, last = given.pop("seeds", "100..109").partition("..")
        distance, budget = given.pop("distance", "vertex"), int(given.pop("budget", "500000"))
        numbers = {name: value_of(value) for name, value in given.items()}
        known = {(*key_of(row), row["seed"]) for row in read_log(options.log)}
        for seed in range(int(first), int(last or first) + 1):
            row = {"task": task, "searcher": searcher, "distance": distance, "budget": budget, "numbers": numbers}
            if (*key_of(row), seed) in known:
                continue
            found = trial(task, searcher, distance, budget, seed, numbers)
            with options.log.open("a", encoding="utf-8") as file:
                file.write(json.dumps(found) + "\n")
            sys.stdout.write(f"{task} {searcher} seed {seed}: {found['value']:.4f} in {found['seconds']} s\n")
            sys.stdout.flush()
    if options.table or not options.words:
        sys.stdout.write("\n".join(table(read_log(options.log))) + "\n")


if __name__ == "__main__":
    main()
