"""A user's own parts: what is wrong with one is one line that names it, before anything is written."""

from __future__ import annotations

import itertools
import sys
from collections.abc import Iterator
from pathlib import Path

import pytest

from origami_lab.cli import main
from origami_lab.config.compose import compose_settings, working_directory_importable
from origami_lab.config.instantiate import Parts, build_parts
from origami_lab.config.trusted_code import names_only_ours
from origami_lab.errors import InputError

MINE = """\
import numpy as np
from origami_lab.targets import Target

class Objective:
    def __init__(self, size=1):
        if size < 0:
            raise KeyError("size")
        self.size = size
        if size > 9:
            self.grow()
    def grow(self):
        raise RuntimeError("too large\\nby far")
    def score(self, sheet):
        return 0.0

class NoSelf:
    def score(sheet):
        return 0.0

class TwoArguments:
    def score(self, sheet, angle):
        return 0.0

class BadBound(Objective):
    def bound(self):
        return 0.0

class NumberBound(Objective):
    bound = 3.0

class HalfBound:
    def bind(self, game):
        return self

class WantsTarget(Objective):
    def __init__(self, target):
        assert target.name == "cube", target

class Searcher:
    def search(self, problem):
        pass

class Picky:
    def search(self, problem, rng):
        pass
    def check_game(self, game):
        raise ValueError(f"no board of {game.board_size}")

class NoGame(Picky):
    def check_game(self):
        pass

class Plain:
    pass

class Outer:
    Inner = Objective
    @classmethod
    def make(cls):
        return Objective()

class Wrapper(Objective):
    def __init__(self, inner):
        self.inner = inner

def nothing(): return None
def a_class(): return Objective
def a_searcher_class():
    from origami_lab.search.random_search import RandomSearch
    return RandomSearch
def a_list(): return [[0, 0, 0]]
def flat(): return Target("flat", np.zeros((3, 2)), np.array([[0, 1, 2]]), False)
def holes(): return Target("holes", np.full((3, 3), np.nan), np.array([[0, 1, 2]]), False)
def empty(): return Target("empty", np.zeros((3, 3)), np.zeros((0, 3)), False)
def stray(): return Target("stray", np.zeros((3, 3)), np.array([[0, 1, 3]]), False)
number = 3
"""

REFUSED: list[tuple[str, str, str]] = [
    # the part, its _target_ in the module, what the line says
    ("objective", "MODULE.Objektive", "there is no Objektive in module MODULE; did you mean Objective?"),
    ("objective", "MODULE.Outer.Innner", "there is no Innner in class Outer; did you mean Inner?"),
    (
        "objective",
        "MODULEE.Objective",
        "there is no module MODULEE, neither in FOLDER nor installed; did you",
    ),
    ("objective", "Objective", "e.g. mine.Tower for the class Tower in mine.py"),
    ("objective", "MODULE..Objective", "e.g. mine.Tower for the class Tower in mine.py"),
    ("objective", "__main__.Objective", "must be in a file of its own"),
    ("objective", "MODULE.number", "is of type int; must be a class or a function"),
    ("objective", "MODULE.nothing", "must make an object with a method score(sheet), made None"),
    ("objective", "MODULE.Plain", "must make an object with a method score(sheet), made a Plain without one"),
    ("objective", "MODULE.a_class", "returned the class Objective; must return an object of it"),
    ("objective", "MODULE.NoSelf", "score must be def score(self, sheet)"),
    ("objective", "MODULE.TwoArguments", "score must be def score(self, sheet) (missing a required argument: 'angle')"),
    ("objective", "MODULE.BadBound", "bound must be def bound(self, sheet)"),
    ("objective", "MODULE.NumberBound", "bound is a float; must be def bound(self, sheet)"),
    ("objective", "MODULE.HalfBound", "has bind(game); must have report(game, actions, angle), too"),
    ("objective", "MODULE.WantsTarget", "does not take these arguments: missing a required argument: 'target'"),
    ("search", "MODULE.Searcher", "search must be def search(self, problem, rng)"),
    ("search", "MODULE.NoGame", "check_game must be def check_game(self, game)"),
    ("search", "MODULE.Picky", "check_game raised ValueError: no board of 9 (MODULE.py, line "),
    ("search", "MODULE.Plain", "must make an object with a method search(problem, rng), made a Plain"),
    ("search", "MODULE.nothing", "method search(problem, rng), made None"),
    ("search", "MODULE.a_searcher_class", "returned the class RandomSearch; must return an object of it"),
    ("target", "MODULE.nothing", "returned None; must return a Target"),
    ("target", "MODULE.a_list", "returned a list; must return a Target"),
    ("target", "MODULE.flat", "vertices are of shape (3, 2); must be finite numbers of shape (V, 3)"),
    ("target", "MODULE.holes", "must be finite numbers"),
    ("target", "MODULE.empty", "must have the shape (F, 3), F at least 1"),
    ("target", "MODULE.stray", "faces name vertices 0 to 3; must be from 0 to 2"),
]

