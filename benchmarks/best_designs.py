"""The best design of each task among runs, and its film: ``python -m benchmarks.best_designs RUNS... --out FOLDER``.

Writes ``designs/TASK-METHOD-seedN.fold`` and, where there is ffmpeg, ``films/TASK.mp4``. Of equally good designs it is
the one of the first searcher in the reports' order, then of the smallest seed. With ``--actions`` it is told folders
that are named after tasks of :mod:`benchmarks.design_quality`, and films the ``best.fold`` in each.
"""

from __future__ import annotations

import argparse
import json
import shutil
import tempfile
from collections.abc import Iterator, Sequence
from pathlib import Path

import numpy as np

from benchmarks.design_quality import TASKS
from origami_lab.drawing import TargetSurface, read_target
from origami_lab.drawing.motion_mp4 import draw_movie
from origami_lab.experiment.trial_files import MOTION_STEPS
from origami_lab.file_names import BEST, MOTION, TARGET
from origami_lab.fold_format.writer import read_fold, write_fold
from origami_lab.report.run_reader import Trial, read_runs

ALIKE = 9
"""Digits after the point in which returns are compared."""


def best_trials(folders: Sequence[Path]) -> Iterator[tuple[str, str, Trial]]:
    """Task, searcher and trial of the best design of each task; only certified ones count."""
    runs = sorted(read_runs(folders)[0], key=lambda run: run.report_order.get("method") or np.inf)
    for task in sorted({run.task for run in runs}):
        found = [
            (round(trial.value, ALIKE), run.method, trial)
            for run in runs
            if run.task == task
            for trial in sorted(run.trials, key=lambda trial: trial.seed)
            if trial.row.return_ is not None and trial.row.certificate == "certified"
        ]
        if found:
            _, method, trial = max(found, key=lambda each: each[0])  # the first of equal ones
            yield task, method, trial


def film(file: Path, motion: Path, target: TargetSurface | None) -> None:
    draw_movie(read_fold(motion), file, target)
    print(file, file.stat().st_size)


def film_actions(folders: Sequence[Path], out: Path) -> None:
    """Film designs that are named after their task, from the actions that are in their files."""
    for path in folders:
        design = json.loads((path / BEST).read_text(encoding="utf-8"))
        fold = read_fold(path / BEST)
        game, objective = TASKS[path.name]("vertex")
        actions = tuple(design["origami_lab:actions"])
        last = np.radians(float(str(fold.metadata["driving_angle"])))
        with tempfile.TemporaryDirectory() as place:
            motion = Path(place) / MOTION
            angles = np.linspace(0.0, last, MOTION_STEPS + 1)[1:]
            write_fold(motion, game.motion(actions, angles, fold.metadata))
            shape = getattr(objective, "target", None)
            target = None if shape is None else TargetSurface(shape.vertices, shape.faces)
            film(out / f"{path.name}.mp4", motion, target)


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("folders", nargs="+", type=Path)
    parser.add_argument("--actions", action="store_true")
    parser.add_argument("--out", type=Path, required=True)
    chosen = parser.parse_args()
    films, designs = chosen.out / "films", chosen.out / "designs"
    films.mkdir(parents=True, exist_ok=True)
    if chosen.actions:
        film_actions(chosen.folders, films)
        return
    designs.mkdir(exist_ok=True)
    for task, method, trial in best_trials(chosen.folders):
        shutil.copyfile(trial.folder / BEST, designs / f"{task}-{method}-seed{trial.seed}.fold")
        if shutil.which("ffmpeg"):
            target = trial.run / TARGET
            film(films / f"{task}.mp4", trial.folder / MOTION, read_target(target) if target.is_file() else None)


if __name__ == "__main__":
    main()
