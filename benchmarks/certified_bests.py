"""Is the best design of every trial certified, or labelled? ``python -m benchmarks.certified_bests [--seeds 0..8]``

The paper's eight tasks by six searchers, as a user's command runs them with all files. A certified best is looked at
densely, too: a thousand states from the flat sheet to the best one by the game's own closed forms and its triangle
test. A crossing there, a refuted best, or one without a label, is wrong. The runs stay in ``--runs``, so that what was
interrupted goes on.
"""

from __future__ import annotations

import argparse
import math
import os
from collections import Counter
from pathlib import Path

os.environ.setdefault("OMP_NUM_THREADS", "1")

import origami_lab
from benchmarks import write_report
from origami_lab.experiment.saved_design import read_saved
from origami_lab.runs.trial_row import read_trials
from tests.verification.dense import RandomPattern, first_crossing

TASKS = ("bowl", "cube", "pyramid", "face", "shelf", "chair", "table", "bucket")
SEARCHERS = ("rdm", "dfts", "bfts", "mcts", "evo", "lns")
LABELS = ("certified", "not certifiable")
VERDICTS = (*LABELS, "refuted", "no design", "no label")


def crosses(trial: Path) -> bool:
    """Whether a dense look sees the best design of a trial cross itself on its way."""
    saved = read_saved(trial / "best.fold")
    return not math.isinf(first_crossing(RandomPattern(saved.game, saved.actions, saved.angle + 1)))


def verdicts(task: str, searcher: str, budget: int, seeds: str, runs: Path) -> Counter[str]:
    """How many trials of a cell ended how; under "wrong" those that a certificate is wrong about."""
    folder = runs / f"{task}-{searcher}"
    settings = [f"+experiment=paper/{task}", f"search={searcher}", f"budget={budget}", f"seed={seeds}"]
    origami_lab.run([*settings, f"output={folder}", "resume=true", "tracking=none", "verbosity=quiet"])
    found: Counter[str] = Counter()
    for row in read_trials(folder / "trials.csv"):
        if row.return_ is None:
            found["no design"] += 1
            continue
        found[row.certificate or "no label"] += 1
        found["wrong"] += row.certificate not in LABELS
        if row.certificate == "certified":
            found["wrong"] += crosses(folder / f"seed={row.seed}")
    return found


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--budget", type=int, default=50_000)
    parser.add_argument("--seeds", default="0..8")
    parser.add_argument("--runs", type=Path, default=Path("certified_bests"), help="where the runs are")
    parser.add_argument("--out", type=Path, help="write the report there")
    options = parser.parse_args()
    cells = {
        (task, searcher): verdicts(task, searcher, options.budget, options.seeds, options.runs)
        for task in TASKS
        for searcher in SEARCHERS
    }
    total = sum(cells.values(), Counter[str]())
    lines = [
        "# Best designs and their certificates",
        "",
        f"`python -m benchmarks.certified_bests --budget {options.budget} --seeds {options.seeds}`: of each cell "
        "how many bests are certified; after a slash those that are labelled not certifiable.",
        "",
        f"| | {' | '.join(SEARCHERS)} |",
        "|---" * (len(SEARCHERS) + 1) + "|",
    ]
    for task in TASKS:
        counts = [cells[task, searcher] for searcher in SEARCHERS]
        shown = [f"{c['certified']}" + (f" / {c['not certifiable']}" if c["not certifiable"] else "") for c in counts]
        lines.append(f"| {task} | {' | '.join(shown)} |")
    said = ", ".join(f"{total[verdict]} {verdict}" for verdict in VERDICTS)
    lines += ["", f"Of {sum(total[verdict] for verdict in VERDICTS)} trials: {said}; {total['wrong']} wrong."]
    write_report(lines, options.out)
    print("\n".join(lines))


if __name__ == "__main__":
    main()
