"""A configuration from elsewhere: only our own keys are read, and nothing foreign is called or imported."""

from __future__ import annotations

import json
import shutil
import subprocess
import sys
import sysconfig
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import pytest
import yaml

from origami_lab.cli import main
from origami_lab.config.checked_files import check_interpolations
from origami_lab.config.compose import compose_settings, working_directory_importable
from origami_lab.config.dotted_path import locate
from origami_lab.config.instantiate import Parts, build_parts
from origami_lab.errors import InputError
from origami_lab.runs.result import replay_design
from origami_lab.sweep.sweep_config import read_declaration

MARK = "open('EVIL', 'w').close()"
OWN = """\
import functools
import os, subprocess
import os.path as paths
import numpy as np
from pathlib import Path
from os import system, getcwd
from random import seed
from subprocess import Popen
from numpy.testing import runstring
from origami_lab.objectives import ShapeObjective, Score
from origami_lab.search import RandomSearch

class Tower:
    def __init__(self, height=1, inner=None, target=None):
        self.height, self.inner = height, inner
    @classmethod
    def tall(cls):
        return cls(9)
    def score(self, sheet):
        return 0.0

class Mapping(dict):
    pass

half = functools.partial(Tower, 0.5)
shell = functools.partial(os.system, "touch EVIL")
here = Path("EVIL")
table = np.zeros(3)
"""


