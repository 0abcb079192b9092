"""What simplify makes of the committed designs: creases, panels and the smallest of each, before and after.

python -m benchmarks.simplified_designs --out benchmarks/simplified_designs.md
"""

from __future__ import annotations

import argparse
import shutil
import tempfile
from pathlib import Path

from origami_lab.experiment.reworked_designs import simplify_saved
from origami_lab.polish.simplifier import TOLERANCE, Simplified

DESIGNS = Path(__file__).parents[1] / "results" / "paper" / "designs"
HEAD = "| design | return | creases | panels | smallest sector | narrowest panel, cells | certificate |"


def row(name: str, made: Simplified) -> str:
    """One line of the table; a single number where nothing changed."""
    old, new = made.figures_before, made.figures

    def pair(before: float, after: float, form: str) -> str:
        one, other = format(before, form), format(after, form)
        return one if one == other else f"{one} → {other}"

    cells = (
        name,
        pair(made.value_before, made.value, ".4f"),
        pair(old.creases, new.creases, "d"),
        pair(old.panels, new.panels, "d"),
        pair(old.smallest_sector, new.smallest_sector, ".2f") + "°",
        pair(old.smallest_width, new.smallest_width, ".3f"),
        made.certificate.verdict,
    )
    return "| " + " | ".join(cells) + " |"


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--out", type=Path)
    parser.add_argument("--tolerance", type=float, default=TOLERANCE)
    options = parser.parse_args()
    lines = [
        "# Simplified designs",
        "",
        f"`origami-lab simplify FILE --tolerance {options.tolerance:g}` for every design of `results/paper/designs`.",
        "",
        HEAD,
        "|---" * HEAD.count(" | ") + "|---|",
    ]
    with tempfile.TemporaryDirectory() as folder:
        for file in sorted(DESIGNS.glob("*.fold")):
            done = simplify_saved(Path(shutil.copy(file, folder)), tolerance=options.tolerance, pictures=False)
            lines.append(row(file.stem, done.made))
            print(lines[-1], flush=True)
    if options.out is not None:
        options.out.write_text("\n".join(lines) + "\n", encoding="utf-8")


if __name__ == "__main__":
    main()
