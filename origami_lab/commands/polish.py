"""`origami-lab polish`: a finished design moved off the grid, nearer to its target."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

from origami_lab.commands import number, whole
from origami_lab.commands.rework_parser import rework, rework_parser


def main(arguments: Sequence[str]) -> int:
    """Polish the designs, name what came of each and its FOLD file on stdout; returns the exit code."""
    parser = rework_parser(
        "polish",
        "Move the vertices, the start pattern's size and the driving angle of a design off the grid so that it fits its"
        " target better. The results stand beside it: polished.fold, polished.json and so on.",
        best=3,
    )
    parser.add_argument("--steps", metavar="N", help="designs to try for each (default: 60000, about half a minute)")
    parser.add_argument("--seed", metavar="N", help="of the random numbers (default: 0)")
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
    given = parser.parse_args(arguments)
    from origami_lab.experiment.reworked_designs import PolishOptions, Reworked, polish_saved
    from origami_lab.polish.polisher import Polished

    asked: dict[str, Any] = {name: whole(f"--{name}", getattr(given, name)) for name in ("steps", "seed", "finer")}
    asked |= {name: number(f"--{name}", getattr(given, name)) for name in ("seconds", "simplify")}
    options = PolishOptions(**{name: value for name, value in asked.items() if value is not None})

    def line(done: Reworked[Polished]) -> str:
        result = done.made
        early = "" if result.whole else ", ended by the time limit"
        return (
            f"return {result.returns_before['return']:z.4f} → {result.returns['return']:z.4f},"
            f" driving angle {result.driving_angle_before:.2f}° → {result.driving_angle:.2f}°,"
            f" {result.certificate.verdict}, {result.steps} steps, {result.seconds:.0f} s{early}"
        )

    return rework(given, lambda file, pictures: polish_saved(file, given.settings, options, pictures=pictures), line)
