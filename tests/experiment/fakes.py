"""Parts that a user might bring: named by ``_target_`` in the tests' configurations."""

from __future__ import annotations

import ctypes
import math
import os
import shutil
from pathlib import Path
from typing import ClassVar, TextIO

import numpy as np

from origami_lab.search.dense_check import certified_reach
from origami_lab.search.problem import Problem
from origami_lab.search.random_stream import Draws


class Height:
    """The height of the highest folded point."""

    def score(self, sheet: object) -> float:
        points = sheet.points[sheet.reach - 1]  # type: ignore[attr-defined]
        return float(points[:, 2].max())


class Beacon(Height):
    """Creates a file when it is first asked, so that a test knows that a trial is under way."""

    def __init__(self, file: str) -> None:
        self.file = Path(file)

    def score(self, sheet: object) -> float:
        self.file.touch()
        return super().score(sheet)


class Noting(Height):
    """Notes what it is asked in files that nothing closes before the process ends."""

    files: ClassVar[list[TextIO]] = []

    def __init__(self, notes: str) -> None:
        self.files.append(Path(notes).open("a", encoding="utf-8"))  # noqa: SIM115

    def score(self, sheet: object) -> float:
        self.files[-1].write("asked\n")
        return super().score(sheet)


class Broken(Height):
    """Fails in one trial after the other, each time in another way, and then no more.

    Parameters
    ----------
    ways
        Names of the methods below.
    notes
        An existing folder, to note what was done.
    """

    def __init__(self, ways: list[str], notes: str) -> None:
        self.ways, self.notes = ways, Path(notes)

    def score(self, sheet: object) -> float:
        for way in self.ways:
            note = self.notes / way
            if not note.exists():
                note.touch()
                getattr(self, way)()
                return math.nan
        return super().score(sheet)

    def raises(self) -> None:
        raise RuntimeError("the kettle is empty\nsecond line")

    def gives_nan(self) -> None:
        pass

    def dies(self) -> None:
        os._exit(3)

    def leaves(self) -> None:
        raise SystemExit(4)

    def hangs_in_c(self) -> None:
        ctypes.PyDLL(None).sleep(1000)


class Vandal(Height):
    """Removes the folder it is told."""

    def __init__(self, folder: str) -> None:
        self.folder = Path(folder)

    def score(self, sheet: object) -> float:
        shutil.rmtree(self.folder, ignore_errors=True)
        return super().score(sheet)


class NoObjective:
    """Has no score."""


class Endless:
    """Plays at random and never asks whether it is done."""

    def search(self, problem: Problem, rng: np.random.Generator) -> None:
        positions = problem.new_positions(1)
        while True:
            legal = problem.clear(positions, 0)
            while len(legal):
                legal = problem.play(positions, 0, int(rng.choice(legal)))
            problem.finish(positions, 0)


class Careless:
    """Plays at random, and keeps one design that folds, then only some that do so by passing through themselves.

    Parameters
    ----------
    skip
        So many random numbers are thrown away first.
    """

    def __init__(self, skip: int = 0) -> None:
        self.skip = skip

    def search(self, problem: Problem, rng: np.random.Generator) -> None:
        rng.random(self.skip)
        problem.certify = False
        positions = problem.new_positions(1)
        wanted = 1
        while True:
            legal = problem.clear(positions, 0)
            while len(legal):
                legal = problem.play(positions, 0, int(rng.choice(legal)))
            actions = problem.game.finished_actions(positions.states, 0)
            reach = int(positions.states["reach"][0])
            free = certified_reach(problem.game, actions, reach) == reach
            if free == (wanted > 0):
                problem.finish(positions, 0)
                wanted -= free


class NoSearcher:
    """Has no search."""


class Counting:
    """Plays at random and counts its searches over the stages of a run."""

    def __init__(self) -> None:
        self.searches = 0

    def search(self, problem: Problem, rng: np.random.Generator) -> None:
        self.searches += 1
        draws, positions = Draws(rng), problem.new_positions(1)
        while not problem.done:
            problem.clear(positions, 0)
            if problem.play_uniform(positions, 0, draws):
                problem.finish(positions, 0)

    def save(self) -> dict[str, object]:
        return {"searches": [self.searches]}

    def load(self, state: dict[str, np.ndarray]) -> None:
        self.searches = int(state["searches"][0])
