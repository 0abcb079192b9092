"""What simplify makes of the committed designs: creases, panels and the smallest of each, before and after.

python -m benchmarks.simplified_designs --out benchmarks/simplified_designs.md
"""

from __future__ import annotations

import argparse
import math
import shutil
import tempfile
from pathlib import Path

from origami_lab.experiment.reworked_designs import simplify_saved
from origami_lab.experiment.saved_design import read_saved
from origami_lab.polish.simplifier import TOLERANCE, Simplified, distances_to, samples_of

DESIGNS = Path(__file__).parents[1] / "results" / "paper" / "designs"
HEAD = (
    "| design | return | mean distance from the target, cells | creases | panels | smallest sector"
    " | narrowest panel, cells | certificate |"
)


def row(name: str, made: Simplified, covered: tuple[float, float]) -> str:
    """One line of the table; a single number where nothing changed."""
    old, new = made.figures_before, made.figures

    def pair(before: float, after: float, form: str) -> str:
        one, other = format(before, form), format(after, form)
        return one if one == other else f"{one} → {other}"

    cells = (
        name,
        pair(made.value_before, made.value, ".4f"),
        "–" if math.isnan(covered[0]) else pair(*covered, ".4f"),
        pair(old.creases, new.creases, "d"),
        pair(old.panels, new.panels, "d"),
        pair(old.smallest_sector, new.smallest_sector, ".2f") + "°",
        pair(old.smallest_width, new.smallest_width, ".3f"),
        made.certificate.verdict,
    )
    return "| " + " | ".join(cells) + " |"


def covered(file: Path, made: Simplified) -> tuple[float, float]:
    """The mean distance of the target's points from the sheet, before and after; NaN without a target."""
    saved = read_saved(file)
    samples = samples_of(saved.objective)
    designs = (saved.game.design(saved.actions, saved.angle), made.design)
    before, after = (distances_to(design, samples) for design in designs)
    return (float(before.mean()), float(after.mean())) if len(samples) else (math.nan, math.nan)


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--out", type=Path)
    parser.add_argument("--tolerance", type=float, default=TOLERANCE)
    options = parser.parse_args()
    lines = [
        "# Simplified designs",
        "",
        f"`origami-lab simplify FILE --tolerance {options.tolerance:g}` for every design of `results/paper/designs`: no"
        " return falls by more, and no point of a target gets further from the sheet by more. What goes beyond that are"
        " creases that never fold.",
        "",
        HEAD,
        "|---" * HEAD.count(" | ") + "|---|",
    ]
    with tempfile.TemporaryDirectory() as folder:
        for file in sorted(DESIGNS.glob("*.fold")):
            done = simplify_saved(Path(shutil.copy(file, folder)), tolerance=options.tolerance, pictures=False)
            lines.append(row(file.stem, done.made, covered(file, done.made)))
            print(lines[-1], flush=True)
    if options.out is not None:
        options.out.write_text("\n".join(lines) + "\n", encoding="utf-8")


if __name__ == "__main__":
    main()
