"""The command: what it refuses, how, and that nothing is left behind."""

from __future__ import annotations

import subprocess
import sys
from pathlib import Path

import pytest

from origami_lab.cli import main

BOWL = "target=bowl"
REFUSED: list[tuple[list[str], str, str]] = [
    # arguments, how the line begins, what else it says
    (["target=bowll"], "target=bowll:", "must be one of bowl, cube, mesh, none, pyramid; did you mean bowl?"),
    ([], "target=none:", "target=bowl"),
    ([BOWL, "search=bfs"], "search=bfs:", "bfts, dfts, rdm"),
    ([BOWL, "objective=bucket"], "objective=bucket:", "shape"),
    ([BOWL, "symmetry=z"], "symmetry=z:", "none, x, xy, xyd, y"),
    ([BOWL, "start=circle"], "start=circle:", "crease, square"),
    ([BOWL, "tracking=wandb"], "tracking=wandb:", "mlflow, none"),
    (["traget=bowl"], "traget=bowl:", "did you mean target?"),
    ([BOWL, "bugdet=3"], "bugdet=3:", "did you mean budget?"),
    ([BOWL, "board.sise=9"], "board.sise=9:", "did you mean board.size?"),
    ([BOWL, "seed=9..0"], "seed=9..0:", "0..9"),
    ([BOWL, "seed=abc"], "seed=abc:", "0..9"),
    ([BOWL, "seed=-1"], "seed=-1:", "negative"),
    ([BOWL, "seed=[1,1]"], "seed=[1,1]:", "twice"),
    ([BOWL, "seed=0,3"], "seed=0,3:", "seed=[0,3]"),
    ([BOWL, "board.size=8"], "board.size=8:", "odd"),
    ([BOWL, "board.size=3"], "board.size=3:", "from 5"),
    ([BOWL, "board.size=1000001"], "board.size=1000001:", "to 201"),
    ([BOWL, "board.size=nine"], "board.size=nine:", "odd"),
    ([BOWL, "budget=-5"], "budget=-5:", "from 1"),
    ([BOWL, "budget=0"], "budget=0:", "from 1"),
    ([BOWL, "budget="], "budget=:", "whole number"),
    ([BOWL, "max_crease_length=0"], "max_crease_length=0:", "at least 1"),
    ([BOWL, "max_crease_length=-1"], "max_crease_length=-1:", "at least 1"),
    ([BOWL, "max_crease_length=long"], "max_crease_length=long:", "null"),
    ([BOWL, "driving_angle.max=180"], "driving_angle.max=180:", "180 degrees"),
    ([BOWL, "driving_angle.fixed=0"], "driving_angle.fixed=0:", "180 degrees"),
    ([BOWL, "driving_angle.count=0"], "driving_angle.count=0:", "from 1"),
    ([BOWL, "workers=0"], "workers=0:", "auto"),
    ([BOWL, "workers=many"], "workers=many:", "auto"),
    ([BOWL, "stuck=maybe"], "stuck=maybe:", "score, penalise"),
    ([BOWL, "certify=all"], "certify=all:", "improvements, none"),
    ([BOWL, "objective.distance=l2"], "objective.distance=l2:", "vertex, surface, sampled"),
    ([BOWL, "objective_seconds=0"], "objective_seconds=0:", "seconds above 0"),
    ([BOWL, "source_action=perhaps"], "source_action=perhaps:", "true or false"),
    ([BOWL, "resume=true"], "resume=true:", "output=DIR"),
    ([BOWL, "task=a/b"], "task=a/b:", "word"),
    (["target=mesh"], "target.path=(nothing):", "must be given"),
    ([BOWL, "target=["], "target=[:", "cannot be read"),
    (["+target=bowl"], "target=twice:", "once"),
    ([BOWL, "start=crease"], "symmetry=xyd:", "none or y"),
    ([BOWL, "search._target_=no.such.Thing"], "search=no.such.Thing:", "no"),
    ([BOWL, "+search.wings=2"], "search=", "wings"),
    ([BOWL, "objective._target_=tests.experiment.fakes.NoObjective", "~objective.distance"], "objective=", ""),
    (["bowl"], "command=bowl:", "dashboard"),
    (["nosuch/config.yaml"], "configuration=nosuch/config.yaml:", "no such file"),
    ([BOWL, "--frobnicate"], "flag=--frobnicate:", "--help"),
    (["-m", "target=bowl,cube", "board.size=9,8"], "board.size=8:", "odd"),
    (["-m", "target=bowl,ball"], "target=ball:", "bowl"),
    (["-m", "target=cube", "start.size=1,9"], "start.size=9:", "from 1 to 3"),
    (["dashboard"], "directory=", "results/mlflow.db"),
    (["dashboard", "--port", "70000", "--uri", "http://localhost:1"], "--port=70000:", "65535"),
    (["dashboard", "--uri", "sqlite:///nosuch.db"], "--uri=sqlite:///nosuch.db:", "no such file"),
]


