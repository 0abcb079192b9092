"""Names and descriptions of MLflow's experiments and runs: figures, and the way to the picture and the viewer."""

from __future__ import annotations

import re
import shlex
from collections.abc import Iterable, Mapping
from typing import Any
from urllib.parse import quote

from origami_lab.file_names import DESCRIBED, FOLDED_PNG, PATTERN_PNG, POLISHED, VIEWER
from origami_lab.runs.trial_row import Spread, TrialRow
from origami_lab.tracking.shown_view import address

BEGINS = "Runs of origami-lab"
"""First words of the description of an experiment: one that begins otherwise is a person's, and stays."""
SAID_ALREADY = (
    *("target", "objective", "search", "task", "method", "seed", "output", "resume", "workers", "files"),
    *("verbosity", "open", "tracking", "trust"),
)
"""Settings that do not tell a run from others of its task and searcher."""
LINKED = (FOLDED_PNG, VIEWER, PATTERN_PNG, f"{POLISHED}.png", f"{POLISHED}.html")
"""Files that descriptions link to."""


def run_name(task: str, method: str, command: str, seeds: int) -> str:
    """The name of a run: task and searcher, what was set beside them, and the number of its seeds."""
    try:
        words = shlex.split(command)
    except ValueError:
        words = []
    settings = [word.lstrip("+") for word in words if re.match(r"\+{0,2}[\w./]+=", word)]
    own = [word for word in settings if not word.startswith((*(f"{key}=" for key in SAID_ALREADY), "tracking."))]
    trials = [f"{seeds} seeds"] if seeds > 1 else []
    return " · ".join([f"{task} {method}", *([" ".join(own)] if own else []), *trials])


def experiment_note(name: str, experiment: str) -> str:
    """The description of an experiment with runs: where it is shown as a table and as charts, and what they say."""
    return "\n\n".join(
        [
            f"{BEGINS}: **{plain(name)}**. [The table]({address(experiment)[1:]}) ·"
            f" [learning curves]({address(experiment, charts=True)[1:]})",
            "A row is one run, and below it are its seeds. `return_mean` and `return_std` are over the seeds,"
            " `best_return` is that of the best one, whose pictures are in the run's description; for target shapes 0"
            " is perfect.",
        ]
    )


def study_note(study: str, experiment: str) -> str:
    """The description of an experiment with a study."""
    return (
        f"{BEGINS}, the sweep **{plain(study)}**. [Its trials]({address(experiment)[1:]}) ·"
        f" [as charts]({address(experiment, charts=True)[1:]})"
    )


def run_note(
    title: str,
    spread: Spread | None,
    best: TrialRow | None,
    summary: Mapping[str, Any],
    artifacts: Artifacts,
    files: Iterable[str],
) -> str:
    """The description of a run of several seeds.

    Parameters
    ----------
    files
        Names of the best trial's files that are in the folder ``best`` of its artifacts.
    """
    said = [f"**{plain(title)}**"]
    if spread is not None:
        said.append(f"return {_minus(spread.rounded)} over {spread.n} trial{'' if spread.n == 1 else 's'}")
    if best is not None and best.return_ is not None:
        verdict = f", {best.certificate}" if best.certificate else ""
        said.append(f"best {_minus(f'{best.return_:z.4f}')} (seed {best.seed}{verdict})")
    lines = [": ".join([said[0], "; ".join(said[1:])]) if said[1:] else said[0], *artifacts.lines(files, "best/")]
    if command := str(summary.get("command") or ""):
        lines.append(f"Made by {_code(command)}")
    return "\n\n".join(lines)


def trial_note(row: TrialRow, artifacts: Artifacts, files: Iterable[str]) -> str:
    """The description of one seed."""
    if row.has_failed:
        return f"seed {row.seed}: failed: {plain(row.reason)}"
    figures = [f"seed {row.seed}: return {_minus(f'{row.return_:z.4f}')}"]
    if row.return_percent is not None:
        figures.append(f"{-row.return_percent:.1f} % of the target's size")
    if row.polished_return is not None:
        figures.append(f"polished {_minus(f'{row.polished_return:z.4f}')}")
    figures.append(row.certificate or row.outcome)
    return "\n\n".join([", ".join(figures), *artifacts.lines(files)])


def study_run_note(study: str, summary: Mapping[str, Any]) -> str:
    """The description of a study's run: its best settings, and the command that plays them."""
    best = summary.get("best")
    if not best:
        return f"**{plain(study)}**: no trial has been played to its end"
    return "\n\n".join(
        [
            f"**{plain(study)}**: best trial {best['trial']}, mean return {_minus(format(best['value'], 'z.4f'))}"
            " over the sweep's own seeds; what it is worth on others is in summary.md below Artifacts.",
            _code(str(best["command"])),
        ]
    )


def study_trial_note(trial: Mapping[str, Any]) -> str:
    """The description of one trial of a study."""
    value = "" if trial["value"] is None else f", mean return {_minus(format(trial['value'], 'z.4f'))}"
    point = ", ".join(f"{name}={value}" for name, value in trial["point"].items())
    reason = f": {plain(str(trial['reason']))}" if trial["reason"] else ""
    return "\n\n".join(
        [f"trial {trial['trial']}{value}, {trial['state']}{reason}", _code(point), f"in {_code(str(trial['folder']))}"]
    )


class Artifacts:
    """Addresses of a run's artifacts in MLflow's pages."""

    def __init__(self, experiment: str, run: str) -> None:
        self.experiment, self.run = experiment, run

    def lines(self, files: Iterable[str], folder: str = "") -> list[str]:
        """The picture of a design, and links to what shows it, as far as they are there."""
        there = [name for name in LINKED if name in set(files)]
        picture = next((name for name in (f"{POLISHED}.png", FOLDED_PNG) if name in there), None)
        links = [f"[{DESCRIBED[name]}]({self.page(folder + name)})" for name in there]
        shown = [f"![the design, folded]({self.file(folder + picture)})"] if picture else []
        return [*shown, *([" · ".join(links)] if links else [])]

    def page(self, path: str) -> str:
        """The page that shows an artifact."""
        return f"#/experiments/{self.experiment}/runs/{self.run}/artifacts/{quote(path)}"

    def file(self, path: str) -> str:
        """The artifact itself."""
        return f"get-artifact?path={quote(path, safe='')}&run_uuid={self.run}"


def plain(text: str) -> str:
    """A name that is no markup, whatever is in it."""
    return re.sub(r"([\\`*_{}\[\]<>()#!|~&])", r"\\\1", " ".join(text.split()))


def _code(text: str) -> str:
    return f"`{text.replace('`', chr(39))}`"


def _minus(number: str) -> str:
    return number.replace("-", "−")
