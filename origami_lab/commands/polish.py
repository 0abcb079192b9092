"""`origami-lab polish`: a finished design moved off the grid, nearer to its target."""

from __future__ import annotations

import argparse
import sys
from collections.abc import Sequence
from pathlib import Path

from origami_lab.commands import number
from origami_lab.errors import InputError


def main(arguments: Sequence[str]) -> int:
    """Polish the designs, name what came of each and its FOLD file on stdout; returns the exit code."""
    parser = argparse.ArgumentParser(
        "origami-lab polish",
        description="Move the vertices, the start pattern's size and the driving angle of a design off the grid so that"
        " it fits its target better. The results stand beside it: polished.fold, polished.json and so on.",
    )
    parser.add_argument(
        "path", metavar="PATH", help="the folder of a trial (seed=N) or of a run, or a FOLD file of ours"
    )
    parser.add_argument(
        "settings", nargs="*", metavar="KEY=VALUE", help="for a FOLD file in no run folder: its game, e.g. target=bowl"
    )
    parser.add_argument(
        "--best", metavar="K", default="3", help="how many of a run's designs, the best first (default: 3)"
    )
    parser.add_argument("--steps", metavar="N", help="designs to try for each (default: 60000, about half a minute)")
    parser.add_argument("--seed", metavar="N", default="0", help="of the random numbers (default: 0)")
    parser.add_argument("--seconds", metavar="S", help="a time limit for each, at which the best so far is kept")
    parser.add_argument(
        "--finer", metavar="N", help="parts of a board cell that coordinates are multiples of (default: 512)"
    )
    parser.add_argument(
        "--simplify",
        metavar="CELLS",
        nargs="?",
        const="0.005",
        help="at the end take out what costs no more than this in all (default: 0.005), and creases that stay flat",
    )
    parser.add_argument("--no-pictures", action="store_true", help="write no pictures and no viewer")
    options = parser.parse_args(arguments)
    from origami_lab.experiment.polished_files import polish_trial
    from origami_lab.experiment.saved_design import saved_designs
    from origami_lab.polish.polisher import FINER, STEPS

    steps = STEPS if options.steps is None else whole("--steps", options.steps)
    finer = FINER if options.finer is None else whole("--finer", options.finer)
    simplify = number("--simplify", options.simplify)
    seed, seconds = whole("--seed", options.seed), number("--seconds", options.seconds)
    for file in saved_designs(Path(options.path), options.settings, whole("--best", options.best)):
        done = polish_trial(
            file,
            options.settings,
            steps=steps,
            seed=seed,
            seconds=seconds,
            finer=finer,
            simplify=simplify,
            pictures=not options.no_pictures,
        )
        for warning in done.warnings:
            print(f"note: {warning}", file=sys.stderr)
        result = done.polished
        early = "" if result.whole else ", ended by the time limit"
        print(
            f"{done.files[0]}: return {result.returns_before['return']:.4f} → {result.returns['return']:.4f},"
            f" driving angle {result.driving_angle_before:.2f}° → {result.driving_angle:.2f}°,"
            f" {result.certificate.verdict}, {result.steps} steps, {result.seconds:.0f} s{early}",
            flush=True,
        )
    return 0


def whole(option: str, text: str) -> int:
    """What was given for an option as a whole number; raises InputError if it is none."""
    value = number(option, text)
    if value is None or value != value or abs(value) == float("inf") or value != int(value):
        raise InputError(option, text, "must be a whole number")
    return int(value)
