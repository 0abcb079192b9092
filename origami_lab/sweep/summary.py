"""Files of a sweep that has ended: the best configuration, plots, the comparison, and a summary."""

from __future__ import annotations

import json
import shlex
import warnings
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from datetime import UTC, datetime
from importlib.metadata import version
from typing import Any

import optuna
from optuna.trial import TrialState

from origami_lab.config.config_file import config_text
from origami_lab.config.seeds import format_seeds
from origami_lab.drawing.figures import png_and_svg
from origami_lab.experiment.run_summary import versions
from origami_lab.files import write_whole
from origami_lab.sweep import plots
from origami_lab.sweep.held_out_test import FEW_SEEDS, compare
from origami_lab.sweep.search_space import overrides_of
from origami_lab.sweep.storage import storage_name
from origami_lab.sweep.studies import HeldOutJob, returns_of
from origami_lab.sweep.sweep_config import Declaration
from origami_lab.sweep.trial_queue import Slot
from origami_lab.text import command_text

BEST, SUMMARY, SUMMARY_TEXT = "best.yaml", "summary.json", "summary.md"
FEWEST_FOR_IMPORTANCE = 4
"""Finished trials below which nothing can be said about what mattered."""


@dataclass(frozen=True)
class SweepSummary:
    """The findings of a sweep that has ended."""

    declaration: Declaration
    study: optuna.Study
    record: Mapping[str, Any]
    comparison: HeldOutJob | None
    """None if no trial was played to its end."""
    compared: Mapping[str, Slot]
    """How each of the settings did, by name."""
    command: Sequence[str]

    @property
    def best(self) -> dict[str, Any] | None:
        """The record of the best trial."""
        return next((trial for trial in self.record["ended"] if trial["trial"] == self.record["best"]), None)

    def write(self) -> dict[str, Any]:
        """Write all files; returns the summary.

        Raises
        ------
        OSError
            If one cannot be written.
        """
        folder, best = self.declaration.folder, self.best
        importances, note = self.importances()
        figures = {"history": plots.history(self.record), "slices": plots.slices(self.record, self.declaration.space)}
        if importances:
            figures["importance"] = plots.importance(importances, note)
        held_out: dict[str, Any] = {}
        if best is not None and self.comparison is not None:
            write_whole(folder / BEST, self.best_yaml(best), sync=True)
            played = {name: returns_of(slot) for name, slot in self.compared.items() if slot.state == "complete"}
            held_out = compare(played) | {
                "failed": {name: slot.reason for name, slot in self.compared.items() if slot.state == "failed"},
                "seeds": format_seeds(self.comparison.seeds),
                "budget": self.declaration.held_out.budget,
                "folder": str(self.comparison.folder.relative_to(folder)),
                "commands": {
                    name: self._command(overrides, self.comparison.seeds)
                    for name, overrides in self.comparison.overrides.items()
                },
            }
            if held_out["settings"]:
                figures["held_out"] = plots.held_out(held_out)
        for name, figure in figures.items():
            write_whole(folder / f"{name}.png", png_and_svg(figure)[0], sync=True)
        summary = self.summary(best, importances, held_out)
        write_whole(folder / SUMMARY, json.dumps(summary, indent=2) + "\n", sync=True)
        write_whole(folder / SUMMARY_TEXT, page(self.declaration, summary, sorted(figures)), sync=True)
        return summary

    def importances(self) -> tuple[dict[str, float], str]:
        """The part of the variance that each parameter explains, by Optuna's fANOVA; what it was computed from."""
        complete = self.study.get_trials(deepcopy=False, states=(TrialState.COMPLETE,))
        values = {p.name: {trial.params.get(p.name) for trial in complete} for p in self.declaration.space}
        everywhere = [p.name for p in self.declaration.space if all(p.name in trial.params for trial in complete)]
        everywhere = [name for name in everywhere if len(values[name]) > 1]
        if len(complete) < FEWEST_FOR_IMPORTANCE or not everywhere:
            return {}, ""
        try:
            with warnings.catch_warnings():
                warnings.simplefilter("ignore")
                evaluator = optuna.importance.FanovaImportanceEvaluator(seed=0)
                found = optuna.importance.get_param_importances(self.study, evaluator=evaluator, params=everywhere)
        except (ValueError, RuntimeError):  # all returns are the same
            return {}, ""
        left_out = len(everywhere) < len(self.declaration.space)
        note = f"part of the variance explained (fANOVA, {len(complete)} trials)"
        return dict(found), note + ("\nwithout parameters under conditions, or with one value" if left_out else "")

    def best_yaml(self, best: Mapping[str, Any]) -> str:
        """The best trial's configuration, which runs as it is."""
        path = self.declaration.folder / BEST
        seeds = _written(self.declaration.seeds)
        settings = self.declaration.compose([*self.declaration.base, *overrides_of(best["point"]), f"seed={seeds}"])
        head = (
            f"The best of {self.record['trials']} trials of the sweep {self.declaration.study}: "
            f"trial {best['trial']}, mean return {best['value']:z.4f}.",
            f"runs with: origami-lab {shlex.quote(str(path))} seed=0..9",
        )
        return config_text(head, settings.config)

    def _command(self, overrides: Sequence[str], seeds: Sequence[int]) -> str:
        """The command that plays some settings with some seeds."""
        own = self.declaration.config_dir
        parts = [] if own is None else ["--config-dir", str(own)]
        return shlex.join(["origami-lab", *parts, *overrides, f"seed={_written(seeds)}"])

    def summary(
        self, best: Mapping[str, Any] | None, importances: Mapping[str, float], held_out: Mapping[str, Any]
    ) -> dict[str, Any]:
        """The contents of summary.json."""
        ended = self.record["ended"]
        states = [trial["state"] for trial in ended]
        overrides = [] if best is None else [*self.declaration.base, *overrides_of(best["point"])]
        return {
            "study": self.declaration.study,
            "declaration": self.declaration.fixed,
            "trials": {name: states.count(name) for name in ("complete", "pruned", "failed")},
            "seeds_played": sum(len(trial["returns"]) for trial in ended),
            "played_again": sum(trial["lost_before"] for trial in ended),
            "seconds_of_work": round(sum(trial["ended"] - trial["began"] for trial in ended), 1),
            "best": None
            if best is None
            else {key: best[key] for key in ("trial", "value", "point", "returns")}
            | {"command": self._command(overrides, self.declaration.seeds)},
            "importance": dict(importances),
            "held_out": dict(held_out),
            "storage": storage_name(self.declaration),
            "finished": datetime.now(UTC).isoformat(timespec="seconds"),
            "command": command_text(self.command),
            "versions": {**versions(), "optuna": version("optuna")},
        }


