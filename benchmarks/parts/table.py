"""How near a sheet comes to each part with one command: ``python -m benchmarks.parts.table FOLDER [PART ...]``.

``seeds=A..B`` and ``budget=N`` may be given, and settings of origami-lab, which go to each run. Runs are kept in the
folder and not repeated. ``--table`` prints the table of what has run, ``--sheet FILE`` draws the best designs.
"""

from __future__ import annotations

import json
import shutil
import sys
from collections import Counter
from pathlib import Path
from typing import Any

import numpy as np
import yaml  # type: ignore[import-untyped]
from PIL import Image, ImageDraw

import origami_lab
from benchmarks.parts.shapes import PARTS, write_parts

COLUMNS, PIXELS = 4, 420
ZERO = 1e-9
"""Of a part's size: below it a distance is rounding."""
SURFACE = "objective.distance=surface"


def run_part(folder: Path, name: str, settings: list[str]) -> None:
    """Run one part unless it has run; its log is on stderr."""
    output = folder / "runs" / name
    if not (output / "summary.json").is_file():
        shutil.rmtree(output, ignore_errors=True)
        words = [
            "target=mesh",
            f"target.path={folder / 'parts' / name}.stl",
            SURFACE,
            "tracking=none",
            f"output={output}",
        ]
        origami_lab.run([*words, *settings])


def row(folder: Path, name: str) -> dict[str, Any] | None:
    """What the runs of a part have come to; None if it has not run."""
    output = folder / "runs" / name
    if not (output / "summary.json").is_file():
        return None
    summary = json.loads((output / "summary.json").read_text())
    config = yaml.safe_load((output / "config.yaml").read_text())
    rows = [json.loads(file.read_text()) for file in sorted(output.glob("seed=*/result.json"))]
    millimetres = float(summary["units_per_cell"])
    corners = PARTS[name]().reshape(-1, 3)
    size = float(np.linalg.norm(np.ptp(corners, axis=0)))
    found = np.array([-row["return_surface"] for row in rows]) * millimetres
    if not found.size:
        return None
    best = int(np.argmin(found))
    return {
        "part": name,
        "seeds": len(rows),
        "budget": config["budget"],
        "cell": millimetres,
        "symmetry": config["symmetry"]["name"],
        "start": config["start"]["_target_"].rpartition(".")[2],
        "best": float(found[best]),
        "mean": float(found.mean()),
        "size": size,
        "seed": rows[best]["seed"],
        "panels": rows[best]["panels"],
        "vertices": rows[best]["vertices"],
        "seconds": float(np.mean([row["seconds"] for row in rows])),
        "best_at": float(np.mean([row["interactions_to_best"] for row in rows])),
        "percent": -rows[best]["return_percent"],
        "likeness": [rows[best]["likeness"], min(row["likeness"] for row in rows)],
        "certificates": Counter(row["certificate"] for row in rows),
    }


def table(folder: Path) -> str:
    """The table as Markdown."""
    columns = [
        *("part", "start", "symmetry", "cell", "best", "mean", "best, % of size", "likeness: best, least", "panels"),
        *("certificates", "seconds a seed"),
    ]
    lines = [f"| {' | '.join(columns)} |", "|" + len(columns) * "---|"]
    for name in PARTS:
        if (found := row(folder, name)) is not None:
            best, mean = (0.0 if found[key] < ZERO * found["size"] else found[key] for key in ("best", "mean"))
            cells = (
                *(name, found["start"].lower(), found["symmetry"], f"{found['cell']:.4g} mm"),
                *(f"{best:.3g} mm", f"{mean:.3g} mm", f"{found['percent'] if best else 0:.2g}"),
                ", ".join(f"{value:.2f}" for value in found["likeness"]),
                str(found["panels"]),
                ", ".join(f"{count} {verdict}" for verdict, count in found["certificates"].items()),
                f"{found['seconds']:.0f}",
            )
            lines.append(f"| {' | '.join(cells)} |")
    return "\n".join(lines)


def contact_sheet(folder: Path, file: Path) -> None:
    """The best design of each part, folded in its target."""
    found = [one for one in (row(folder, name) for name in PARTS) if one is not None]
    rows = -(-len(found) // COLUMNS)
    sheet = Image.new("RGB", (COLUMNS * PIXELS, rows * (PIXELS + 24)), "white")
    draw = ImageDraw.Draw(sheet)
    for k, one in enumerate(found):
        picture = folder / "runs" / one["part"] / f"seed={one['seed']}" / "folded.png"
        x, y = k % COLUMNS * PIXELS, k // COLUMNS * (PIXELS + 24)
        image = Image.open(picture).convert("RGB")
        image.thumbnail((PIXELS, PIXELS))
        sheet.paste(image, (x + (PIXELS - image.width) // 2, y))
        best = round(one["best"], 6)  # what rounding leaves is 0
        draw.text((x + 12, y + PIXELS + 4), f"{one['part']}: {best:.2g} mm of {one['size']:.0f}", fill="black")
    sheet.save(file)


def main(words: list[str]) -> None:
    folder, *rest = words
    place = Path(folder).absolute()
    if "--table" in rest:
        print(table(place))
    elif "--sheet" in rest:
        contact_sheet(place, Path(rest[rest.index("--sheet") + 1]))
    else:
        write_parts(place / "parts")
        names = [word for word in rest if word in PARTS] or list(PARTS)
        settings = [word for word in rest if "=" in word]
        settings = [word.replace("seeds=", "seed=") for word in settings]
        for name in names:
            run_part(place, name, settings)


if __name__ == "__main__":
    main(sys.argv[1:])
