"""The command: what it refuses, how, and that nothing is left behind."""

from __future__ import annotations

import os
import subprocess
import sys
from pathlib import Path

import pytest

from origami_lab.cli import main
from origami_lab.commands import COMMANDS
from origami_lab.config.option_files import explained_keys, groups, options_of, own_keys

BOWL = "target=bowl"
REFUSED: list[tuple[list[str], str, str]] = [
    # arguments, how the line begins, what else it says
    (["target=bowll"], "target=bowll:", "did you mean bowl?"),
    ([], "target=none:", "target=bowl"),
    (["+experiment=paper/bowll"], "experiment=paper/bowll:", "did you mean paper/bowl?"),
    ([BOWL, "search=bfs"], "search=bfs:", "did you mean bfts?"),
    ([BOWL, "objective=buckets"], "objective=buckets:", "did you mean bucket?"),
    ([BOWL, "symmetry=z"], "symmetry=z:", "none, x, xy, xyd, y"),
    ([BOWL, "start=circle"], "start=circle:", "crease, file, panel, rectangle, square"),
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
    ([BOWL, "board.width=8"], "board.width=8:", "odd"),
    ([BOWL, "board.height=203"], "board.height=203:", "to 201, or null"),
    ([BOWL, "board.height=23"], "symmetry=xyd:", "25×23"),
    ([BOWL, "board.size=9", "board.width=13"], "symmetry=xyd:", "13×9"),
    ([BOWL, "board=9x15"], "board=9x15:", "board.width=9 board.height=15"),
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
    ([BOWL, "source_action=perhaps"], "source_action=perhaps:", "axis (or true) or boundary"),
    ([BOWL, "resume=true"], "resume=true:", "output=DIR"),
    ([BOWL, "task=a/b"], "task=a/b:", "word"),
    (["target=mesh"], "target.path=(nothing):", "must be given"),
    ([BOWL, "target=["], "target=[:", "cannot be read"),
    (["+target=bowl"], "target=twice:", "once"),
    ([BOWL, "start=crease"], "symmetry=xyd:", "none or y"),
    ([BOWL, "search._target_=no.such.Thing"], "search=no.such.Thing:", "no"),
    ([BOWL, "+search.wings=2"], "search=", "wings"),
    ([BOWL, "objective._target_=tests.experiment.fakes.NoObjective"], "objective=", ""),
    (["bowl"], "command=bowl:", "dashboard"),
    (["dashbord"], "command=dashbord:", "did you mean dashboard?"),
    (["part.stl"], "command=part.stl:", "target=mesh target.path=part.stl"),
    (["nosuch/config.yaml"], "configuration=nosuch/config.yaml:", "no such file"),
    (["target=dish.stl"], "target=dish.stl:", "target=mesh target.path=dish.stl"),
    (["target.path=dish.stl"], "target.path=dish.stl:", "target=mesh target.path=dish.stl"),
    ([BOWL, "search=rdm", "search.children=3"], "search.children=3:", "search=bfts or search=dfts only"),
    (["target=bowl,cube"], "target=bowl,cube:", "-m target=bowl,cube"),
    ([BOWL, "start=crease"], "symmetry=xyd:", "add symmetry=y"),
    ([BOWL, "board=null"], "board=null:", "13x13, 25x25, 9x9"),
    ([BOWL, "=5"], "=5:", "key before the ="),
    ([BOWL, "budget=" + "9" * 5000], "budget=99999", "cannot be read"),
    ([BOWL, "budget=1e13"], "budget=10000000000000:", "to 1000000000000"),
    ([BOWL, "budget=${seed}", "seed=${budget}"], "budget=?:", "Recursive"),
    ([BOWL, "~budget"], "budget=(nothing):", "missing"),
    ([BOWL, "~output"], "~output=:", "cannot be left out"),
    ([BOWL, "task=" + "x" * 3000], "task=xxx", "at most 100"),
    ([BOWL, "task=.."], "task=..:", "word"),
    ([BOWL, "output="], "output=:", "folder"),
    ([BOWL, "output=[1]"], "output=[1]:", "folder"),
    ([BOWL, "tracking.uri={a:1}"], "tracking.uri=", "MLflow URI"),
    ([BOWL, "workers=10000000", "seed=0..99999"], "workers=10000000:", "GB"),
    ([BOWL, "max_crease_length=1e300"], "max_crease_length=1e+300:", "null"),
    ([BOWL, "search=bfts", "search.children=2.5"], "search.children=2.5:", "whole number"),
    ([BOWL, "search=bfts", "search.restarts=null"], "search.restarts=None:", "whole number"),
    ([BOWL, "+objective.samples=1e9"], "objective.samples=1000000000.0:", "whole number"),
    ([BOWL, "+objective.tolerance=-1"], "objective.tolerance=-1:", "at least"),
    ([BOWL, "+target.outer=1e9", "+target.error=1e5"], "target.outer=1000000000.0:", "up to"),
    ([BOWL, "+target.coefficient=1000"], "target.coefficient=1000:", "as deep"),
    (["target=cube", "target.edge={a:1}"], "target.edge={'a': 1}:", "number"),
    (["target=mesh", "target.path=[1]"], "target.path=[1]:", "mesh file"),
    ([BOWL, "hydra.run.dir=/dev/null"], "output=/dev/null:", "folder"),
    ([BOWL, "hydra.run.dir=a", "output=b"], "hydra.run.dir=a:", "same thing as output"),
    ([BOWL, "hydra.sweep.dir=a"], "hydra.sweep.dir=a:", "-m; that of one run is given as output=DIR"),
    (["-m", "target=bowl,cube", "hydra.run.dir=a"], "hydra.run.dir=a:", "output=DIR"),
    (["-m", "target=bowl,cube", "hydra.sweep.subdir=a"], "hydra.sweep.subdir=a:", "named by what differs"),
    ([BOWL, "hydra.job.chdir=true"], "hydra.job.chdir=true:", "where the command is typed"),
    ([BOWL, "--config-dir", "nosuch"], "--config-dir=nosuch:", "no such folder"),
    ([BOWL, "--config-path", "nosuch"], "--config-path=nosuch:", "no such folder"),
    ([BOWL, "--config-name", "board/9x9"], "--config-name=board/9x9:", "has no target"),
    ([BOWL, "--config-name", "nosuch"], "configuration=nosuch:", "Cannot find"),
    (["exprot", "x", "--to", "svg"], "command=exprot:", "did you mean export?"),
    ([BOWL, "tracking.experiment=" + "x" * 501], "tracking.experiment=xxx", "at most 500 characters"),
    ([BOWL, "+objective." + "x" * 300 + "=1"], "+objective.xxx", "too long"),
    ([BOWL, "--cfg"], "flag=--cfg:", "expected one argument"),
    ([BOWL, "--resolve"], "flag=--resolve:", "--cfg job"),
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


FILES = {
    "syntax.yaml": ("seed: 1\nbudget: [1\nseed: 2\n", "configuration=syntax.yaml:3: is no YAML"),
    "list.yaml": ("- 1\n", "configuration=list.yaml: must hold keys"),
    "empty.yaml": ("", "configuration=empty.yaml: must hold keys"),
    "part.yaml": ("budget: 3\n", "configuration=part.yaml: lacks board, capacity"),
    "typo.yaml": ("seed: 0\nbugdet: 3\n", "configuration=typo.yaml:2: there is no key bugdet; did you mean budget?"),
    "binary.yaml": ("\udcff\udcfe", "configuration=binary.yaml: cannot be read"),
}


@pytest.mark.parametrize("name", FILES)
def test_a_configuration_written_by_hand(capsys: pytest.CaptureFixture[str], name: str) -> None:
    text, begin = FILES[name]
    Path(name).write_bytes(text.encode(errors="surrogateescape"))
    assert main([name]) == 2
    err = capsys.readouterr().err
    assert err.startswith(f"error: {begin}")
    assert err.count("\n") == 1


def test_a_file_name_cannot_disturb_the_terminal(capsys: pytest.CaptureFixture[str]) -> None:
    Path("a\x1b[31m\rb.stl").write_bytes(b"")
    assert main(["target=mesh", "target.path='a\x1b[31m\rb.stl'"]) == 2
    err = capsys.readouterr().err
    assert "\x1b" not in err
    assert "\r" not in err
    assert err.count("\n") == 1


@pytest.mark.slow
def test_bash_completes_groups_and_options() -> None:
    """As bash asks, through the script that `eval "$(origami-lab -sc install=bash)"` installs."""
    command = [sys.executable, "-m", "origami_lab", "-sc", "query=bash"]
    for typed, offered in (("targ", "target="), ("target=bo", "target=bowl"), ("target=bowl board.", "board.size=")):
        line = f"origami-lab {typed}"
        environment = {**os.environ, "COMP_LINE": line, "COMP_POINT": str(len(line)), "COMP_CWORD": "1"}
        done = subprocess.run(command, env=environment, capture_output=True, text=True, check=False)
        assert done.returncode == 0
        assert any(word.startswith(offered) for word in done.stdout.split()), (typed, done.stdout, done.stderr)


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


def test_help_fits_a_screen_and_names_all_commands_and_groups(capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["--help"]) == 0
    out = capsys.readouterr().out
    for text in ("rigid origami", "seed=0..9", "  target: bowl, cube", "budget=500000", "-m"):
        assert text in out
    for command in COMMANDS:
        assert f"  origami-lab {command}" in out
    for group in groups():
        assert f"  {group}: " in out
    assert "/_" not in out
    assert "_rules" not in out
    lines = out.splitlines()
    assert len(lines) <= 60
    assert all(len(line) <= 120 for line in lines)
    assert list(Path.cwd().iterdir()) == []


def test_help_has_a_page_for_each_group_and_all_settings(capsys: pytest.CaptureFixture[str]) -> None:
    explained = explained_keys()
    for group, folder in groups().items():
        assert main(["--help", group]) == 0
        out = capsys.readouterr().out
        assert all(len(line) <= 120 for line in out.splitlines())
        for option in options_of(folder):
            assert f"{group}={option}" in out or option == "none"
            assert all(key in out for key in own_keys(group, option) if key.startswith(f"{group}."))
    assert main(["--help", "settings"]) == 0
    out = " ".join(capsys.readouterr().out.split())
    for key in ("seed", "driving_angle.count", "polish_seconds", "verbosity"):
        assert f" {key}=" in out
        assert explained[key] in out


@pytest.mark.parametrize(
    ("typed", "said"),
    [
        (["search=evo", "--help"], "agents in a generation"),
        (["--help", "search=evo"], "search.population=128"),
        (["-h", "budget"], "interactions a trial"),
        (["--help", "driving_angle"], "driving_angle.count=10"),
        (["--help", "search.children"], "children sampled at each node"),
        (["target=bowl", "budget=3", "--help"], "max_crease_length=2.9"),
        (["--help", "export"], "--to"),
    ],
)
def test_help_answers_what_is_typed_beside_it(typed: list[str], said: str, capsys: pytest.CaptureFixture[str]) -> None:
    assert main(typed) == 0
    assert said in capsys.readouterr().out


def test_help_on_nothing_we_know_is_an_error_of_one_line(capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["--help", "serach"]) == 2
    assert capsys.readouterr().err.endswith("did you mean search?\n")
    assert main(["--config-dir", "nowhere", "--help"]) == 2
    assert "--config-dir=nowhere: there is no such folder" in capsys.readouterr().err


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
