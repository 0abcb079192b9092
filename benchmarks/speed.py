"""How fast is it? ``python -m benchmarks.speed [--seconds 3] [--out benchmarks/speed.md]``

All figures of a run are taken in that run, on one core, and stand beside a fixed calibration kernel, because machines
are noisy: compare ratios, not seconds. Shares are found by leaving work out: the same recorded episodes are replayed
without masks, then without collisions.
"""

from __future__ import annotations

import argparse
import os
import platform
import resource
import subprocess
import sys
import tempfile
import time
from collections.abc import Callable
from functools import partial
from pathlib import Path

os.environ.setdefault("OMP_NUM_THREADS", "1")

import numpy as np

from benchmarks import write_report
from origami_lab.game.folded_sheet import FoldedSheet
from origami_lab.game.game import Game
from origami_lab.game.kernels.play import (
    clear_state,
    copy_to,
    legal_of,
    play_action,
    play_uniform,
    replay_unchecked,
    settle,
    step,
)
from origami_lab.game.kernels.state import RUNNING, SELECTION, TERMINATED, THIRD, States, clear
from origami_lab.game.kernels.undo import note_dtype, step_back, step_noted
from origami_lab.game.start_patterns import Square
from origami_lab.jit import kernel
from origami_lab.objectives.shape import ShapeObjective
from origami_lab.search.branch_and_bound import BreadthFirstSearch, DepthFirstSearch
from origami_lab.search.evolution import EvolutionarySearch
from origami_lab.search.mcts import MonteCarloTreeSearch
from origami_lab.search.problem import Problem, Searcher
from origami_lab.search.random_search import RandomSearch
from origami_lab.targets.solids import bowl


@kernel
def calibration(n: int) -> float:
    """A fixed piece of floating-point and memory work."""
    table = np.empty(4096)
    total = 0.0
    for i in range(n):
        x = 0.5 + (i % 977) * 1e-3
        table[i & 4095] = np.sqrt(x) + x * x
        total += table[(i * 31) & 4095]
    return total


@kernel
def masks_only(states: States, rules: States, actions: np.ndarray, legal: np.ndarray) -> int:
    """Replay with the legal actions of every state on the way."""
    from_ = 0
    s, r = states[0], rules[0]
    clear(s)
    for action in actions:
        from_ += settle(s, r, legal)
        play_action(s, r, action)
    return from_


@kernel
def there_and_back(states: States, i: int, rules: States, action: int, notes: States, legal: np.ndarray) -> None:
    """Play an action and take it back."""
    step_noted(states, i, rules, action, notes, 0, legal)
    step_back(states, i, notes, 0)


def best_of(function: Callable[[], object], repeats: int = 3) -> float:
    """Seconds of the fastest of a few calls."""
    times = []
    for _ in range(repeats):
        start = time.perf_counter()
        function()
        times.append(time.perf_counter() - start)
    return min(times)


def bowl_game(size: int = 25) -> Game:
    return Game(size, "xyd", Square("choose"), max_crease_length=2.9)


def record(game: Game, interactions: int) -> tuple[list[np.ndarray], int]:
    """Random episodes as action logs, and how many extensions they complete."""
    rng, states = np.random.default_rng(0), game.new_states()
    legal = np.empty(game.rules.max_legal, dtype=np.int32)
    logs, extensions, played = [], 0, 0
    while played < interactions:
        replay_unchecked(states, 0, game.rules.record, np.empty(0, dtype=np.int32))
        n = play_uniform(states, 0, game.rules.record, rng.random(4096), 0, 4096, legal)
        logs.append(states["actions"][0][:n].copy())
        extensions += int(states["n_extensions"][0])
        played += n
    return logs, extensions


def shares(interactions: int) -> list[str]:
    """Where the time of random play on the bowl goes."""
    game = bowl_game()
    free = game.rules.record.copy()
    free["collisions"] = 0
    logs, extensions = record(game, interactions)
    played = sum(len(log) for log in logs)
    states, legal = game.new_states(), np.empty(game.rules.max_legal, dtype=np.int32)
    problem = Problem(game, ShapeObjective(bowl()), played)
    evaluator, memos = problem.evaluator, problem.evaluator.new_memos(1)

    def replay(rules: States) -> None:
        for log in logs:
            replay_unchecked(states, 0, rules, log)

    def with_masks() -> None:
        for log in logs:
            masks_only(states, game.rules.record, log, legal)

    def with_objective() -> None:
        for log in logs:
            replay_unchecked(states, 0, game.rules.record, log)
            if not game.is_penalised(states):
                evaluator.clear(memos, 0)
                evaluator.score(states, memos, 0)

    replay(free)
    with_masks()
    with_objective()
    bare, full = best_of(lambda: replay(free)), best_of(lambda: replay(game.rules.record))
    masks, objective = best_of(with_masks), best_of(with_objective)
    parts = {
        "masks": masks - full,
        "kinematics and bookkeeping": bare,
        "collisions": full - bare,
        "objective, every episode scored in full": objective - full,
    }
    total = sum(parts.values())
    lines = [
        f"Random play on the bowl: {played:,} interactions, {extensions:,} extensions completed, {len(logs):,} games.",
        "",
        "| phase | µs per interaction | µs per completed extension | share |",
        "|---|---:|---:|---:|",
    ]
    for name, seconds in parts.items():
        lines.append(
            f"| {name} | {seconds / played * 1e6:.2f} | {seconds / extensions * 1e6:.2f} | {seconds / total:.0%} |"
        )
    lines.append(f"| all | {total / played * 1e6:.2f} | {total / extensions * 1e6:.2f} | 100% |")
    return lines