BROKEN_MODULES = [
    ("def f(:\n  pass\n", "importing MODULE failed: SyntaxError: invalid syntax (MODULE.py, line 1)"),
    ("x = 1\nimport nosuchpackage\n", "ModuleNotFoundError: No module named 'nosuchpackage' (MODULE.py, line 2)"),
    ("\n\nfrom math import pie\n", "ImportError: cannot import name 'pie' from 'math'"),
    ("\n1 / 0\n", "importing MODULE failed: ZeroDivisionError: division by zero (MODULE.py, line 2)"),
    ("import sys\nsys.exit('bye')\n", "importing MODULE failed: SystemExit: bye (MODULE.py, line 2)"),
    # raised in a library: the line is still the user's own
    ("import json\n\njson.loads('{')\n", "(MODULE.py, line 3)"),
]

_number = itertools.count()


@pytest.fixture
def module(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Iterator[str]:
    """The name, never used before, of a module in the working directory."""
    monkeypatch.chdir(tmp_path)
    name = f"mine{next(_number)}"
    Path(f"{name}.py").write_text(MINE)
    yield name
    sys.modules.pop(name, None)


def build(*overrides: str) -> Parts:
    with working_directory_importable():
        return build_parts(compose_settings(["target=cube", "search=rdm", *overrides]))


@pytest.mark.parametrize("own", [False, True])
def test_trials_share_only_what_is_ours_and_never_changes(module: str, own: bool) -> None:
    mine = overrides_for("objective", f"{module}.Objective") if own else []
    with working_directory_importable():
        settings = compose_settings(["target=cube", "search=rdm", *mine])
        first = build_parts(settings)
        second = build_parts(settings, first)
    assert (second.target is first.target) is not own
    assert (second.objective is first.objective) is not own
    assert second.game is not first.game
    assert second.searcher is not first.searcher


def overrides_for(part: str, target: str) -> list[str]:
    """Put a ``_target_`` in place of a part whose own arguments are dropped."""
    objective = [f"~objective.{key}" for key in ("distance", "compactness", "target")]
    dropped = {"objective": objective, "target": ["~target.edge"], "search": []}
    return [f"{part}._target_={target}", *dropped[part]]


@pytest.mark.parametrize(("part", "target", "expected"), REFUSED, ids=[f"{r[0]} {r[1]}" for r in REFUSED])
def test_what_is_wrong_is_said_in_one_line(module: str, part: str, target: str, expected: str) -> None:
    target = target.replace("MODULE", module)
    with pytest.raises(InputError) as refused:
        build(*overrides_for(part, target))
    line = str(refused.value)
    assert line.startswith(f"{part}={target}: ")
    assert expected.replace("MODULE", module).replace("FOLDER", str(Path.cwd())) in line
    assert "\n" not in line


@pytest.mark.parametrize(("source", "expected"), BROKEN_MODULES, ids=[expected for _, expected in BROKEN_MODULES])
def test_a_module_that_raises_is_named_with_file_and_line(module: str, source: str, expected: str) -> None:
    Path(f"{module}.py").write_text(source)
    with pytest.raises(InputError) as refused:
        build(*overrides_for("objective", f"{module}.Objective"))
    assert expected.replace("MODULE", module) in str(refused.value)
    assert "\n" not in str(refused.value)


@pytest.mark.parametrize(
    ("argument", "expected", "where"),
    [
        ("size=-1", "raised KeyError: 'size'", 'raise KeyError("size")'),
        ("size=10", "raised RuntimeError: too large", "raise RuntimeError("),
        ("size=abc", "raised TypeError: '<' not supported between instances of 'str' and 'int'", "if size < 0:"),
        ("colour=red", "does not take these arguments: got an unexpected keyword argument 'colour'", ""),
    ],
)
def test_a_constructor_that_raises_is_named_with_file_and_line(
    module: str, argument: str, expected: str, where: str
) -> None:
    with pytest.raises(InputError) as refused:
        build(*overrides_for("objective", f"{module}.Objective"), f"+objective.{argument}")
    if where:
        (line,) = (number for number, text in enumerate(MINE.splitlines(), start=1) if where in text)
        expected += f" ({module}.py, line {line})"
    assert str(refused.value) == f"objective={module}.Objective: {expected}"


def test_a_part_in_an_argument_is_looked_for_as_well(module: str) -> None:
    own = overrides_for("objective", f"{module}.Wrapper")
    with pytest.raises(InputError, match=f"there is no Innr in module {module}"):
        build(*own, f"+objective.inner={{_target_:{module}.Innr}}")
    with pytest.raises(InputError, match=f"KeyError: 'size' .{module}.py, line"):
        build(*own, f"+objective.inner={{_target_:{module}.Objective,size:-1}}")
    objective = build(*own, f"+objective.inner={{_target_:{module}.Objective,size:2}}").objective
    assert objective.inner.size == 2


def test_good_parts_are_taken(module: str) -> None:
    for name in ("Objective", "Outer.Inner", "Outer.make"):
        assert build(*overrides_for("objective", f"{module}.{name}")).objective.size == 1
    without = ("~objective.distance", "~objective.compactness")
    assert build(f"objective._target_={module}.WantsTarget", *without).target is not None


def test_the_command_says_it_and_leaves_nothing(module: str, capfd: pytest.CaptureFixture[str]) -> None:
    Path("conf/objective").mkdir(parents=True)
    Path("conf/objective/mine.yaml").write_text(
        f"# @package _global_\ntask: mine\nobjective:\n  _target_: {module}.Plain\n"
    )
    assert main(["--config-dir", "conf", "objective=mine", "tracking=none"]) == 2
    out, err = capfd.readouterr()
    assert out == ""
    made = "must make an object with a method score(sheet), made a Plain without one"
    assert err == f"error: objective={module}.Plain: {made}\n"
    assert not Path("results").exists()
    assert main(["--config-dir", "conf", "objective=mine", "--cfg", "job"]) == 0
    assert f"_target_: {module}.Plain" in capfd.readouterr().out


@pytest.mark.parametrize(
    ("content", "expected"),
    [
        (b"objective:\n  a: 1\n b: [\n", "/mine.yaml: cannot be read: expected <block end>"),
        (b"a: \xff\n", "not UTF-8 text"),
        (b"objective:\n  _target_: mine.X\n", "the first line of its file must be # @package _global_"),
        (b"# @package _global_\nobjective:\n  _traget_: mine.X\n", "or name a class by _target_"),
        (b"# @package _global_\ndefaults:\n  - override /bord: 9x9\n", "did you mean board?"),
        (b"# @package _global_\ndefaults:\n  - override /board: 9x8\n", "did you mean 9x9?"),
    ],
)
def test_a_wrong_yaml_is_said_in_one_line(content: bytes, expected: str, tmp_path: Path) -> None:
    (tmp_path / "objective").mkdir()
    (tmp_path / "objective/mine.yaml").write_bytes(content)
    with pytest.raises(InputError) as refused:
        compose_settings(["objective=mine", "search=rdm"], tmp_path)
    assert expected in str(refused.value)
    assert "\n" not in str(refused.value)


def test_whether_all_is_ours_is_seen_at_any_depth() -> None:
    ours = {"_target_": "origami_lab.search.Rdm"}
    mine = {"_target_": "mine.Objective"}
    assert names_only_ours({})
    assert names_only_ours({"search": ours, "budget": 3, "objective": {"terms": [ours, {"a": ours}]}})
    assert not names_only_ours({"search": ours, "objective": mine})
    assert not names_only_ours({"search": {**ours, "inner": [ours, {"deep": mine}]}})
    assert not names_only_ours({"search": {"_target_": "origami_laboratory.Rdm"}})
