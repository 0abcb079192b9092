"""The result of a run, read from its folder: a table of trials and the designs as objects."""

from __future__ import annotations

import os
from collections.abc import Iterator, Mapping
from dataclasses import dataclass, fields
from functools import cached_property
from html import escape
from pathlib import Path
from typing import TYPE_CHECKING, Any

from origami_lab.config.dotted_path import locate
from origami_lab.config.earlier_versions import game_of_today
from origami_lab.errors import EXIT_FAILED, EXIT_INTERRUPTED, EXIT_OK, InputError
from origami_lab.file_names import ACTIONS, BEST, CONFIG, trial_folder
from origami_lab.files import expanded, read_json
from origami_lab.game.crease_pattern import CreasePattern
from origami_lab.runs.run_folder import RunFolder, read_summary
from origami_lab.runs.trial_row import COLUMNS, KINDS, NO_DESIGN, TrialRow, best_row, counts, spreads

if TYPE_CHECKING:
    import pandas as pd


@dataclass(frozen=True, eq=False)
class TrialDesign(CreasePattern):
    """A trial's best design, which shows itself in a notebook with its motion and its target."""

    folder: Path | None = None
    """The trial's."""

    def _repr_html_(self) -> str:
        from origami_lab.drawing.notebook import show

        whole = self.folder is not None and (self.folder / BEST).is_file()
        return show(self.folder if whole and self.folder is not None else self)._repr_html_()


class Result:
    """A run: its table of trials, its designs, its folder. Everything is read from the folder when first asked for.

    Attributes
    ----------
    folder
        The run's folder, an absolute path.
    exit_code
        0, 1 if a trial failed, 130 if the run was interrupted or never came to its end.
    """

    def __init__(self, folder: Path, exit_code: int | None = None) -> None:
        self.folder = folder
        self.exit_code = self._exit_code() if exit_code is None else exit_code

    @cached_property
    def _rows(self) -> dict[int, TrialRow]:
        """The trials by seed."""
        return RunFolder(self.folder).known_rows()

    @cached_property
    def trials(self) -> pd.DataFrame:
        """trials.csv: one row a seed, which is the index. Counts are Int64, figures float64 (NaN: no value)."""
        import pandas as pd

        kinds = {name: {int: "Int64", float: "float64", str: "string"}[kind] for name, kind in KINDS.items()}
        rows = [row.values() for row in self._rows.values()]
        table = pd.DataFrame(rows, columns=list(COLUMNS)).astype(kinds)
        return table.astype({"seed": "int64"}).set_index("seed")

    @cached_property
    def summary(self) -> dict[str, Any]:
        """summary.json: mean ± std of the returns, the best seed, versions, the command; {} if the run has none yet."""
        return read_summary(self.folder)

    @cached_property
    def designs(self) -> Mapping[int, TrialDesign]:
        """Seed → the trial's best design, replayed from its actions when it is looked up; no failed trials.

        Where a trial found none (status "no design") it is the bare start pattern.
        """
        return _Designs(self.folder, [seed for seed in self._rows if trial_folder(self.folder, seed).is_dir()])

    @property
    def best(self) -> TrialDesign:
        """The design with the highest return, the lowest seed among equals.

        Raises
        ------
        LookupError
            If no trial found a design.
        """
        row = self._best_row()
        if row is None:
            raise LookupError(f"no trial in {self.folder} found a design")
        return self.designs[row.seed]

    def _best_row(self) -> TrialRow | None:
        return best_row(row for row in self._rows.values() if row.outcome != NO_DESIGN)

    def _exit_code(self) -> int:
        if self.summary.get("interrupted", True):
            return EXIT_INTERRUPTED
        failed = any(row.has_failed for row in self._rows.values())
        return EXIT_FAILED if failed else EXIT_OK

    def _repr_html_(self) -> str:
        """In a notebook: the table of trials and, if there is one, the best design."""
        row = self._best_row()
        shown = "" if row is None else self.designs[row.seed]._repr_html_()
        return f"<p>{escape(repr(self))}</p>{self.trials.to_html(notebook=True)}{shown}"

    def __repr__(self) -> str:
        trials = ", ".join(f"{count} {name}" for name, count in counts(self._rows.values()).items())
        found = spreads(self._rows.values()).get("return")
        row = self._best_row()
        parts = [f"{self.summary.get('task', '?')} {self.summary.get('search', '?')}", f"trials: {trials or 'none'}"]
        if found is not None:
            parts.append(f"return {found}")
        if row is not None:
            parts.append(f"best {row.return_:z.4f} (seed {row.seed})")
        return f"<Result {'; '.join(parts)}; {self.folder}>"


class _Designs(Mapping[int, TrialDesign]):
    """The designs of a run; each is made once, when it is first looked up."""

    def __init__(self, folder: Path, seeds: list[int]) -> None:
        self._folder, self._seeds = folder, seeds
        self._made: dict[int, TrialDesign] = {}

    def __getitem__(self, seed: int) -> TrialDesign:
        if seed not in self._seeds:
            raise KeyError(seed)
        if seed not in self._made:
            self._made[seed] = replay_design(trial_folder(self._folder, seed))
        return self._made[seed]

    def __iter__(self) -> Iterator[int]:
        return iter(self._seeds)

    def __len__(self) -> int:
        return len(self._seeds)

    def __repr__(self) -> str:
        return f"<designs of seeds {', '.join(map(str, self._seeds)) or 'none'}>"


def load(folder: str | os.PathLike[str]) -> Result:
    """The result of a run, from its folder; of an unfinished one, what there is.

    Raises
    ------
    InputError
        If it is not the folder of a run, or was made by a newer version.
    """
    path = expanded(folder).absolute()
    if not (path / CONFIG).is_file():
        raise InputError("folder", folder, "must be the folder of a run, there is no config.yaml in it")
    RunFolder(path).config()  # that it can be read, and by this version
    return Result(path)


def replay_design(trial: Path) -> TrialDesign:
    """The design of one trial, from its ``seed=N`` folder: its actions are played again, each of them checked.

    Raises
    ------
    InputError
        If actions.json is missing or damaged, or the game of this version does not allow its actions.
    """
    from origami_lab.fold_format.writer import read_fold
    from origami_lab.game.game import Game

    file = trial / ACTIONS
    try:
        saved = read_json(file)
        settings, start = game_of_today(saved["game"]), dict(saved["game"]["start"])
        settings["start"] = locate("start", start.pop("_target_"))(**start)
        facts = read_fold(trial / BEST).metadata
        design = Game(**settings).design(saved["actions"], saved["angle"], facts)
        return TrialDesign(**{own.name: getattr(design, own.name) for own in fields(design)}, folder=trial.absolute())
    except (OSError, ValueError, KeyError, TypeError) as error:
        if isinstance(error, InputError):
            raise
        lines = str(error).splitlines() or [""]
        raise InputError(str(file), type(error).__name__, f"cannot be replayed: {lines[0]}") from error
