"""Playing the trials of a study: one after the other, seed by seed, each trial in a run folder of its own."""

from __future__ import annotations

import time
import traceback
from collections.abc import Callable
from contextlib import suppress
from dataclasses import dataclass, replace
from pathlib import Path

from optuna.exceptions import UpdateFinishedTrialError
from optuna.trial import Trial, TrialState

from origami_lab.config.instantiate import build_parts
from origami_lab.config.seeds import format_seeds
from origami_lab.config.settings import Settings
from origami_lab.errors import InputError
from origami_lab.experiment.run_page import write_run_page
from origami_lab.experiment.run_summary import summarise
from origami_lab.experiment.trial import is_done, run_trial
from origami_lab.files import require_no_link
from origami_lab.runs.locks import FolderInUseError
from origami_lab.runs.run_folder import FolderError, RunFolder
from origami_lab.runs.trial_row import STOPPED as SEED_STOPPED
from origami_lab.runs.trial_row import TrialRow
from origami_lab.sweep.studies import RETURNS, Job, mean_of
from origami_lab.sweep.trial_queue import FAILED, PRUNED, STOPPED, HeldTrial, TrialQueue
from origami_lab.workers.call_limit import Calls
from origami_lab.workers.guarded_objective import watched
from origami_lab.workers.worker_process import reason_of

SHORTEST_WAIT, LONGEST_WAIT = 0.1, 2.0
"""Seconds between two looks of a worker that has nothing to do, because others play the last trials."""
IN_USE_SECONDS = 30.0
"""For how long a trial is left alone whose folder another worker holds, one that was taken for lost and lives."""


@dataclass(frozen=True)
class Player:
    """Plays trials until a study is done, or it is told to stop.

    Parameters
    ----------
    should_stop
        Asked often while a seed is played.
    playing
        Called now and then while a seed is played: the kernels are loaded then.
    calls
        Numbers the calls of a user's objective; None if nobody watches how long they take.
    """

    should_stop: Callable[[], bool]
    playing: Callable[[], None] = lambda: None
    calls: Calls | None = None

    def work(self, job: Job, queue: TrialQueue) -> bool:
        """Play what nobody else plays, until all slots are done; False if stopped before."""
        wait, in_use = SHORTEST_WAIT, dict[int, float]()
        while not self.should_stop():
            queue.reap()
            queue.fill()
            now = time.monotonic()
            in_use = {number: since for number, since in in_use.items() if now - since < IN_USE_SECONDS}
            held = queue.claim(without=in_use)
            if held is not None:
                if not self.play(job, held):
                    in_use[held.number] = now
                wait = SHORTEST_WAIT
            elif all(slot.done for slot in queue.look()):
                return True
            else:
                time.sleep(wait)
                wait = min(2 * wait, LONGEST_WAIT)
        return False

    def play(self, job: Job, held: HeldTrial) -> bool:
        """Play one trial and tell the study how it ended; False if its folder is in use.

        Raises
        ------
        FolderError
            If the run folder cannot be written; the trial waits for another worker then.
        """
        with held:
            try:
                trial, overrides = job.begin(held)
                settings = trial_settings(job, held.number, overrides)
                held.note("folder", str(job.path(held.number).absolute()))
                held.note("host", held.queue.worker.host.partition(" ")[0])
                with RunFolder.opened(settings) as folder:
                    self._play_seeds(job, held, trial, settings, folder)
            except UpdateFinishedTrialError:  # others took it for lost
                held.lost = True
            except FolderInUseError:  # by a worker that was taken for lost and lives
                held.fail(STOPPED)
                return False
            except FolderError:
                held.fail(STOPPED)
                raise
            except InputError as error:
                if isinstance(error.__cause__, OSError):  # of the folder: another time, or on another machine, it works
                    held.fail(STOPPED)
                    raise FolderError(error.__cause__) from error
                held.fail(f"{FAILED}: {error}")
            except KeyboardInterrupt:
                held.fail(STOPPED)
                raise
        return True

    def _play_seeds(self, job: Job, held: HeldTrial, trial: Trial, settings: Settings, folder: RunFolder) -> None:
        rows = folder.rows()
        began = time.perf_counter()
        try:
            if not folder.has_begun:
                parts = build_parts(settings)
                folder.begin(settings.config, parts.target, parts.start_to_keep(settings))
            returns: list[float] = []
            for step, seed in enumerate(job.seeds):
                if not is_done(rows.get(seed), settings):
                    rows[seed] = self._play_seed(held, settings, folder, seed)
                row = rows[seed]
                folder.write_trials(rows.values())
                if not row.spent_budget:
                    stopped = row.outcome == SEED_STOPPED
                    held.fail(STOPPED if stopped else f"{FAILED}: seed {seed}: {row.reason}")
                    return
                assert row.return_ is not None
                returns.append(row.return_)
                trial.report(mean_of(returns), step)
                if step + 1 < len(job.seeds) and trial.should_prune():
                    held.note(RETURNS, returns)
                    held.note(PRUNED, job.why_pruned(held, step))
                    held.end(TrialState.PRUNED, mean_of(returns))
                    return
            held.note(RETURNS, returns)
            held.end(TrialState.COMPLETE, mean_of(returns))
        except OSError as error:
            raise FolderError(error) from error
        finally:
            with suppress(OSError):
                seconds = time.perf_counter() - began
                stopped = not all(row.spent_budget for row in rows.values())
                folder.write_summary(summarise(settings, rows, ["origami-lab", "sweep"], seconds, stopped))
                write_run_page(folder.path)

    def _play_seed(self, held: HeldTrial, settings: Settings, folder: RunFolder, seed: int) -> TrialRow:
        try:
            parts = build_parts(settings)
            if self.calls is not None:
                parts = replace(parts, objective=watched(parts.objective, self.calls))
            stop = lambda: held.lost or self.should_stop()  # noqa: E731
            return run_trial(settings, seed, folder, lambda _: self.playing(), stop, parts, keep_state=False)[0]
        except (FolderError, KeyboardInterrupt):
            raise
        except BaseException as error:  # also what a user's objective may do to end a program
            folder.write_error(seed, traceback.format_exc())
            return TrialRow.failed(seed, reason_of(error))


def trial_settings(job: Job, number: int, overrides: list[str]) -> Settings:
    """The settings of one trial's run; its config.yaml runs again by itself."""
    path: Path = job.path(number).absolute()
    folder = job.declaration.folder.absolute()
    try:
        require_no_link(folder, path.relative_to(folder))
    except OSError as error:
        raise FolderError(str(error.strerror)) from error
    settings = job.settings(overrides)
    config = {**settings.config, "seed": format_seeds(job.seeds), "output": None, "resume": False}
    return replace(settings, output=path, config=config)