def _written(seeds: Sequence[int]) -> str:
    return str(format_seeds(seeds)).replace(" ", "")


def page(declaration: Declaration, summary: Mapping[str, Any], figures: Sequence[str]) -> str:
    """The text of summary.md."""
    counts, best, held_out = summary["trials"], summary["best"], summary["held_out"]
    states = ", ".join(f"{number} {name}" for name, number in counts.items() if number)
    lines = [
        f"# Sweep {declaration.study}",
        "",
        f"{' '.join(declaration.base)}, seeds {_written(declaration.seeds)} a trial; "
        f"sampler {declaration.sampler.name} (seed {declaration.sampler.seed}), pruner {declaration.pruner.name}.",
        "",
        f"Trials: {states or 'none'}; {summary['seeds_played']} seeds in {summary['seconds_of_work']:,.0f} s of work.",
        "",
    ]
    if best is not None:
        lines += [
            f"**Best: trial {best['trial']}, mean return {best['value']:z.4f}** over the sweep's own seeds, on which "
            "it was chosen:",
            "what it is worth is in the table below.",
            "",
            "```",
            best["command"],
            "```",
            "",
        ]
    if held_out:
        lines += _comparison(held_out)
    lines += [line for name in figures for line in (f"![{name.replace('_', ' ')}]({name}.png)", "")]
    packages = ", ".join(f"{name} {number}" for name, number in summary["versions"].items())
    lines += [f"Made by `{summary['command']}` with {packages}.", ""]
    return "\n".join(lines)


def _comparison(held_out: Mapping[str, Any]) -> list[str]:
    title = f"## On held-out seeds {_written_as(held_out['seeds'])}, {held_out['budget']:,} interactions each"
    lines = [
        title,
        "",
        "| settings | mean ± std | median | best − it | 95 % interval | p | |",
        "|---|---|---|---|---|---|---|",
    ]
    for name, found in held_out["settings"].items():
        std = "" if found["std"] is None else f" ± {found['std']:z.4f}"
        cells = [name, f"{found['mean']:z.4f}{std}", f"{found['median']:z.4f}"]
        result = held_out["differences"].get(name)
        if result is None:
            cells += ["", "", "", ""]
        else:
            interval = f"{result['low']:+.4f} to {result['high']:+.4f}"
            cells += [f"{result['mean']:+.4f}", interval, f"{result['p']:z.4f}", f"best is {_says(result['verdict'])}"]
        lines.append("| " + " | ".join(cells) + " |")
    lines += [f"| {name} | failed: {reason} | | | | | |" for name, reason in held_out["failed"].items()]
    lines += ["", f"{held_out['method'].capitalize()}."]
    played = min((len(found["returns"]) for found in held_out["settings"].values()), default=0)
    if played < FEW_SEEDS:
        lines += [f"{played} seeds are few: intervals from so few are too narrow, and little is significant."]
    lines += ["", "```", *held_out["commands"].values(), "```", ""]
    return lines


def _says(verdict: str) -> str:
    return "not significantly different" if verdict.startswith("no ") else verdict


def _written_as(seeds: object) -> str:
    return str(seeds).replace(" ", "")
