"""What a multirun prints at its end."""

from __future__ import annotations

import io

from rich.console import Console

from origami_lab.multirun.jobs_table import best_commands, table_of_jobs
from origami_lab.runs.multirun_folder import JobResult, PlannedJob
from origami_lab.runs.trial_row import Spread


def result(task: str, method: str, mean: float | None, *more: str) -> JobResult:
    job = PlannedJob(f"{task}-{method}", (f"target={task}", f"search={method}", *more), {}, task, method)
    spread = None if mean is None else Spread(mean, 0.2, 4)
    return JobResult(job, True, 4, 4, 0, spread, None, 100)


def test_the_best_job_of_each_task_is_a_command_to_copy() -> None:
    found = [
        result("cube", "rdm", -3.0),
        result("cube", "bfts", -1.0, "task=a b", "output=m", "resume=true"),
        result("bowl", "rdm", None),
        result("bowl", "lns", -0.5),
    ]
    assert best_commands(found, ["--config-dir", "conf"]) == [
        "best of cube: origami-lab --config-dir conf target=cube search=bfts 'task=a b'"
    ]  # of the bowl there is nothing to choose from


def test_means_are_rounded_to_what_they_are_worth() -> None:
    out = io.StringIO()
    console = Console(file=out, width=100)
    console.print(table_of_jobs([result("cube", "rdm", -3.14159), result("cube", "bfts", -1.0)], console))
    assert "-3.1 ± 0.2" in out.getvalue()