def rates(seconds: float, calibrated: float) -> list[str]:
    """Interactions per second of each searcher on the bowl."""
    searchers: dict[str, Searcher] = {
        "rdm": RandomSearch(),
        "dfts": DepthFirstSearch(),
        "bfts": BreadthFirstSearch(),
        "bfts, 10 restarts": BreadthFirstSearch(restarts=10),
        "evo": EvolutionarySearch(),
        "mcts": MonteCarloTreeSearch(),
    }
    lines = [
        "| searcher | interactions per second | of rdm | per unit of calibration | best return | its vertices |",
        "|---|---:|---:|---:|---:|---:|",
    ]
    rdm = 0.0
    for name, searcher in searchers.items():
        budget = 20_000
        searcher.search(Problem(bowl_game(), ShapeObjective(bowl()), 2000), np.random.default_rng(0))
        while True:
            problem = Problem(bowl_game(), ShapeObjective(bowl()), budget)
            start = time.perf_counter()
            searcher.search(problem, np.random.default_rng(0))
            taken = time.perf_counter() - start
            if taken > seconds:
                break
            budget = int(budget * max(2.0, 1.2 * seconds / taken))
        rate = budget / taken
        rdm = rdm or rate
        outcome = problem.outcome()
        size = len(problem.game.design(outcome.actions).vertices)
        lines.append(
            f"| {name} | {rate:,.0f} | {rate / rdm:.2f} | {rate * calibrated:,.0f} | {outcome.value:.3f} | {size} |"
        )
    return lines


def growth(interactions: int) -> list[str]:
    """Cost of random play against board size, and of one extension against the size of the pattern."""
    lines = ["| board | interactions per second (random play) |", "|---:|---:|"]
    for size in (9, 13, 25, 37, 49):
        game = bowl_game(size)
        logs, _ = record(game, 2000)
        start = time.perf_counter()
        logs, _ = record(game, interactions)
        lines.append(f"| {size} | {sum(map(len, logs)) / (time.perf_counter() - start):,.0f} |")
    lines += [
        "",
        "| representatives | images | completing an extension and taking it back, µs | legal actions, µs | copy, µs |",
        "|---:|---:|---:|---:|---:|",
    ]
    game, rng = bowl_game(49), np.random.default_rng(0)
    gentle = game.rules.record.copy()
    gentle["angles"][0] = game.angles / 20  # small angles, so that all ten stay reachable however large the pattern
    states, legal = game.new_states(3), np.empty(game.rules.max_legal, dtype=np.int32)
    notes = np.empty(1, dtype=note_dtype(len(game.angles)))

    def repeated(function: Callable[[], object], count: int) -> float:
        return best_of(lambda: [function() for _ in range(count)]) / count * 1e6

    for wanted in (8, 16, 32, 64, 128):
        grow(game, gentle, states, rng, wanted)
        log = states["actions"][0][: int(states["n_actions"][0])].copy()
        masking = repeated(partial(legal_of, states, 0, gentle, legal), 300)
        copying = repeated(partial(copy_to, states, 1, states, 0), 300)
        replay_unchecked(states, 2, gentle, log[:-1])
        extending = repeated(partial(there_and_back, states, 2, gentle, int(log[-1]), notes, legal), 300)
        n, images = int(states["n_vertices"][0]), len(FoldedSheet(states, 0, gentle).flat)
        lines.append(f"| {n} | {images} | {extending:.1f} | {masking:.1f} | {copying:.1f} |")
    return lines


