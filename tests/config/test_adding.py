"""What a new part takes, as CONTRIBUTING says: its class or function and a YAML file; a setting: a field and a line."""

from __future__ import annotations

import dataclasses
import shutil
import sys
from collections.abc import Iterator
from pathlib import Path
from typing import Annotated

import pytest
import yaml
from omegaconf import OmegaConf

from origami_lab.checks import Whole, check
from origami_lab.cli import main
from origami_lab.config import option_files, settings
from origami_lab.config.compose import compose_settings
from origami_lab.config.option_files import config_dir, explained_keys
from origami_lab.errors import InputError
from origami_lab.report.run_groups import group_runs
from origami_lab.report.run_reader import read_runs

PARTS = """\
import numpy as np
from origami_lab.search.random_search import RandomSearch
from origami_lab.targets import Target

def wedge(rise=1.0):
    vertices = np.array([[-2, -2, 0], [2, -2, rise], [2, 2, rise], [-2, 2, 0]], dtype=float)
    return Target("wedge", vertices, np.array([[0, 1, 2], [0, 2, 3]]), closed=False)

class Width:
    def __init__(self, least=0.0):
        self.least = least
    def score(self, sheet):
        return float(sheet.points[-1][:, 0].max()) - self.least

class Another(RandomSearch):
    pass
"""
OPTIONS = {
    "target/wedge": {
        "defaults": [{"override /board": "9x9"}, {"override /start": "unit_square"}, {"override /symmetry": "y"}],
        "target": {"_target_": "new_parts.wedge", "rise": 1.0},
        "report_order": {"task": 1.5},
    },
    "objective/width": {
        "defaults": [{"override /board": "9x9"}, {"override /start": "unit_square"}],
        "task": "width",
        "objective": {"_target_": "new_parts.Width", "least": 0.0},
        "report_order": {"task": 0},
    },
    "search/another": {"search": {"_target_": "new_parts.Another"}, "report_order": {"method": 0.5}},
}


@pytest.fixture
def own(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Iterator[Path]:
    """A working directory with a module of three parts and a folder of options that name them."""
    monkeypatch.chdir(tmp_path)
    Path("new_parts.py").write_text(PARTS)
    for name, content in OPTIONS.items():
        file = tmp_path / f"conf/{name}.yaml"
        file.parent.mkdir(parents=True, exist_ok=True)
        file.write_text("# @package _global_\n" + yaml.safe_dump(content, sort_keys=False))
    yield tmp_path / "conf"
    sys.modules.pop("new_parts", None)


def test_help_and_messages_name_new_options(own: Path, capfd: pytest.CaptureFixture[str]) -> None:
    assert main(["--config-dir", "conf", "--help"]) == 0
    text = capfd.readouterr().out
    for group, name in (option.split("/") for option in OPTIONS):
        line = next(line for line in text.splitlines() if line.startswith(f"  {group}: "))
        assert name in line.replace(",", " ").split()
        assert main(["--config-dir", "conf", "--help", group]) == 0
        assert f"{group}={name}" in capfd.readouterr().out
    assert main(["--config-dir", "conf", "search=anoter", "target=cube"]) == 2
    assert "did you mean another?" in capfd.readouterr().err
    with pytest.raises(InputError, match=r"needs a target: target=bowl, .*\bwedge\b.* or mesh target\.path="):
        compose_settings(["search=rdm"], own)


def test_a_report_has_new_tasks_and_searchers_where_their_options_say(own: Path) -> None:
    quick = ["budget=60", "workers=1", "files=designs", "tracking=none", "verbosity=quiet"]
    for number, what in enumerate(("target=cube", "target=wedge", "target=pyramid", "objective=width")):
        searchers = ("rdm", "another", "dfts") if number == 0 else ("rdm",)
        for searcher in searchers:
            words = [what, f"search={searcher}", *quick, f"output=runs/{number}{searcher}"]
            assert main(["--config-dir", "conf", *words]) == 0
    groups = group_runs(read_runs([Path("runs")])[0])
    assert [column.name for column in groups.columns] == ["width", "pyramid", "wedge", "cube"]
    assert [row.name for row in groups.rows] == ["another", "rdm", "dfts"]


def test_a_setting_is_a_field_and_a_line(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    conf = tmp_path / "conf"
    shutil.copytree(config_dir(), conf)
    with (conf / "config.yaml").open("a") as file:
        file.write("\n# how many folds a minute\npace: 3\n")
    monkeypatch.setattr(option_files, "config_dir", lambda: conf)
    monkeypatch.setattr("origami_lab.config.compose.config_dir", lambda: conf)
    paced = dataclasses.make_dataclass(
        "Paced", [("pace", Annotated[int, Whole(1, 9)])], bases=(settings.Settings,), frozen=True, kw_only=True
    )
    monkeypatch.setattr(settings, "Settings", paced)
    assert getattr(compose_settings(["target=cube"]), "pace", None) == 3
    assert explained_keys()["pace"] == "how many folds a minute"
    with pytest.raises(InputError, match=r"^pace=12: must be a whole number from 1 to 9$"):
        compose_settings(["target=cube", "pace=12"])
    with pytest.raises(InputError, match=r"^pcae=2: .*did you mean pace\?"):
        compose_settings(["target=cube", "pcae=2"])


def test_every_field_that_a_configuration_sets_is_a_key_of_it() -> None:
    keys = set(OmegaConf.load(config_dir() / "config.yaml")) | set(option_files.groups())  # type: ignore[arg-type]
    derived = {"game", "seeds", "seeds_given", "config", "left_open", "part_lines"}
    names = {"open_page" if key == "open" else key for key in keys}  # a field named open would hide the function
    assert {field.name for field in dataclasses.fields(settings.Settings)} - derived <= names


def test_kinds_take_what_people_write_and_say_what_they_would() -> None:
    @dataclasses.dataclass
    class Both:
        count: Annotated[int, Whole(1, 100)]
        most: Annotated[int | None, Whole(1, 10**9)] = None

    assert check(Both, {"count": 1e1}) == Both(10)
    refused = {
        (True, 1): "count=True: must be a whole number from 1 to 100",
        (0, 1): "count=0: must be a whole number from 1 to 100",
        (1, "a"): "most=a: must be a whole number from 1, or null",
        (1, 10**10): "most=10000000000: must be a whole number from 1 to 1000000000, or null",
    }
    for (count, most), line in refused.items():
        with pytest.raises(InputError) as error:
            check(Both, {"count": count, "most": most})
        assert str(error.value) == line
    with pytest.raises(InputError, match=r"^count=\(nothing\): is missing from the configuration$"):
        check(Both, {})
