"""`origami-lab simplify`: a design without what it does not need."""

from __future__ import annotations

import argparse
import sys
from collections.abc import Sequence
from pathlib import Path

from origami_lab.commands import number


def main(arguments: Sequence[str]) -> int:
    """Simplify the designs, say what came of each; returns the exit code."""
    parser = argparse.ArgumentParser(
        "origami-lab simplify",
        description="Take out of a design creases that never fold, and extensions whose loss costs next to nothing."
        " The results stand beside it: simplified.fold, simplified.json and so on.",
    )
    parser.add_argument(
        "path", metavar="PATH", help="the folder of a trial (seed=N) or of a run, or a FOLD file of ours"
    )
    parser.add_argument(
        "settings", nargs="*", metavar="KEY=VALUE", help="for a FOLD file in no run folder: its game, e.g. target=bowl"
    )
    parser.add_argument(
        "--best", metavar="K", default="1", help="how many of a run's designs, the best first (default: 1)"
    )
    parser.add_argument(
        "--tolerance", metavar="T", help="what the return may fall by in all, in cells for shapes (default: 0.005)"
    )
    parser.add_argument("--no-pictures", action="store_true", help="write no pictures and no viewer")
    options = parser.parse_args(arguments)
    from origami_lab.commands.polish import whole
    from origami_lab.experiment.saved_design import saved_designs
    from origami_lab.experiment.simplified_files import simplify_trial
    from origami_lab.polish.simplifier import TOLERANCE

    tolerance = number("--tolerance", options.tolerance)
    tolerance = TOLERANCE if tolerance is None else tolerance
    for file in saved_designs(Path(options.path), options.settings, whole("--best", options.best)):
        done = simplify_trial(file, options.settings, tolerance=tolerance, pictures=not options.no_pictures)
        for warning in done.warnings:
            print(f"note: {warning}", file=sys.stderr)
        made = done.simplified
        before, after = made.figures_before, made.figures
        print(
            f"{done.files[0]}: creases {before.creases} → {after.creases}, panels {before.panels} → {after.panels},"
            f" smallest sector {before.smallest_sector:.2f}° → {after.smallest_sector:.2f}°,"
            f" narrowest panel {before.smallest_width:.3f} → {after.smallest_width:.3f} cells,"
            f" return {made.value_before:.4f} → {made.value:.4f}, {made.certificate.verdict}",
            flush=True,
        )
    return 0
