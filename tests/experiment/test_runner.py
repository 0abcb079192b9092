"""Whole experiments, small: what is on disk, that it does not depend on the workers, and that it survives."""

from __future__ import annotations

import csv
import json
import math
import os
import shutil
import signal
import subprocess
import sys
import time
from collections import Counter
from collections.abc import Callable
from pathlib import Path
from typing import Any

import pytest
from omegaconf import OmegaConf

from origami_lab.config.compose import compose_settings
from origami_lab.config.instantiate import build_parts
from origami_lab.config.settings import read_settings
from origami_lab.experiment.trial import run_trial
from origami_lab.fold_format.writer import read_fold
from origami_lab.game.game import Game
from origami_lab.runs.result import load
from origami_lab.runs.run_folder import RunFolder
from origami_lab.runs.trial_row import COLUMNS, read_trials
from origami_lab.verification import verify_design as checking
from origami_lab.verification.certificate import Certificate, Check
from origami_lab.verification.verify_design import verify
from tests.small_runs import SMALL, TIMINGS, inside, run

pytestmark = pytest.mark.slow

TRIAL_FILES = {
    *("best.fold", "motion.fold", "actions.json", "curve.csv", "result.json", "search.npz"),
    *("pattern.png", "folded.png", "motion.gif", "pattern.svg", "best.html", "certificate.json"),
}
ROOT = Path(__file__).parents[2]
"""The working directory where parts of tests/experiment/fakes.py are the user's own."""
OWN_OBJECTIVE = (
    *("--config-dir", str(Path(__file__).parent / "conf")),
    *("board=9x9", "symmetry=xy", "search=rdm", "tracking=none"),
    "trust=origami-lab",  # installed to be developed in place, it has these tests, too
)


def untimed(file: Path) -> list[dict[str, Any]]:
    return [{k: v for k, v in row.values().items() if k not in TIMINGS} for row in read_trials(file)]


def background(folder: Path, *arguments: str, before: Callable[[], None] | None = None) -> subprocess.Popen[str]:
    """The command in a process group of its own, as a shell would start it."""
    environment = {**os.environ, "PYTHONPATH": str(ROOT)}
    command = [sys.executable, "-m", "origami_lab", *arguments]

    def prepare() -> None:
        signal.signal(signal.SIGINT, signal.SIG_DFL)  # a shell's background jobs ignore it
        if before is not None:
            before()

    return subprocess.Popen(
        command,
        cwd=folder,
        env=environment,
        start_new_session=True,
        stderr=subprocess.PIPE,
        text=True,
        preexec_fn=prepare,
    )


def wait_for(condition: Any, process: subprocess.Popen[str], patience: float = 120.0) -> None:
    deadline = time.monotonic() + patience
    while not condition():
        assert time.monotonic() < deadline, "it took too long"
        assert process.poll() is None, process.stderr.read() if process.stderr else ""
        time.sleep(0.02)


def test_what_is_on_disk(tracked: Path) -> None:
    out = tracked / "out"
    names = {file.name for file in out.iterdir()}
    assert names == {
        "config.yaml",
        "target.ply",
        "trials.csv",
        "summary.json",
        "tracking.json",
        "index.html",
        "index.data",
    } | {f"seed={seed}" for seed in range(3)}
    for seed in range(3):
        assert {file.name for file in (out / f"seed={seed}").iterdir()} == TRIAL_FILES
    rows = read_trials(out / "trials.csv")
    assert list(rows[0].values()) == list(COLUMNS)
    assert [row.seed for row in rows] == [0, 1, 2]
    for row in rows:
        assert row.interactions == 400
        assert 0 < row.interactions_to_best <= 400
        assert row.status == "ok"
        assert 1 <= row.reach <= 10
        # a driving angle is one of ten, in degrees
        assert row.driving_angle * 10 / math.degrees(3.14) == pytest.approx(
            round(row.driving_angle * 10 / math.degrees(3.14))
        )
        # vertices − edges + panels = 1 for a disc, and every edge is a crease or on the boundary
        assert row.creases < row.vertices + row.panels - 1


