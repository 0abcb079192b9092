"""What `polish` and `simplify` have in common: which designs they are given, and how they say what came of each."""

from __future__ import annotations

import argparse
import sys
from collections.abc import Callable
from pathlib import Path
from typing import TYPE_CHECKING, TypeVar

from origami_lab.commands import whole
from origami_lab.commands.parser import Parser

if TYPE_CHECKING:
    from origami_lab.experiment.reworked_designs import Reworked
    from origami_lab.polish import Polished, Simplified

    Made = TypeVar("Made", Polished, Simplified)


def rework_parser(command: str, description: str, best: int) -> argparse.ArgumentParser:
    """A parser that knows the arguments of both commands; ``best`` is how many designs of a run they take."""
    parser = Parser(f"origami-lab {command}", description=description)
    parser.add_argument(
        "path", metavar="PATH", help="the folder of a trial (seed=N) or of a run, or a FOLD file of ours"
    )
    parser.add_argument(
        "settings", nargs="*", metavar="KEY=VALUE", help="for a FOLD file in no run folder: its game, e.g. target=bowl"
    )
    parser.add_argument(
        "--best", metavar="K", default=str(best), help=f"how many of a run's designs, the best first (default: {best})"
    )
    parser.add_argument("--no-pictures", action="store_true", help="write no pictures and no viewer")
    return parser


def rework(
    given: argparse.Namespace, make: Callable[[Path, bool], Reworked[Made]], line: Callable[[Reworked[Made]], str]
) -> int:
    """Make something of each of the designs that were named, and print a line on it; returns the exit code."""
    from origami_lab.experiment.saved_design import saved_designs

    best = whole("--best", given.best)
    assert best is not None
    for file in saved_designs(Path(given.path), given.settings, best):
        done = make(file, not given.no_pictures)
        for warning in done.warnings:
            print(f"note: {warning}", file=sys.stderr)
        print(f"{done.files[0]}: {line(done)}", flush=True)
    return 0
