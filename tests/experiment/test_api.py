"""From Python: the same run as the command's, whatever the program around it does, and its results as objects."""

from __future__ import annotations

import json
import os
import shutil
import signal
import sqlite3
import subprocess
import sys
import time
from pathlib import Path
from typing import Any

import numpy as np
import pandas as pd
import pytest

import origami_lab
from origami_lab.cli import main
from origami_lab.errors import InputError
from origami_lab.file_names import PAGE_DATA
from origami_lab.fold_format.writer import read_fold, write_fold
from origami_lab.runs.trial_row import COLUMNS, KINDS, TrialRow, format_trials, read_trials
from tests.small_runs import SMALL, TIMINGS

ROOT = Path(__file__).parents[2]

MINE = """
from pathlib import Path

class Height:
    def __init__(self, beacon=None):
        self.beacon = beacon

    def score(self, sheet):
        if self.beacon:
            Path(self.beacon).touch()
        return float(sheet.points[-1][:, 2].max())
"""
MINE_YAML = "# @package _global_\ntask: mine\nobjective:\n  _target_: mine.Height\n"
OWN = ["objective=mine", "board=9x9", "symmetry=xy", "search=rdm", "budget=300", "tracking=none"]

# no `if __name__ == "__main__"`, a Hydra of its own, classes in the working directory, which is not the script's
PROGRAM = f"""
import json, sys, threading
import origami_lab
heavy = {{"numpy", "numba", "pandas", "hydra", "omegaconf", "mlflow", "scipy", "matplotlib", "rich"}} & set(sys.modules)
assert not heavy, heavy
from hydra import compose, initialize_config_dir
from hydra.core.global_hydra import GlobalHydra
from hydra.core.hydra_config import HydraConfig
from hydra.version import getbase
initialize_config_dir(sys.argv[1], version_base="1.2")
theirs, base, path = GlobalHydra.instance().hydra, getbase(), list(sys.path)

first = origami_lab.run([*{SMALL!r}, "seed=0..2", "workers=1", "output=out"])
found = []
own = [*{OWN!r}, "output=own"]
thread = threading.Thread(target=lambda: found.append(origami_lab.run(own, config_dir="conf")))
thread.start()
thread.join()

assert GlobalHydra.instance().hydra is theirs and getbase() == base and not HydraConfig.initialized()
assert compose("theirs").answer == 42
assert sys.path == path
for result in (first, *found):
    print(json.dumps([str(result.folder), result.exit_code, result.summary["command"], len(result.best.vertices)]))
"""


def untimed(file: Path) -> list[dict[str, Any]]:
    return [{k: v for k, v in row.values().items() if k not in TIMINGS} for row in read_trials(file)]


def own_parts(folder: Path) -> None:
    (folder / "conf/objective").mkdir(parents=True)
    (folder / "conf/objective/mine.yaml").write_text(MINE_YAML)
    (folder / "mine.py").write_text(MINE)


def program(folder: Path, source: str, *arguments: str, **options: Any) -> subprocess.Popen[str]:
    """A script in a folder of its own, started in ``folder``."""
    script = folder / "elsewhere" / "script.py"
    script.parent.mkdir()
    script.write_text(source)
    environment = {**os.environ, "PYTHONPATH": str(ROOT)}
    pipes: dict[str, Any] = {"stdout": subprocess.PIPE, "stderr": subprocess.PIPE, "text": True}
    return subprocess.Popen([sys.executable, str(script), *arguments], cwd=folder, env=environment, **pipes, **options)


@pytest.mark.slow
def test_a_program_runs_what_the_command_runs(tracked: Path, tmp_path: Path) -> None:
    own_parts(tmp_path)
    (tmp_path / "theirs").mkdir()
    (tmp_path / "theirs/theirs.yaml").write_text("answer: 42\n")
    process = program(tmp_path, PROGRAM, str(tmp_path / "theirs"))
    out, err = process.communicate(timeout=300)
    assert process.returncode == 0, err
    first, own = (json.loads(line) for line in out.splitlines())

    # the run of the command, file by file
    ours, theirs = tmp_path / "out", tracked / "out"
    assert first[:2] == [str(ours), 0]
    # the table is computed with the same bits; pictures and designs are the same bytes
    assert untimed(ours / "trials.csv") == untimed(theirs / "trials.csv")
    files = sorted(file.relative_to(theirs) for file in theirs.rglob("*") if file.is_file())
    assert files == sorted(file.relative_to(ours) for file in ours.rglob("*") if file.is_file())
    timed = {"trials.csv", "summary.json", "tracking.json", "result.json"}
    for file in files:
        if file.name not in timed and file.parent.name != PAGE_DATA:  # which says how long the trials took
            assert (ours / file).read_bytes() == (theirs / file).read_bytes(), file
    command = json.loads((theirs / "summary.json").read_text())["command"]
    assert first[2] == command
    # and the same runs in the store: one for the experiment, one a seed
    names = []
    for folder in (tmp_path, tracked):
        database = sqlite3.connect(folder / "results/mlflow.db")
        query = "SELECT name, status FROM runs JOIN experiments USING (experiment_id) ORDER BY runs.name"
        names.append(database.execute(query.replace("SELECT name", "SELECT runs.name")).fetchall())
        database.close()
    assert len(names[0]) == 4
    assert names[0] == names[1]

    assert own[:2] == [str(tmp_path / "own"), 0]
    assert own[2].endswith("output=own --config-dir conf")
    (row,) = read_trials(tmp_path / "own/trials.csv")
    folded = read_fold(tmp_path / "own/seed=0/best.fold").best.coords
    assert row.return_ == pytest.approx(folded[:, 2].max(), abs=1e-12)


