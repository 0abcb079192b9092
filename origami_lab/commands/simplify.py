"""`origami-lab simplify`: a design without what it does not need."""

from __future__ import annotations

from collections.abc import Sequence

from origami_lab.commands import number
from origami_lab.commands.rework_parser import rework, rework_parser


def main(arguments: Sequence[str]) -> int:
    """Simplify the designs, say what came of each; returns the exit code."""
    parser = rework_parser(
        "simplify",
        "Take out of a design creases that never fold, and extensions whose loss costs next to nothing. The results"
        " stand beside it: simplified.fold, simplified.json and so on.",
        best=1,
    )
    parser.add_argument(
        "--tolerance",
        metavar="T",
        help="what the return may fall by in all and any point of a target get further away, in cells (default: 0.005)",
    )
    given = parser.parse_args(arguments)
    from origami_lab.experiment.reworked_designs import Reworked, simplify_saved
    from origami_lab.polish.simplifier import TOLERANCE, Simplified

    asked = number("--tolerance", given.tolerance)
    tolerance = TOLERANCE if asked is None else asked

    def line(done: Reworked[Simplified]) -> str:
        made = done.made
        before, after = made.figures_before, made.figures
        return (
            f"creases {before.creases} → {after.creases}, panels {before.panels} → {after.panels},"
            f" smallest sector {before.smallest_sector:.2f}° → {after.smallest_sector:.2f}°,"
            f" narrowest panel {before.smallest_width:.3f} → {after.smallest_width:.3f} cells,"
            f" return {made.value_before:z.4f} → {made.value:z.4f}, {made.certificate.verdict}"
        )

    return rework(
        given,
        lambda file, pictures: simplify_saved(file, given.settings, tolerance=tolerance, pictures=pictures),
        line,
    )