@pytest.fixture(autouse=True)
def _elsewhere(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(tmp_path)


def assert_refused(capsys: pytest.CaptureFixture[str], arguments: list[str], begin: str, also: str) -> None:
    code = main(arguments)
    out, err = capsys.readouterr()
    assert code == 2, err
    assert out == ""
    assert err.count("\n") == 1, err
    assert err.startswith(f"error: {begin}")
    assert also in err
    assert "Traceback" not in err
    assert list(Path.cwd().rglob("*")) == []


@pytest.mark.parametrize(("arguments", "begin", "also"), REFUSED, ids=[" ".join(r[0]) or "-" for r in REFUSED])
def test_refused_in_one_line(capsys: pytest.CaptureFixture[str], arguments: list[str], begin: str, also: str) -> None:
    assert_refused(capsys, arguments, begin, also)


@pytest.mark.parametrize(
    ("arguments", "begin", "also"),
    [
        (["target=cube", "start.size=9"], "start.size=9:", "from 1 to 3"),
        (["target=mesh", "target.path=nosuch.stl"], "target.path=nosuch.stl:", "no such file"),
        ([BOWL, "output=/proc/no/such/place"], "output=/proc/no/such/place:", "can be written"),
        ([BOWL, f"output={Path(__file__).parent}", "resume=true"], "output=", "must be the folder of a run"),
    ],
)
def test_refused_by_the_parts_themselves(
    capsys: pytest.CaptureFixture[str], arguments: list[str], begin: str, also: str
) -> None:
    assert_refused(capsys, arguments, begin, also)


def test_an_empty_mesh_is_refused(capsys: pytest.CaptureFixture[str]) -> None:
    Path("empty.stl").write_bytes(b"")
    assert main(["target=mesh", "target.path=empty.stl"]) == 2
    err = capsys.readouterr().err
    assert err.startswith("error: target.path=empty.stl:")
    assert err.count("\n") == 1
    assert [file.name for file in Path.cwd().iterdir()] == ["empty.stl"]


def test_a_process_of_its_own_says_the_same() -> None:
    done = subprocess.run(
        [sys.executable, "-m", "origami_lab", BOWL, "seed=9..0"], capture_output=True, text=True, check=False
    )
    assert (done.returncode, done.stdout) == (2, "")
    assert done.stderr == "error: seed=9..0: the range runs backwards; must be 0..9\n"


def test_help_says_what_it_is_with_groups_keys_and_examples(capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["--help"]) == 0
    out = capsys.readouterr().out
    for text in ("rigid origami", "seed=0..9", "target: bowl, cube", "budget: 500000", "dashboard", "-m"):
        assert text in out
    assert all(len(line) <= 120 for line in out.splitlines())
    assert list(Path.cwd().iterdir()) == []


def test_cfg_job_prints_the_configuration_and_runs_nothing(capsys: pytest.CaptureFixture[str]) -> None:
    assert main([BOWL, "seed=0..9", "--cfg", "job"]) == 0
    out = capsys.readouterr().out
    assert "seed: 0..9" in out
    assert "max_crease_length: 2.9" in out
    assert list(Path.cwd().iterdir()) == []


def test_flags_may_stand_anywhere(capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["--cfg", "job", BOWL, "--resolve", "budget=7"]) == 0
    out = capsys.readouterr().out
    assert "budget: 7" in out
    assert "task: bowl" in out


def test_version(capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["--version"]) == 0
    assert capsys.readouterr().out.startswith("origami-lab ")


def test_a_subcommand_has_help(capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["dashboard", "--help"]) == 0
    assert "--uri" in capsys.readouterr().out