def children_of(process: int) -> list[str]:
    return Path(f"/proc/{process}/task/{process}/children").read_text().split()


def command_of(process: str) -> bytes:
    return Path(f"/proc/{process}/cmdline").read_bytes()


@pytest.mark.slow
def test_ctrl_c_saves_and_returns(tmp_path: Path) -> None:
    own_parts(tmp_path)
    settings = [*OWN, "+objective.beacon=on", "budget=1e9", "seed=0..2", "workers=1", "output=out"]
    source = f"""
import origami_lab
result = origami_lab.run({settings!r}, config_dir="conf")
status = result.trials["status"].to_dict()
print(result.exit_code, status, len(result.best.vertices) > 3, origami_lab.load("out").exit_code)
"""
    process = program(tmp_path, source, start_new_session=True)
    for _ in range(6000):
        if (tmp_path / "on").exists() or process.poll() is not None:
            break
        time.sleep(0.02)
    time.sleep(2.0)  # until the trial has reported
    os.killpg(process.pid, signal.SIGINT)
    out, err = process.communicate(timeout=60)
    assert out.strip() == "130 {0: 'stopped'} True 130", err
    assert process.returncode == 0
    assert "stopping: saving the best so far" in err


@pytest.mark.slow
def test_the_second_ctrl_c_raises(tmp_path: Path) -> None:
    """Or a loop over experiments would go on to the next one."""
    own_parts(tmp_path)
    settings = [*OWN, "+objective.beacon=on", "budget=1e9", "seed=0", "workers=1", "output=out"]
    source = f"""
import origami_lab
try:
    origami_lab.run({settings!r}, config_dir="conf")
except KeyboardInterrupt:
    print("raised", origami_lab.load("out").exit_code)
"""
    process = program(tmp_path, source, start_new_session=True)
    for _ in range(6000):
        if (tmp_path / "on").exists() or process.poll() is not None:
            break
        time.sleep(0.02)
    worker = next(int(pid) for pid in children_of(process.pid) if b"spawn_main" in command_of(pid))
    os.kill(worker, signal.SIGSTOP)  # it saves nothing, so that there is time for a second one
    os.kill(process.pid, signal.SIGINT)
    time.sleep(1.0)
    os.kill(process.pid, signal.SIGINT)
    out, err = process.communicate(timeout=60)
    assert out.strip() == "raised 130", err


