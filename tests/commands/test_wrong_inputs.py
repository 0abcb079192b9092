"""Wrong inputs of all kinds, from wrong_inputs.yaml: each is refused in the line of the table, and leaves nothing."""

from __future__ import annotations

import contextlib
import os
import re
import shlex
import shutil
import subprocess
import sys
from collections.abc import Callable, Iterator
from dataclasses import dataclass, field
from functools import cache
from pathlib import Path

import pytest
import yaml

from origami_lab.cli import main

ROOT = Path(__file__).parents[2]
TABLE = yaml.safe_load(Path(__file__).with_name("wrong_inputs.yaml").read_text(encoding="utf-8"))


def options(group: str, without: tuple[str, ...] = ()) -> str:
    """The names of the files in a folder of conf/, but for some."""
    return ", ".join(sorted({file.stem for file in (ROOT / "conf" / group).glob("*.yaml")} - set(without)))


_DOTTED_NAME = re.compile(r"\borigami_lab(?:\.\w+)+\.(\w+)")


@dataclass(frozen=True)
class Case:
    """A line of the table; see its header."""

    words: str
    exit: int
    line: str
    lines: int = 1
    texts: list[str] = field(default_factory=list)
    files: dict[str, str] = field(default_factory=dict)
    copies: list[str] = field(default_factory=list)
    leaves: list[str] = field(default_factory=list)
    needs: str | None = None
    process: bool = False


@dataclass(frozen=True)
class Ended:
    """How a command ended."""

    code: int
    errors: list[str]
    """What it wrote to stderr, line by line, without names of this machine."""
    left: list[str]
    """Files and folders that were not there before."""


CASES = [Case(**case) for section in TABLE["cases"].values() for case in section]


@pytest.fixture(scope="module")
def prepared(tmp_path_factory: pytest.TempPathFactory) -> Callable[[str], Path]:
    """Folders that commands make, by name, when they are first asked for."""

    @cache
    def folder(name: str) -> Path:
        made, place = TABLE["prepared"][name], tmp_path_factory.mktemp(name)
        write_files(place, made.get("texts", []), {})
        with contextlib.chdir(place):
            assert main(shlex.split(made["words"])) == 0
        return place / name

    return folder


@pytest.fixture(autouse=True)
def _elsewhere(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Iterator[None]:
    """A working directory whose modules are forgotten afterwards, and a terminal of known width."""
    monkeypatch.chdir(tmp_path)
    monkeypatch.setenv("COLUMNS", "80")
    yield
    for name, module in list(sys.modules.items()):
        if str(getattr(module, "__file__", None) or "").startswith(f"{tmp_path}{os.sep}"):
            del sys.modules[name]


def write_files(place: Path, texts: list[str], files: dict[str, str]) -> None:
    for name, text in {**{name: TABLE["texts"][name] for name in texts}, **files}.items():
        (place / name).parent.mkdir(parents=True, exist_ok=True)
        (place / name).write_text(text, encoding="utf-8")


def there(place: Path) -> set[str]:
    """What is in a folder, but for what Python makes of imported files."""
    names = {file.relative_to(place).as_posix() for file in place.rglob("*")}
    return {name for name in names if "__pycache__" not in name}


def end_of(case: Case, place: Path, prepared: Callable[[str], Path], capfd: pytest.CaptureFixture[str]) -> Ended:
    """Run the command in a folder with all that the case asks for."""
    for name in case.copies:
        shutil.copytree(prepared(name), place / name)
    write_files(place, case.texts, case.files)
    before, arguments = there(place), shlex.split(case.words)
    if case.process:
        done = subprocess.run(
            [sys.executable, "-m", "origami_lab", *arguments],
            env={**os.environ, "PYTHONPATH": str(ROOT)},
            capture_output=True,
            text=True,
            check=False,
        )
        code, said = done.returncode, done.stderr
    else:
        capfd.readouterr()
        code = main(arguments)
        said = capfd.readouterr().err
    return Ended(code, [normalised(line, place) for line in said.splitlines()], sorted(there(place) - before))


def normalised(line: str, place: Path) -> str:
    """A line without the name of the working directory, and without the modules that parts live in."""
    return _DOTTED_NAME.sub(r"origami_lab.\1", line.replace(str(place), "FOLDER"))


def written_out(line: str) -> str:
    """A line of the table with the options that there are."""
    line = re.sub(r"OPTIONS\((\w+)\)", lambda found: options(found[1]), line)
    return line.replace("TARGETS", options("target", without=("mesh", "none")))


@pytest.mark.parametrize("case", CASES, ids=[case.words or "nothing" for case in CASES])
def test_it_is_refused_in_the_line_of_the_table(
    case: Case, tmp_path: Path, prepared: Callable[[str], Path], capfd: pytest.CaptureFixture[str]
) -> None:
    if case.needs:
        pytest.importorskip(case.needs)
    ended = end_of(case, tmp_path, prepared, capfd)
    assert ended.errors[-1:] == [written_out(case.line)]
    assert ended.code == case.exit
    assert len(ended.errors) <= case.lines, ended.errors
    assert not any("Traceback" in line for line in ended.errors)
    assert set(ended.left) <= set(case.leaves)


def test_the_table_has_no_line_twice() -> None:
    asked = [(case.words, tuple(case.files.items()), case.process) for case in CASES]
    assert len(set(asked)) == len(asked) >= 60
