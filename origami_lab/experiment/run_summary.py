"""What a run has come to, from the rows of its trials: the contents of summary.json."""

from __future__ import annotations

import platform
from collections.abc import Mapping, Sequence
from dataclasses import asdict
from datetime import UTC, datetime
from importlib.metadata import PackageNotFoundError, version
from typing import Any

from origami_lab.about import __version__
from origami_lab.config.seeds import format_seeds
from origami_lab.config.settings import Settings
from origami_lab.runs.run_folder import RunFolder, read_summary
from origami_lab.runs.trial_row import FIGURES, LIKENESSES, TrialRow, best_row, certificates, counts, spreads
from origami_lab.text import command_text

PACKAGES = ("numpy", "numba", "scipy", "trimesh", "hydra-core", "mlflow")


def summarise(
    settings: Settings,
    rows: Mapping[int, TrialRow],
    command: Sequence[str],
    seconds: float,
    interrupted: bool,
) -> dict[str, Any]:
    """The contents of summary.json."""
    return {
        "task": settings.task,
        "search": settings.method,
        "budget": settings.budget,
        **({"stages": [stage.to_node() for stage in settings.stages]} if settings.stages else {}),
        "seeds": format_seeds(settings.seeds),
        "interrupted": interrupted,
        **_figures(rows),
        "seconds": round(seconds, 3),
        "finished": datetime.now(UTC).isoformat(timespec="seconds"),
        "command": command_text(command),
        "versions": versions(),
    }


def refresh_tables(folder: RunFolder) -> None:
    """Write trials.csv and the figures in summary.json anew, after rows have changed; raises OSError."""
    rows = folder.known_rows()
    folder.write_trials(rows.values())
    if summary := read_summary(folder.path):
        folder.write_summary(summary | _figures(rows))


def _figures(rows: Mapping[int, TrialRow]) -> dict[str, Any]:
    """The part of summary.json that the rows say."""
    best, polished = best_row(rows.values()), best_row(rows.values(), "polished_return")
    shown = ("seed", "polished_return", "polished_driving_angle")
    ends = {row.ended for row in rows.values() if row.ended}
    found, others = spreads(rows.values()), (*FIGURES, *(f"polished_{name}" for name in LIKENESSES))
    return {
        "trials": counts(rows.values()),
        "returns": {name: asdict(spread) for name, spread in found.items() if name not in others},
        "figures": {name: asdict(spread) for name, spread in found.items() if name in others},
        "surface_is_worse": [row.seed for row in rows.values() if row.surface_is_worse],
        "std": "sample standard deviation (n - 1)",
        "certificates": {verdict: len(seeds) for verdict, seeds in certificates(rows.values()).items()},
        "best": None if best is None else {name: best[name] for name in ("seed", "return", "driving_angle")},
        "best_polished": None if polished is None else {name: polished[name] for name in shown},
        "ended": {name: sum(row.ended == name for row in rows.values()) for name in sorted(ends)},
        "interactions": sum(row.interactions or 0 for row in rows.values()),
        "places_evaluated": sum(row.places_evaluated or 0 for row in rows.values()),
    }


def versions() -> dict[str, str]:
    """Versions that the results were computed with."""
    found = {"origami-lab": __version__, "python": platform.python_version()}
    for name in PACKAGES:
        try:
            found[name] = version(name)
        except PackageNotFoundError:
            continue
    return found