def test_summary_says_what_the_table_says(tracked: Path) -> None:
    summary = json.loads((tracked / "out/summary.json").read_text())
    values = [row.return_ for row in read_trials(tracked / "out/trials.csv")]
    mean = sum(values) / 3
    std = math.sqrt(sum((value - mean) ** 2 for value in values) / 2)
    assert summary["returns"]["return"] == {"mean": pytest.approx(mean), "std": pytest.approx(std), "n": 3}
    assert summary["best"]["return"] == max(values)
    assert summary["trials"] == {"ok": 3}
    assert summary["interactions"] == 1200
    assert "target=pyramid" in summary["command"]
    assert "numpy" in summary["versions"]


def test_actions_replay_to_the_return_and_the_curve_ends_there(tracked: Path) -> None:
    from origami_lab.objectives.objective import bind

    parts = build_parts(read_settings(OmegaConf.create(OmegaConf.load(tracked / "out/config.yaml"))))  # type: ignore[arg-type]
    for row in read_trials(tracked / "out/trials.csv"):
        folder = tracked / f"out/seed={row.seed}"
        saved = json.loads((folder / "actions.json").read_text())
        states = parts.game.replay(saved["actions"])
        evaluator = bind(parts.objective, parts.game)
        memos = evaluator.new_memos(1)
        evaluator.clear(memos, 0)
        score = evaluator.score(states, memos, 0)
        assert score.value == pytest.approx(row.return_, abs=1e-12)
        assert score.angle == saved["angle"]
        with (folder / "curve.csv").open() as file:
            curve = [{key: float(value) for key, value in point.items()} for point in csv.DictReader(file)]
        assert curve[-1] == {
            "interactions": 400,
            "return": row.return_,
            "driving_angle": row.driving_angle,
        }
        steps = [(point["interactions"], point["return"]) for point in curve]
        assert steps == sorted(steps)


def test_the_same_with_two_workers(tracked: Path, tmp_path: Path) -> None:
    assert run(tmp_path, *SMALL, "seed=0..2", "workers=2", "tracking=none", "output=out") == 0
    assert untimed(tmp_path / "out/trials.csv") == untimed(tracked / "out/trials.csv")
    for seed in range(3):
        for name in ("best.fold", "curve.csv"):
            ours, theirs = (place / f"out/seed={seed}" / name for place in (tmp_path, tracked))
            assert ours.read_bytes() == theirs.read_bytes()


def test_every_best_has_its_certificate_and_viewer(tracked: Path, tmp_path: Path) -> None:
    out = tracked / "out"
    rows = read_trials(out / "trials.csv")
    for row in rows:
        found = json.loads((out / f"seed={row.seed}/certificate.json").read_text())
        assert (found["file"], found["verdict"]) == ("best.fold", row.certificate)
        assert found == {**verify(out / f"seed={row.seed}/best.fold").to_json(), "file": "best.fold"}
    # with the target and the motion, and what the command makes of the folder
    for kind, name in (("html", "best.html"), ("svg", "pattern.svg")):
        assert run(tmp_path, "export", str(out / "seed=0"), "--to", kind, "--output", str(tmp_path / f"a.{kind}")) == 0
        assert (tmp_path / f"a.{kind}").read_bytes() == (out / "seed=0" / name).read_bytes()
    assert '"target":{' in (out / "seed=0/best.html").read_text()
    assert "<dt>return</dt>" in (out / "seed=0/best.html").read_text()
    counts = Counter(row.certificate for row in rows)
    assert json.loads((out / "summary.json").read_text())["certificates"] == counts
    assert counts["certified"] > 0