@pytest.mark.slow
def test_load_is_what_is_on_disk(tracked: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(tracked)
    result = origami_lab.load("out")
    monkeypatch.chdir(tmp_path)  # nothing depends on where one is afterwards
    assert result.folder == tracked / "out"
    assert result.exit_code == 0
    assert result.summary == json.loads((tracked / "out/summary.json").read_text())

    table = read_trials(tracked / "out/trials.csv")
    assert [result.trials.index.name, *result.trials.columns] == list(COLUMNS)
    assert list(result.trials.index) == [0, 1, 2]
    for row in table:
        for name, value in row.values().items():
            if name != "seed":
                found = result.trials.loc[row.seed, name]
                assert pd.isna(found) if value is None else found == value
    for name in result.trials.columns:
        kind = {int: "Int64", float: "float64", str: "string"}[KINDS[name]]
        assert str(result.trials[name].dtype) == kind

    # a replayed design is the one that was found, to the last byte of its file
    assert list(result.designs) == [0, 1, 2]
    for seed, design in result.designs.items():
        write_fold(tmp_path / "again.fold", design)
        assert (tmp_path / "again.fold").read_bytes() == (tracked / f"out/seed={seed}/best.fold").read_bytes()
        assert result.designs[seed] is design
    best = max(table, key=lambda row: (row.return_, -row.seed))
    assert result.best is result.designs[best.seed]
    assert np.degrees(result.best.driving_angles[result.best.best]) == pytest.approx(best.driving_angle, abs=1e-9)
    for text in ("pyramid rdm", "3 ok", f"{best.return_:.4f} (seed {best.seed})", str(tracked / "out")):
        assert text in repr(result)
    with pytest.raises(KeyError):
        result.designs[7]


@pytest.mark.slow
def test_failed_and_unfinished_runs_load_too(tracked: Path, tmp_path: Path) -> None:
    out = tmp_path / "out"
    shutil.copytree(tracked / "out", out)
    rows = read_trials(out / "trials.csv")
    shutil.rmtree(out / "seed=1")
    rows[1] = TrialRow.failed(1, "it broke")
    (out / "trials.csv").write_text(format_trials(rows))
    failed = origami_lab.load(out)
    assert failed.exit_code == 1
    assert failed.trials.loc[1, "status"] == "failed: it broke"
    assert failed.trials.isna().loc[1, ["return", "vertices"]].all()
    assert str(failed.trials["vertices"].dtype) == "Int64"
    assert list(failed.designs) == [0, 2]
    assert "1 failed, 2 ok" in repr(failed)

    # killed before its first summary
    (out / "trials.csv").unlink()
    (out / "summary.json").unlink()
    killed = origami_lab.load(out)
    assert (killed.exit_code, killed.summary, list(killed.trials.index)) == (130, {}, [0, 2])
    saved = json.loads((out / "seed=0/actions.json").read_text())
    saved["actions"].append(0)
    (out / "seed=0/actions.json").write_text(json.dumps(saved))
    with pytest.raises(InputError, match=r"cannot be replayed: action \d+: action 0 is not legal"):
        killed.designs[0]
    row = json.loads((out / "seed=2/result.json").read_text())
    (out / "seed=2/result.json").write_text(json.dumps({**row, "status": "no design"}))
    shutil.rmtree(out / "seed=0")
    with pytest.raises(LookupError):
        _ = origami_lab.load(out).best
    shutil.rmtree(out / "seed=2")
    empty = origami_lab.load(out)
    assert (len(empty.trials), len(empty.designs), empty.exit_code) == (0, 0, 130)
    assert str(out) in repr(empty)
    with pytest.raises(LookupError):
        _ = empty.best


def test_no_run_is_refused(tmp_path: Path) -> None:
    with pytest.raises(InputError, match="must be the folder of a run"):
        origami_lab.load(tmp_path)


@pytest.mark.parametrize(
    "overrides",
    [
        ["target=bowll"],
        ["traget=bowl"],
        ["target=bowl", "seed=9..0"],
        ["target=bowl", "seed=0,3"],
        ["target=["],
        ["=5"],
        ["hydra=1"],
        ["+target=bowl"],
        ["target=mesh"],
        ["target=bowl", "start=crease"],
        [],
    ],
    ids=" ".join,
)
def test_errors_are_the_commands(
    overrides: list[str], tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.chdir(tmp_path)
    assert main(overrides) == 2
    with pytest.raises(InputError) as refused:
        origami_lab.run(overrides)
    assert isinstance(refused.value, ValueError)
    assert capsys.readouterr().err == f"error: {refused.value}\n"
    assert list(tmp_path.iterdir()) == []


@pytest.mark.parametrize(
    ("overrides", "options", "expected"),
    [
        (["-m", "target=bowl,cube"], {}, "overrides=-m: must be one experiment; call run once for each"),
        (["target=bowl", "--cfg=job"], {}, "overrides=--cfg=job: flags are the command's"),
        (["bowl"], {}, "overrides=bowl: must be settings like target=bowl"),
        ("target=bowl", {}, "overrides=target=bowl: must be a list of texts"),
        (["target=bowl"], {"config_dir": "nosuch"}, "config_dir=nosuch: there is no such folder"),
    ],
)
def test_what_only_the_command_takes_is_refused(
    overrides: Any, options: dict[str, Any], expected: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.chdir(tmp_path)
    with pytest.raises(InputError) as refused:
        origami_lab.run(overrides, **options)
    assert str(refused.value).startswith(expected)
    assert list(tmp_path.iterdir()) == []


def test_the_package_knows_its_names() -> None:
    assert {"run", "load", "Result", "InputError", "__version__"} <= set(dir(origami_lab))
    assert origami_lab.InputError is InputError
    with pytest.raises(AttributeError, match="nosuch"):
        _ = origami_lab.nosuch