def grow(game: Game, rules: States, states: States, rng: np.random.Generator, vertices: int) -> None:
    """Random extensions, taking back those that fail, until the sheet has that many representatives."""
    legal = np.empty(game.rules.max_legal, dtype=np.int32)
    while True:
        clear_state(states, 0)
        n = legal_of(states, 0, rules, legal)
        step(states, 0, rules, int(legal[rng.integers(n)]), legal)
        copy_to(states, 1, states, 0)
        for _ in range(20_000):
            n = legal_of(states, 0, rules, legal)
            choices = legal[:n][legal[:n] < 3 * game.rules.points]
            if len(choices):
                action = int(rng.choice(choices))
                four = states["phase"][0] == THIRD and int(states["unfinished"][0]) == 3
                step(states, 0, rules, action, legal)
            if not len(choices) or states["status"][0] not in (RUNNING, TERMINATED) or states["reach"][0] < 10:
                copy_to(states, 0, states, 1)
            elif states["phase"][0] == SELECTION:
                copy_to(states, 1, states, 0)
                if four and states["n_vertices"][0] >= vertices:
                    return


def memory(interactions: int) -> list[str]:
    """Memory of this process over long searches (the slower ones a quarter as long), at each tenth of the way."""
    marks = [f"{k}0 %" for k in range(1, 11)]
    lines = [f"| searcher | interactions | start | {' | '.join(marks)} |", "|---|---:|" + "---:|" * 11]
    searches: dict[str, tuple[Searcher, int]] = {
        "rdm": (RandomSearch(), interactions),
        "dfts": (DepthFirstSearch(), interactions // 4),
        "bfts": (BreadthFirstSearch(), interactions // 4),
    }
    for name, (searcher, budget) in searches.items():
        seen = [resident()]

        def watch(problem: Problem, seen: list[float] = seen) -> None:
            while problem.interactions >= len(seen) * problem.budget / 10:
                seen.append(resident())

        problem = Problem(bowl_game(), ShapeObjective(bowl()), budget, on_progress=watch)
        searcher.search(problem, np.random.default_rng(0))
        seen += [resident()] * (11 - len(seen))
        lines.append(f"| {name} | {budget:,} | " + " | ".join(f"{value:.0f}" for value in seen) + " |")
    return lines


def resident() -> float:
    """Memory that this process holds now, in MB."""
    pages = int(Path("/proc/self/statm").read_text().split()[1])
    return pages * resource.getpagesize() / 2**20


def start_up() -> list[str]:
    """Seconds from the command to its first interaction and to its end, with a cold and a warm kernel cache."""
    settings = "target=bowl search=rdm search._target_=stamp.StampedSearch budget=10 seed=0 workers=1 tracking=none"
    command = [sys.executable, "-m", "origami_lab", *settings.split()]
    lines = ["| kernel cache | to the first interaction, s | whole command with pictures, s |", "|---|---:|---:|"]
    with tempfile.TemporaryDirectory() as folder:
        stamp = Path(folder) / "stamp"
        (Path(folder) / "stamp.py").write_bytes((Path(__file__).parent / "stamp.py").read_bytes())
        env = dict(os.environ, NUMBA_CACHE_DIR=str(Path(folder) / "cache"), ORIGAMI_LAB_STAMP=str(stamp))
        for name in ("cold", "warm", "warm again"):
            start = time.time()
            subprocess.run(command, cwd=folder, env=env, check=True, capture_output=True)
            lines.append(f"| {name} | {float(stamp.read_text()) - start:.1f} | {time.time() - start:.1f} |")
    return lines


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--seconds", type=float, default=3.0, help="per searcher")
    parser.add_argument("--long", type=int, default=10_000_000, help="interactions of the searches for memory")
    parser.add_argument("--out", type=Path, help="write the report there, too")
    options = parser.parse_args()
    calibration(1000)
    calibrated = best_of(lambda: calibration(20_000_000), 5)
    lines = [
        "# Speed",
        "",
        f"Python {platform.python_version()}, NumPy {np.__version__}, {os.cpu_count()} cores, one used; "
        f"load average before: {os.getloadavg()[0]:.2f}. Calibration kernel: {calibrated:.3f} s.",
        "",
        "## Searchers on the bowl (25×25, xyd, crease length 2.9, source action, dense certificates)",
        "",
        *rates(options.seconds, calibrated),
        "",
        "## Where the time goes",
        "",
        *shares(100_000),
        "",
        "## Growth",
        "",
        *growth(20_000),
        "",
        "## Start-up",
        "",
        *start_up(),
        "",
        f"## Memory over {options.long:,} interactions, MB",
        "",
        *memory(options.long),
        "",
        f"Peak memory of this process: {resource.getrusage(resource.RUSAGE_SELF).ru_maxrss / 1024:.0f} MB.",
        "",
    ]
    print("\n".join(lines))
    write_report(lines, options.out)


if __name__ == "__main__":
    main()