@pytest.fixture
def own(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Iterator[Path]:
    """A working directory with a module, a package and a folder of modules, forgotten afterwards."""
    here = tmp_path / "here"
    here.mkdir()
    monkeypatch.chdir(here)
    Path("ownpart.py").write_text(OWN)
    Path("pack/inner").mkdir(parents=True)
    Path("pack/__init__.py").write_text("")
    Path("pack/inner/__init__.py").write_text(OWN)
    Path("loose").mkdir()
    Path("loose/part.py").write_text(OWN)
    yield here
    for name, module in list(sys.modules.items()):
        if str(getattr(module, "__file__", None) or "").startswith(str(tmp_path)) or name == "loose":
            del sys.modules[name]


def build(*overrides: str) -> Parts:
    with working_directory_importable():
        return build_parts(compose_settings(["target=cube", "search=rdm", *overrides]))


def objective(name: str, *more: str) -> Parts:
    dropped = [f"~objective.{key}" for key in ("distance", "compactness", "target")]
    return build(f"objective._target_={name}", *dropped, *more)


FOREIGN = [
    *("os.system", "os.path.join", "builtins.eval", "builtins.exec", "subprocess.run", "importlib.import_module"),
    *("numpy.testing.runstring", "numpy.load", "hydra.utils.instantiate", "hydra.utils.call", "functools.partial"),
    *("shutil.rmtree", "pickle.loads", "yaml.unsafe_load", "pip._internal.main", "antigravity.fly", "this.s"),
    *("ownpart.os.system", "ownpart.system", "ownpart.getcwd", "ownpart.paths.join", "ownpart.subprocess.run"),
    *("ownpart.Popen", "ownpart.runstring", "ownpart.np.testing.runstring", "ownpart.seed"),
    *("ownpart.functools.partial", "ownpart.np.random.seed"),
    *("ownpart.shell", "ownpart.here.touch", "ownpart.table.tofile", "ownpart.Mapping.fromkeys", "ownpart.Path"),
    *("ownpart.Tower.__init__", "ownpart.Tower.__subclasses__", "ownpart.Score", "ownpart.RandomSearch"),
    *("pack.inner.os.system", "loose.part.system", "loose.part.subprocess.run"),
    *("origami_lab.search.RandomSearch", "origami_lab.targets.cube", "origami_lab.objectives.Score"),
    *("origami_lab.search.problem.np.load", "origami_lab.search.something.subprocess.run", "origami_lab.run"),
    *("origami_lab.objectives.shape.ShapeObjective.bind", "origami_lab.files.write_whole", "origami_lab.cli.main"),
    *("origami_lab.objectives.ShapeObjective.__init__", "origami_lab.os.system", "origami_lab.config.compose.sys.exit"),
]


@pytest.mark.parametrize("name", FOREIGN)
def test_what_is_not_ours_nor_the_users_is_refused(own: Path, name: str) -> None:
    with pytest.raises(InputError) as refused:
        objective(name)
    line = str(refused.value)
    assert line.startswith(f"objective={name}: ")
    assert "\n" not in line
    assert not Path("EVIL").exists()


@pytest.mark.parametrize("name", ["antigravity.fly", "this.s", "elsewhere.run", "packed.inner.run"])
def test_it_is_refused_before_its_module_is_imported(
    own: Path, name: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    (tmp_path / "path/packed").mkdir(parents=True)
    for file in ("elsewhere.py", "packed/__init__.py", "packed/inner.py"):
        (tmp_path / "path" / file).write_text(f"{MARK}\ndef run(): pass\n")
    monkeypatch.syspath_prepend(tmp_path / "path")
    module = name.partition(".")[0]
    sys.modules.pop(module, None)
    with pytest.raises(InputError, match=r"below .*here or in a package that the command line names"):
        objective(name)
    assert module not in sys.modules
    assert not Path("EVIL").exists()


def test_installed_modules_below_the_working_directory_are_not_the_users(
    own: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """An environment in the project's folder, as the README makes one, and one that is reached by a link."""
    installed = Path(".venv/lib/python3/site-packages")
    installed.mkdir(parents=True)
    (installed / "stranger.py").write_text(f"{MARK}\ndef run(): pass\n")
    monkeypatch.syspath_prepend(installed.absolute())
    Path("linked").symlink_to(installed)
    Path("libs").symlink_to(sysconfig.get_path("purelib"))
    for name in ("stranger.run", "linked.stranger.run", "libs.numpy.testing.runstring"):
        with pytest.raises(InputError, match="must be a part of"):
            objective(name)
    assert not Path("EVIL").exists()


@pytest.mark.parametrize(
    "name",
    [
        *("ownpart.Tower", "ownpart.Tower.tall", "ownpart.half", "pack.inner.Tower", "loose.part.Tower"),
    ],
)
def test_the_users_own_parts_are_taken(own: Path, name: str) -> None:
    assert type(objective(name).objective).__name__ == "Tower"


def test_a_module_of_another_working_directory_is_not_meant(
    own: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    first = type(objective("ownpart.Tower").objective)
    other = tmp_path / "other"
    other.mkdir()
    (other / "ownpart.py").write_text(OWN)
    monkeypatch.chdir(other)
    second = type(objective("ownpart.Tower").objective)
    assert first is not second
    assert sys.modules["ownpart"].__file__ == str(other / "ownpart.py")


def test_a_part_of_ours_may_be_named_by_a_module_of_the_users(own: Path) -> None:
    assert type(build("objective._target_=ownpart.ShapeObjective").objective).__name__ == "ShapeObjective"


def test_parts_in_arguments_obey_the_same_rule(own: Path) -> None:
    inner = "+objective.inner="
    made = objective("ownpart.Tower", inner + "{a:[{_target_:origami_lab.search.RandomSearch}]}").objective
    assert type(made.inner["a"][0]).__name__ == "RandomSearch"
    for foreign in (
        "{_target_:os.system,command:touch}",
        "[[{_target_:os.getcwd}]]",
        "{a:{b:{_target_:builtins.eval}}}",
        "{_target_:ownpart.Tower,inner:{_target_:os.getcwd}}",
        "{_target_:origami_lab.search.Problem}",
        "{_target_:[os.getcwd]}",
        "{_target_:null}",
    ):
        with pytest.raises(InputError, match="objective="):
            objective("ownpart.Tower", inner + foreign)


@pytest.mark.parametrize("key", ["_partial_", "_args_", "_recursive_", "_convert_", "_other_"])
def test_hydras_own_keys_are_no_arguments(own: Path, key: str) -> None:
    for words in ([f"+objective.{key}=[1]"], [f"+objective.inner={{_target_:ownpart.Tower,{key}:true}}"]):
        with pytest.raises(InputError, match=f"objective.{key}=.*is no argument"):
            objective("ownpart.Tower", *words)


def test_a_package_that_the_command_line_names_is_trusted(own: Path, tmp_path: Path, monkeypatch: Any) -> None:
    place = tmp_path / "elsewhere"
    info = place / "their_parts-1.0.dist-info"
    info.mkdir(parents=True)
    (info / "METADATA").write_text("Metadata-Version: 2.1\nName: their-parts\nVersion: 1.0\n")
    (info / "RECORD").write_text("theirs.py,,\ntheir_parts-1.0.dist-info/METADATA,,\n")
    (place / "theirs.py").write_text(OWN)
    (place / "beside.py").write_text(OWN)
    monkeypatch.syspath_prepend(place)
    with pytest.raises(InputError, match="trust=PACKAGE"):
        objective("theirs.Tower")
    assert "theirs" not in sys.modules
    for words in ("trust=their-parts", "trust=[numpy,their_parts]"):
        assert type(objective("theirs.Tower", words).objective).__name__ == "Tower"
    for name in ("beside.Tower", "theirs.os.system", "theirs.system"):
        with pytest.raises(InputError, match="must be a part of"):
            objective(name, "trust=their-parts")
    with pytest.raises(InputError, match="trust=nosuch: must be the name of an installed package"):
        objective("theirs.Tower", "trust=nosuch")
    settings = compose_settings(["target=cube", "trust=their-parts"])
    assert (settings.trust, "trust" in settings.config) == (("their-parts",), False)


def test_a_package_that_is_developed_in_place_is_trusted(own: Path, tmp_path: Path, monkeypatch: Any) -> None:
    place, source = tmp_path / "installed", tmp_path / "source of theirs"
    place.mkdir()
    info = place / "edited-1.0.dist-info"
    info.mkdir()
    (info / "METADATA").write_text("Metadata-Version: 2.1\nName: edited\nVersion: 1.0\n")
    (info / "RECORD").write_text("edited.pth,,\n")
    (info / "direct_url.json").write_text(json.dumps({"url": source.as_uri(), "dir_info": {"editable": True}}))
    source.mkdir()
    (source / "edited.py").write_text(OWN)
    monkeypatch.syspath_prepend(place)
    monkeypatch.syspath_prepend(source)
    assert type(objective("edited.Tower", "trust=edited").objective).__name__ == "Tower"


# --- files ---


@pytest.fixture(scope="module")
def whole(tmp_path_factory: pytest.TempPathFactory) -> dict[str, Any]:
    """The configuration of a run, as it writes it."""
    settings = compose_settings(["target=cube", "search=rdm", "budget=60", "files=designs", "tracking=none"])
    return json.loads(json.dumps({**settings.config, "verbosity": "quiet"}))


CALLBACK = {"callbacks": {"evil": {"_target_": "os.system", "command": "touch EVIL"}}}
REFUSED_FILES: list[tuple[dict[str, Any], str]] = [
    ({"hydra": CALLBACK}, "hydra: is for Hydra itself"),
    ({"hydra": {"searchpath": ["pkg://evil"]}}, "hydra: is for Hydra itself"),
    ({"hydra": {"run": {"dir": "/tmp"}}}, "hydra: is for Hydra itself"),
    ({"trust": ["numpy"]}, "trust: is given on the command line only"),
    ({"defaults": [{"override hydra/callbacks": "evil"}]}, "there is no key defaults"),
    ({"budget": "${oc.env:HOME}"}, "${oc.env:...}"),
    ({"budget": "${oc.decode:'7'}"}, "${oc.decode:...}"),
    ({"budget": "${oc.create:{a:1}}"}, "${oc.create:...}"),
    ({"task": "a${hydra:runtime.cwd}"}, "${hydra:...}"),
    ({"task": "${hydra:job.env_set}"}, "${hydra:...}"),
    ({"budget": "${${task}:HOME}"}, "may refer to other settings only"),
    ({"budget": "${now:%Y}"}, "${now:...}"),
    ({"start": {"_target_": "os.system", "size": "${oc.env:PATH}"}}, "${oc.env:...}"),
    ({"colour": "red"}, "there is no key colour"),
    ({"board": {"size": 9, "colour": 3}}, "board.colour=3: there is no such key"),
    ({"tracking": {"kind": "none", "server": "x"}}, "tracking.server=x: there is no such key"),
    ({"report_order": {"colour": 3}}, "report_order.colour=3"),
    ({"search": {"_target_": "os.system", "command": "touch EVIL"}}, "search=os.system: must be a part of"),
    ({"search": {"_target_": "numpy.testing.runstring", "astr": MARK, "dict": {}}}, "search=numpy.testing.runstring"),
    ({"target": {"_target_": "origami_lab.targets.cube", "edge": {"_target_": "os.getcwd"}}}, "target=os.getcwd"),
]


@pytest.mark.parametrize(("change", "expected"), REFUSED_FILES, ids=[expected for _, expected in REFUSED_FILES])
def test_a_configuration_that_is_rerun_is_refused(
    own: Path, whole: dict[str, Any], change: dict[str, Any], expected: str, capfd: pytest.CaptureFixture[str]
) -> None:
    Path("theirs").mkdir()
    Path("theirs/config.yaml").write_text(yaml.safe_dump({**whole, **change}))
    for more in ([], ["-m", "seed=1,2"]):
        assert main(["theirs/config.yaml", "output=out", *more]) == 2
        said = capfd.readouterr()
        assert expected in said.err
        assert said.err.count("\n") == 1
        assert not Path("EVIL").exists()
        assert not Path("out").exists()


def test_what_is_named_by_flags_is_looked_at_too(
    own: Path, whole: dict[str, Any], capfd: pytest.CaptureFixture[str]
) -> None:
    Path("theirs").mkdir()
    Path("theirs/mine.yaml").write_text(yaml.safe_dump({**whole, "hydra": CALLBACK}))
    assert main(["--config-path", str(Path("theirs").absolute()), "--config-name", "mine", "output=out"]) == 2
    assert main(["--config-dir", "theirs", "--config-name", "mine", "output=out"]) == 2
    assert "hydra: is for Hydra itself" in capfd.readouterr().err
    assert not Path("EVIL").exists()


OPTIONS = [
    "# @package _global_\nhydra:\n  callbacks:\n    evil: {_target_: os.system, command: touch EVIL}\n",
    "# @package hydra\ncallbacks:\n  evil: {_target_: os.system, command: touch EVIL}\n",
    "# @package hydra.callbacks\nevil: {_target_: os.system, command: touch EVIL}\n",
    "# @package _global_\ndefaults:\n  - override /hydra/callbacks: evil\n",
    "# @package _global_\ndefaults:\n  - /hydra/callbacks: evil\n",
    "# @package _global_\ndefaults:\n  - /calls@hydra.callbacks: evil\n",
    "# @package _global_\ndefaults:\n  - /hydra/callbacks/evil\n",
    "# @package _global_\ntrust: [numpy]\n",
    "# @package trust\nnumpy: 1\n",
    "# @package _global_\ntask: ${oc.env:HOME}\n",
    "# @package _global_\ntask: mine\nbudget: ${oc.decode:'${oc.env:HOME}'}\n",
    "# @package _global_\ncolour: red\n",
]


@pytest.mark.parametrize("text", OPTIONS)
def test_an_option_is_refused(own: Path, text: str, capfd: pytest.CaptureFixture[str]) -> None:
    for name in ("experiment", "calls", "hydra/callbacks"):
        Path(f"conf/{name}").mkdir(parents=True)
    for name in ("calls", "hydra/callbacks"):
        Path(f"conf/{name}/evil.yaml").write_text("evil: {_target_: os.system, command: touch EVIL}\n")
    Path("conf/experiment/night.yaml").write_text(text)
    for more in ([], ["-m", "seed=0,1"], ["--cfg", "job"]):
        asked = ["--config-dir", "conf", "experiment=night", "target=cube", "output=out", "tracking=none", *more]
        code, said = main(asked), capfd.readouterr()
        if "colour" not in text or more != ["--cfg", "job"]:  # which checks no keys
            assert (code, said.err.count("\n")) == (2, 1)
        assert not Path("EVIL").exists()
        assert not Path("out").exists()
    with pytest.raises(InputError):
        compose_settings(["experiment=night", "target=cube"], Path("conf"))


TYPED = [
    "+hydra.callbacks.evil._target_=os.system",
    "+hydra.callbacks={evil:{_target_:os.system,command:touch}}",
    "++hydra={callbacks:{evil:{_target_:os.system}}}",
    "+hydra/callbacks=evil",
    "+calls@hydra.callbacks=evil",
    "hydra.job_logging={version:1,handlers:{a:{'()':os.system}}}",
    "hydra.launcher._target_=os.system",
    "hydra.sweeper={_target_:os.system}",
]


@pytest.mark.parametrize("word", TYPED)
def test_hydra_calls_nothing_that_is_typed(own: Path, word: str, capfd: pytest.CaptureFixture[str]) -> None:
    for more in ([], ["-m"]):
        assert main(["target=cube", "output=out", word, *more]) == 2
        assert capfd.readouterr().err.endswith("names code for Hydra to call, which is not done\n")
    with pytest.raises(InputError, match="names code"):
        compose_settings(["target=cube", word])


def test_references_to_other_settings_stay(own: Path) -> None:
    for text in ("${target}", "a ${board.size} b", "${hydra:runtime.choices.target}_night", "${oc.select:a,1}", "a$b"):
        check_interpolations("x", {"a": [text]})
    Path("conf/experiment").mkdir(parents=True)
    Path("conf/experiment/night.yaml").write_text("# @package _global_\ntask: ${hydra:runtime.choices.target}_night\n")
    assert compose_settings(["experiment=night", "target=cube"], Path("conf")).task == "cube_night"


SWEEP = {"task": ["target=cube"], "searcher": "evo", "space": {"search.elite": {"choices": [0, 1]}}, "budget": 100}


@pytest.mark.parametrize(
    "change",
    [
        {"task": ["target=cube", "trust=numpy"]},
        {"task": ["target=cube", "+hydra.callbacks.evil._target_=os.system"]},
        {"task": ["target=cube", "hydra.searchpath=[pkg://evil]"]},
        {"task": ["target=cube", "target.edge=${oc.env:HOME}"]},
        {"task": "target=cube max_crease_length=${oc.decode:'2'}"},
        {"task": {"target": "cube", "hydra": CALLBACK}},
        {"trust": ["numpy"]},
        {"study": "${oc.env:USER}"},
        {"storage": "${oc.env:HOME}"},
        {"held_out": {"against": {"paper": ["trust=numpy"]}}},
        {"held_out": {"against": {"paper": ["hydra.run.dir=x"]}}},
        {"space": {"trust": {"choices": ["numpy", "scipy"]}}},
        {"space": {"hydra.run.dir": {"choices": ["a", "b"]}}},
    ],
)
def test_a_sweeps_file_sets_no_more_than_settings(own: Path, change: dict[str, Any]) -> None:
    Path("sweep.yaml").write_text(yaml.safe_dump({**SWEEP, **change}))
    with pytest.raises(InputError) as refused:
        read_declaration(Path("sweep.yaml"))
    assert "\n" not in str(refused.value)


def test_a_sweeps_command_line_names_packages_to_trust(own: Path) -> None:
    Path("sweep.yaml").write_text(yaml.safe_dump(SWEEP))
    found = read_declaration(Path("sweep.yaml"), ["trust=[numpy]"])
    assert found.compose(found.base).trust == found.trust == ("numpy",)
    assert "trust" not in found.fixed


def test_the_actions_of_a_design_name_no_code(own: Path) -> None:
    Path("seed=0").mkdir()
    game = {"symmetry": "xy", "start": {"_target_": "os.system", "command": "touch EVIL"}}
    Path("seed=0/actions.json").write_text(json.dumps({"game": game, "actions": [], "angle": 0}))
    with pytest.raises(InputError, match=r"start=os\.system"):
        replay_design(Path("seed=0"))
    assert not Path("EVIL").exists()


@pytest.mark.slow
def test_a_worker_and_another_process_obey_it_too(own: Path) -> None:
    """The command as it is typed: an own part goes through the workers, a foreign one is refused at once."""
    Path("conf/objective").mkdir(parents=True)
    head = "# @package _global_\ntask: mine\nobjective:\n  _target_: "
    Path("conf/objective/good.yaml").write_text(f"{head}pack.inner.Tower\n")
    Path("conf/objective/evil.yaml").write_text(f"{head}os.system\n  command: touch EVIL\n")
    words = ["board=9x9", "search=rdm", "budget=60", "files=designs", "tracking=none", "workers=1", "output=out"]
    command = [sys.executable, "-m", "origami_lab", "--config-dir", "conf", *words]
    root = str(Path(__file__).parents[2])
    for name, code in (("evil", 2), ("good", 0)):
        done = subprocess.run(
            [*command, f"objective={name}"], env={"PYTHONPATH": root, "PATH": "/usr/bin:/bin"}, check=False
        )
        assert done.returncode == code
    assert not Path("EVIL").exists()
    shutil.rmtree("out")
    with pytest.raises(InputError):
        locate("objective", "os.system")
