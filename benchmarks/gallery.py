"""The gallery of results/beyond: folded designs of two searchers, one above the other.

python -m benchmarks.gallery OUT.png bowl=LNS_TRIAL,BFTS_TRIAL face=LNS_TRIAL,BFTS_TRIAL ...

A trial is a ``seed=N`` folder with its ``folded.png``.
"""

from __future__ import annotations

import json
import sys
from pathlib import Path

import matplotlib.pyplot as plt

SEARCHERS = "lns", "bfts"


def main() -> None:
    out, *words = sys.argv[1:]
    columns = {name: folders.split(",") for name, folders in (word.split("=", 1) for word in words)}
    figure, axes = plt.subplots(len(SEARCHERS), len(columns), figsize=(4 * len(columns), 8.6), squeeze=False)
    for column, (name, folders) in enumerate(columns.items()):
        for row, (searcher, folder) in enumerate(zip(SEARCHERS, folders, strict=True)):
            panel = axes[row, column]
            panel.imshow(plt.imread(Path(folder) / "folded.png"))
            value = json.loads((Path(folder) / "actions.json").read_text(encoding="utf-8"))["return"]
            panel.set_title(f"{name}, {searcher}: {value:.3f}".replace("-", "−"))
            panel.axis("off")
    figure.tight_layout()
    figure.savefig(out, dpi=60)


if __name__ == "__main__":
    main()
