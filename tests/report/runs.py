"""Small run folders, written by hand: what their tables must say is known."""

from __future__ import annotations

import json
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

import yaml

from origami_lab.report.run_groups import Group, Groups, group_runs
from origami_lab.report.run_reader import Run, read_runs
from origami_lab.runs.trial_row import TrialRow, format_trials

BUDGET = 1000


def trial(value: float, to_best: int = 100, status: str = "ok", **more: Any) -> dict[str, Any]:
    """What a trial found; the three distances agree where nothing else is said."""
    distances = {f"return_{name}": value for name in ("vertex", "surface", "sampled")}
    found = {"return": value, **distances, "interactions_to_best": to_best, "interactions": BUDGET, "status": status}
    return found | more


def failed(reason: str = "ValueError: x") -> dict[str, Any]:
    return {"status": f"failed: {reason}"}


def write_run(
    folder: Path,
    task: str,
    method: str,
    trials: Sequence[Mapping[str, Any]] | Mapping[int, Mapping[str, Any]],
    *,
    curves: Mapping[int, Sequence[tuple[int, float]]] | None = None,
    **settings: Any,
) -> Path:
    """A run's folder, without pictures. ``settings`` are dotted keys with ``__`` for the dot."""
    by_seed = dict(trials) if isinstance(trials, Mapping) else dict(enumerate(trials))
    config: dict[str, Any] = {"task": task, "method": method, "budget": BUDGET, "seed": sorted(by_seed), "workers": 1}
    config |= {"certify": "improvements", "objective": {"distance": "vertex"}, "search": {"_target_": f"x.{method}"}}
    config |= {"tracking": {"kind": "none"}, "output": str(folder)}
    for key, value in settings.items():
        *groups, name = key.split("__")
        part = config
        for group in groups:
            part = part.setdefault(group, {})
        part[name] = value
    folder.mkdir(parents=True)
    (folder / "config.yaml").write_text(yaml.safe_dump(config), encoding="utf-8")
    rows = [TrialRow.from_values({"seed": seed, **row}) for seed, row in by_seed.items()]
    (folder / "trials.csv").write_text(format_trials(rows), encoding="utf-8")
    summary = {"command": f"origami-lab {task} {method}", "seconds": 1.5, "versions": {"origami-lab": "0.1.0"}}
    (folder / "summary.json").write_text(json.dumps(summary), encoding="utf-8")
    for row in rows:
        if row.has_failed:
            continue
        place = folder / f"seed={row.seed}"
        place.mkdir()
        (place / "result.json").write_text(json.dumps(row.values()), encoding="utf-8")
        steps = (curves or {}).get(row.seed, [(row.interactions_to_best or 0, row.return_ or 0.0)])
        lines = [f"{step},{value},90.0\n" for step, value in steps]
        (place / "curve.csv").write_text("interactions,return,driving_angle\n" + "".join(lines), encoding="utf-8")
    return folder


def gather(*folders: Path) -> tuple[list[Run], Groups, list[str]]:
    """Runs, their groups and the notes on both, as text."""
    runs, notes = read_runs(folders)
    groups = group_runs(runs)
    return runs, groups, [note.shown() for note in [*notes, *groups.notes]]


def cell(groups: Groups, row: str, column: str) -> Group:
    """The group at two labels."""
    [found] = [group for (r, c), group in groups.cells.items() if (r.label, c.label) == (row, column)]
    return found


def labels(groups: Groups) -> tuple[list[str], list[str]]:
    return [row.label for row in groups.rows], [column.label for column in groups.columns]