@pytest.mark.parametrize("fault", ["raises", "refutes"])
def test_what_a_certificate_says_never_costs_a_trial(
    fault: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    def faulty(path: Path, thickness: float = 0.0) -> Certificate:
        if fault == "raises":
            raise RecursionError("too deep")
        return Certificate(str(path), (Check("crossing", "refuted", "panels 1 and 2 cross at 5°", {}, (1, 2), 5.0),))

    monkeypatch.setattr(checking, "verify", faulty)
    settings = compose_settings([*SMALL, "tracking=none", f"output={tmp_path / 'out'}"])
    with RunFolder.opened(settings) as folder:
        row, warnings = run_trial(settings, 0, folder)
    names = {file.name for file in folder.trial(0).iterdir()}
    assert row.status == "ok"
    if fault == "raises":
        assert (row.certificate, names) == ("not checked", TRIAL_FILES - {"certificate.json"})
        assert warnings == ["no certificate.json: RecursionError: too deep"]
    else:
        assert (row.certificate, names) == ("refuted", TRIAL_FILES)
        (warning,) = warnings
        assert warning.startswith("its best design is refuted: crossing: panels 1 and 2 cross at 5°")


def test_a_motion_that_breaks_off_between_the_driving_angles_never_costs_a_trial(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """What certify=none lets through."""

    def broken(*arguments: object) -> None:
        raise ValueError("the design does not reach a driving angle of 7 degrees")

    monkeypatch.setattr(Game, "motion", broken)
    settings = compose_settings([*SMALL, "tracking=none", f"output={tmp_path / 'out'}"])
    with RunFolder.opened(settings) as folder:
        row, warnings = run_trial(settings, 0, folder)
    assert row.status == "ok"
    assert {file.name for file in folder.trial(0).iterdir()} == TRIAL_FILES
    assert [warning.partition(":")[0] for warning in warnings] == [
        "its motion breaks off between the game's driving angles, which are all it shows"
    ]
    best, motion = (read_fold(folder.trial(0) / name) for name in ("best.fold", "motion.fold"))
    assert len(motion.frames) == len(best.frames) > 1


def test_runs_of_before_there_were_certificates_go_on(tracked: Path, tmp_path: Path) -> None:
    shutil.copytree(tracked / "out", tmp_path / "out")
    later = list(COLUMNS)[list(COLUMNS).index("certificate") :]
    config = (tmp_path / "out/config.yaml").read_text()
    assert "files: all\n" in config
    (tmp_path / "out/config.yaml").write_text(config.replace("files: all\n", ""))
    for file in (tmp_path / "out").glob("seed=*/result.json"):
        row = json.loads(file.read_text())
        for name in later:
            del row[name]
        file.write_text(json.dumps(row))
        for name in ("certificate.json", "best.html", "pattern.svg"):
            (file.parent / name).unlink()
    lines = (tmp_path / "out/trials.csv").read_text().splitlines()
    assert lines[0].endswith(",".join(["", *later]))
    (tmp_path / "out/trials.csv").write_text("".join(line.rsplit(",", len(later))[0] + "\n" for line in lines))
    assert load(tmp_path / "out").trials["certificate"].isna().all()
    assert run(tmp_path, "report", "out") == 0
    assert "no certificate" in (tmp_path / "out/report/index.html").read_text()
    (tmp_path / "out/tracking.json").unlink()
    assert run(tmp_path, "dashboard", "--sync", "out") == 0
    assert run(tmp_path, *SMALL, "tracking=none", "output=out", "resume=true", "seed=0..3") == 0
    verdicts = load(tmp_path / "out").trials["certificate"]
    assert verdicts.isna().tolist() == [True, True, True, False]


def test_designs_only(tracked: Path, tmp_path: Path) -> None:
    """The same trials with no files but those that the others can be made from; ``files`` may change on resume."""
    arguments = (*SMALL, "tracking=none", "workers=1", "output=out")
    assert run(tmp_path, *arguments, "files=designs", "seed=0") == 0
    kept = {"best.fold", "actions.json", "curve.csv", "result.json", "search.npz"}
    assert {file.name for file in (tmp_path / "out/seed=0").iterdir()} == kept
    for name in sorted(kept - {"result.json"}):
        assert (tmp_path / "out/seed=0" / name).read_bytes() == (tracked / "out/seed=0" / name).read_bytes()
    assert run(tmp_path, *arguments, "resume=true", "seed=1") == 0
    assert {file.name for file in (tmp_path / "out/seed=1").iterdir()} == TRIAL_FILES
    rows = untimed(tmp_path / "out/trials.csv")
    assert [row["return"] for row in rows] == [row["return"] for row in untimed(tracked / "out/trials.csv")[:2]]


def test_resume_runs_what_is_missing_only(tracked: Path, tmp_path: Path) -> None:
    shutil.copytree(tracked / "out", tmp_path / "out")
    shutil.rmtree(tmp_path / "out/seed=1")
    before = (tmp_path / "out/seed=0/result.json").stat().st_mtime_ns
    same = (*SMALL, "tracking=none", "output=out")
    assert run(tmp_path, *same, "seed=0..3") == 2
    assert run(tmp_path, *same, "seed=0..3", "budget=399", "resume=true") == 2
    # it keeps to its own seeds, named or not
    summary = tmp_path / "out/summary.json"
    took = json.loads(summary.read_text())["seconds"]
    assert run(tmp_path, *same, "resume=true") == 0
    assert json.loads(summary.read_text())["seconds"] >= took > 0
    assert untimed(tmp_path / "out/trials.csv") == untimed(tracked / "out/trials.csv")
    assert OmegaConf.load(tmp_path / "out/config.yaml").seed == "0..2"
    assert run(tmp_path, *same, "seed=3", "resume=true") == 0
    assert (tmp_path / "out/seed=0/result.json").stat().st_mtime_ns == before
    rows = untimed(tmp_path / "out/trials.csv")
    assert rows[:3] == untimed(tracked / "out/trials.csv")
    assert [row["seed"] for row in rows] == [0, 1, 2, 3]
    assert OmegaConf.load(tmp_path / "out/config.yaml").seed == "0..3"


def test_a_target_that_has_changed_is_not_resumed(
    tracked: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    shutil.copytree(tracked / "out", tmp_path / "out")
    shutil.rmtree(tmp_path / "out/seed=1")
    file = tmp_path / "out/target.ply"
    file.write_bytes(file.read_bytes()[:-4] + b"\1\0\0\0")
    assert run(tmp_path, *SMALL, "tracking=none", "output=out", "resume=true") == 2
    assert "the target has changed since" in capsys.readouterr().err
    assert not (tmp_path / "out/seed=1").exists()


def test_a_start_pattern_that_has_changed_is_not_resumed(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    game = {"symmetry": "xy", "start": {"_target_": "origami_lab.game.Square", "size": 1}}
    moves = [{"kind": "place", "value": 1, "sign": 1}]
    (tmp_path / "start.json").write_text(json.dumps({"game": game, "moves": moves}))
    start = ["target=cube", "search=rdm", "budget=300", "start=file", "start.path=start.json"]
    same = [*start, "tracking=none", "output=out", "workers=1"]
    assert run(tmp_path, *same) == 0
    assert run(tmp_path, *same, "seed=0..1", "resume=true") == 0
    moves[0]["sign"] = -1
    (tmp_path / "start.json").write_text(json.dumps({"game": game, "moves": moves}))
    assert run(tmp_path, *same, "seed=0..2", "resume=true") == 2
    assert "the start pattern has changed since" in capsys.readouterr().err
    assert not (tmp_path / "out/seed=2").exists()


def test_a_finished_configuration_runs_again(tracked: Path, tmp_path: Path) -> None:
    assert run(tmp_path, str(tracked / "out/config.yaml"), "seed=2", "tracking=none", "output=again") == 0
    assert untimed(tmp_path / "again/trials.csv") == untimed(tracked / "out/trials.csv")[2:]
    # every job of a multirun is checked before the first one starts
    assert run(tmp_path, str(tracked / "out/config.yaml"), "-m", "budget=100,-5", "tracking=none") == 2
    assert [file.name for file in tmp_path.iterdir()] == ["again"]
    assert run(tmp_path, str(tracked / "out/config.yaml"), "search=bfts") == 2


def test_default_output(tmp_path: Path, capfd: pytest.CaptureFixture[str]) -> None:
    assert run(tmp_path, *SMALL, "seed=1", "budget=60", "tracking=none") == 0
    (folder,) = map(Path, capfd.readouterr().out.splitlines())
    assert folder.parent == Path("results/pyramid/rdm")
    assert (tmp_path / folder / "seed=1/best.fold").is_file()
    assert [file.name for file in tmp_path.iterdir()] == ["results"]


def test_an_objective_and_an_endless_searcher_of_ones_own(tmp_path: Path) -> None:
    endless = "search._target_=tests.experiment.fakes.Endless"
    assert (
        run(
            ROOT, *OWN_OBJECTIVE, f"output={tmp_path}/out", "objective=height", "budget=400", "verbosity=quiet", endless
        )
        == 0
    )
    (row,) = read_trials(tmp_path / "out/trials.csv")
    assert (row.interactions, row.status) == (400, "ok")
    assert row.return_ > 0
    assert row.return_vertex is row.return_surface is row.return_sampled is None
    assert not (tmp_path / "out/target.ply").exists()


def test_what_an_objective_of_ones_own_has_written_is_not_lost(tmp_path: Path) -> None:
    noting = ("objective=noting", f"objective.notes={tmp_path}/notes")
    assert run(ROOT, *OWN_OBJECTIVE, f"output={tmp_path}/out", *noting, "budget=50") == 0
    assert set((tmp_path / "notes").read_text().splitlines()) == {"asked"}


def test_a_bad_objective_fails_its_trials_and_nothing_else(tmp_path: Path) -> None:
    (tmp_path / "notes").mkdir()
    ways = "[raises,gives_nan,dies,leaves,hangs_in_c]"
    arguments = ("objective=broken", f"objective.ways={ways}", f"objective.notes={tmp_path}/notes", "budget=400")
    assert (
        run(ROOT, *OWN_OBJECTIVE, f"output={tmp_path}/out", *arguments, "seed=0..5", "workers=1", "objective_seconds=1")
        == 1
    )
    assert [row.status for row in read_trials(tmp_path / "out/trials.csv")] == [
        "failed: RuntimeError: the kettle is empty",
        "failed: objective=Broken: score returned NaN; it must return a number",
        "failed: the worker process died (exit code 3)",
        "failed: SystemExit: 4",
        "failed: the objective took longer than objective_seconds=1 in one call",
        "ok",
    ]
    traces = [seed for seed in range(6) if (tmp_path / f"out/seed={seed}.error.txt").exists()]
    assert traces == [0, 1, 3]


def test_a_folder_that_vanishes_costs_one_line_and_exit_code_1(
    tmp_path: Path, capfd: pytest.CaptureFixture[str]
) -> None:
    arguments = ("objective=vandal", f"objective.folder={tmp_path}/out", "budget=400", "seed=0..1")
    assert run(ROOT, *OWN_OBJECTIVE, f"output={tmp_path}/out", *arguments) == 1
    out, err = capfd.readouterr()
    assert "failed" in out  # the table is printed all the same
    assert err.count(f"error: {tmp_path}/out could not be written: the folder is gone; 0 of 2 trials kept") == 1
    assert "Traceback" not in err
    assert not (tmp_path / "out").exists()


def test_a_file_that_cannot_be_written_fails_its_trial_only(tracked: Path, tmp_path: Path) -> None:
    resource = pytest.importorskip("resource")
    shutil.copytree(tracked / "out", tmp_path / "out")
    shutil.rmtree(tmp_path / "out/seed=1")
    before = (tmp_path / "out/seed=0/result.json").stat().st_mtime_ns
    limit = (2**17, 2**17)  # the motion's picture is larger
    arguments = (*SMALL, "seed=0..2", "tracking=none", "output=out", "resume=true")
    process = background(tmp_path, *arguments, before=lambda: resource.setrlimit(resource.RLIMIT_FSIZE, limit))
    _, err = process.communicate(timeout=120)
    assert process.returncode == 1
    assert err.count("error: out could not be written: a file would be larger than allowed; 2 of 3 trials kept") == 1
    assert "Traceback" not in err
    statuses = [row.status for row in read_trials(tmp_path / "out/trials.csv")]
    assert statuses == ["ok", "failed: cannot write its files: a file would be larger than allowed", "ok"]
    assert {file.name for file in (tmp_path / "out").glob("*seed*")} == {"seed=0", "seed=2"}
    assert (tmp_path / "out/seed=0/result.json").stat().st_mtime_ns == before


def test_ctrl_c_keeps_the_best_so_far(tmp_path: Path) -> None:
    arguments = ("objective=beacon", f"objective.file={tmp_path}/on", "budget=1e9", "seed=0..2", "workers=1")
    process = background(ROOT, *OWN_OBJECTIVE, f"output={tmp_path}/out", *arguments)
    wait_for((tmp_path / "on").exists, process)
    time.sleep(2.0)  # until the trial has reported
    os.killpg(process.pid, signal.SIGINT)
    assert process.wait(60) == 130
    (row,) = read_trials(tmp_path / "out/trials.csv")
    assert (row.seed, row.status) == (0, "stopped")
    assert {file.name for file in (tmp_path / "out/seed=0").iterdir()} == TRIAL_FILES - {"search.npz"}
    summary = json.loads((tmp_path / "out/summary.json").read_text())
    assert summary["interrupted"]
    assert summary["returns"] == {}
    assert "Traceback" not in (process.stderr.read() if process.stderr else "")


def test_the_second_sigterm_leaves_at_once_though_an_objective_hangs(tmp_path: Path) -> None:
    (tmp_path / "notes").mkdir()
    ways = ("objective=broken", "objective.ways=[hangs_in_c]", f"objective.notes={tmp_path}/notes", "budget=400")
    arguments = (*OWN_OBJECTIVE, f"output={tmp_path}/out", *ways, "seed=0..1", "workers=1", "objective_seconds=null")
    process = background(ROOT, *arguments)
    wait_for((tmp_path / "notes/hangs_in_c").exists, process)
    time.sleep(1.0)
    os.killpg(process.pid, signal.SIGTERM)
    time.sleep(1.0)
    os.killpg(process.pid, signal.SIGTERM)
    _, err = process.communicate(timeout=60)
    assert process.returncode == 130
    assert "Traceback" not in err
    assert json.loads((tmp_path / "out/summary.json").read_text())["interrupted"]
    assert not list((tmp_path / "out").glob(".*"))


def wait_for_group_to_end(group: int) -> None:
    for _ in range(300):
        try:
            os.killpg(group, 0)
        except ProcessLookupError:
            return
        time.sleep(0.1)
    raise AssertionError("the workers of a killed run are still there")


def test_kill_9_leaves_finished_trials_whole_and_resume_finishes(tracked: Path, tmp_path: Path) -> None:
    arguments = (*SMALL, "seed=0..2", "workers=1", "tracking=none", "output=out")
    process = background(tmp_path, *arguments)
    wait_for((tmp_path / "out/seed=0").exists, process)
    process.kill()
    process.wait(10)
    wait_for_group_to_end(process.pid)  # its worker notices, and may be writing until then
    with inside(tmp_path / "out"):
        for folder in Path().glob("seed=*"):
            assert {file.name for file in folder.iterdir()} == TRIAL_FILES
    assert run(tmp_path, *arguments, "resume=true") == 0
    assert untimed(tmp_path / "out/trials.csv") == untimed(tracked / "out/trials.csv")
    assert not list((tmp_path / "out").glob(".*"))
