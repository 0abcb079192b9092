"""A run folder whose process is killed before each of its file operations in turn."""

from __future__ import annotations

import json
import os
import shutil
import signal
import sys
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from origami_lab.config.settings import Settings
from origami_lab.errors import InputError
from origami_lab.runs.run_folder import RunFolder
from tests.small_runs import bare_settings, trial_row

pytestmark = pytest.mark.skipif(not hasattr(os, "fork"), reason="kills forked processes")

SEEDS = (0, 1)
EVENTS = ("open", "os.mkdir", "os.rename", "os.remove", "os.rmdir", "os.listdir", "os.scandir")
CONFIG = {"budget": 10, "seed": "0..1"}


def settings_for(output: Path) -> Settings:
    return bare_settings(seeds=SEEDS, output=output, resume=True, config=CONFIG)


def write_trial(folder: RunFolder, seed: int, status: str) -> None:
    with folder.new_trial(seed) as path:
        (path / "best.fold").write_text("{}")
        (path / "result.json").write_text(json.dumps(trial_row(seed, status=status).values()))


def run_all(output: Path) -> None:
    """What the runner does with a folder, without the trials' work. The first trial fails before it succeeds."""
    with RunFolder.opened(settings_for(output)) as folder:
        rows = folder.rows()
        folder.begin(CONFIG, TARGET, None)
        for seed in SEEDS:
            if seed not in rows or rows[seed].status != "ok":
                folder.write_error(seed, "Traceback")
                write_trial(folder, seed, "ok")
                rows[seed] = trial_row(seed)
            folder.write_trials(rows.values())
        folder.write_summary({"trials": 2})


class TARGET:
    vertices, faces = np.eye(3), np.array([[0, 1, 2]])


def contents(folder: Path) -> dict[str, bytes]:
    return {str(path.relative_to(folder)): path.read_bytes() for path in folder.rglob("*") if path.is_file()}


def killed_before(number: int, output: Path) -> bool:
    """Run in a process that is killed before its n-th file operation below ``output``; whether it was."""
    child = os.fork()
    if child == 0:
        left = number

        def hook(event: str, arguments: tuple[Any, ...]) -> None:
            nonlocal left
            if event in EVENTS and str(arguments[0]).startswith(str(output)):
                left -= 1
                if left < 0:
                    os.kill(os.getpid(), signal.SIGKILL)

        sys.addaudithook(hook)
        try:
            run_all(output)
        finally:
            os._exit(0)
    return os.WIFSIGNALED(os.waitpid(child, 0)[1])


@pytest.mark.slow
def test_whole_whenever_it_is_killed_and_the_same_command_goes_on(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(os, "fsync", lambda descriptor: None)  # no power is cut, and it takes most of the time
    begun, reference = tmp_path / "begun", tmp_path / "reference"
    with RunFolder.opened(settings_for(begun)) as folder:
        folder.begin(CONFIG, None, None)
        write_trial(folder, 1, "stopped")  # is replaced later on
    run_all(reference)
    wanted = contents(reference)
    wanted["config.yaml"] = wanted["config.yaml"].partition(b"\n")[2]  # its head names the folder
    for start in (None, begun):
        number = 0
        while True:
            output = tmp_path / f"run-{number}"
            if start is not None:
                shutil.copytree(start, output)
            if not killed_before(number, output):
                break
            check_whole(output, wanted, begun=start is not None)
            run_all(output)
            assert {path.name for path in output.iterdir()} == {path.name for path in reference.iterdir()}
            found = contents(output)
            found["config.yaml"] = found["config.yaml"].partition(b"\n")[2]
            assert found == wanted
            shutil.rmtree(output)
            number += 1
        assert number > 40
        shutil.rmtree(output)


def check_whole(output: Path, wanted: dict[str, bytes], begun: bool) -> None:
    """Nothing visible is half there, and the stopped trial is not lost."""
    visible = (
        {name: data for name, data in contents(output).items() if not name.startswith(".")} if output.exists() else {}
    )
    for name, data in visible.items():
        if name.endswith("config.yaml"):
            data = data.partition(b"\n")[2]
        header = wanted["trials.csv"].partition(b"\n")[0]
        assert (
            data == wanted.get(name)
            or (name.endswith(".error.txt") and data == b"Traceback")
            or (name == "trials.csv" and data.startswith(header) and data.endswith(b"\n"))
            or (name == "seed=1/result.json" and json.loads(data)["status"] == "stopped")
        ), name
    for seed in SEEDS:
        if (output / f"seed={seed}").exists():
            assert {file.name for file in (output / f"seed={seed}").iterdir()} == {"best.fold", "result.json"}
    if begun:
        with RunFolder.opened(settings_for(output)) as folder:
            assert 1 in folder.rows()


def test_a_second_process_is_refused_until_the_first_has_ended(tmp_path: Path) -> None:
    settings = settings_for(tmp_path / "run")
    with RunFolder.opened(settings):
        with pytest.raises(InputError, match=r"output=.*no running experiment"):
            run_all(tmp_path / "run")
        assert [file.name for file in (tmp_path / "run").iterdir()] == [".running"]
    run_all(tmp_path / "run")


def test_resuming_what_never_began(tmp_path: Path) -> None:
    run = tmp_path / "run"
    for names in ((), (".config.yaml.123.tmp",), (".seed=3.77.tmp", ".trials.csv.1.tmp", ".running")):
        run.mkdir()
        for name in names:
            (run / name).write_text("half")
        with RunFolder.opened(settings_for(run)) as folder:
            assert not folder.has_begun
        assert list(run.iterdir()) == []
        run.rmdir()
    with RunFolder.opened(settings_for(run)) as folder:
        assert folder.path.is_dir()
    for name in ("mine.txt", ".hidden", ".config.yaml.tmp"):
        (run / name).write_text("precious")
        with pytest.raises(InputError, match=r"must be the folder of a run"):
            run_all(run)
        assert [file.name for file in run.iterdir()] == [name]
        (run / name).unlink()
    (run / "config.yaml").write_text("{")
    with pytest.raises(InputError, match="cannot be read"):
        run_all(run)
