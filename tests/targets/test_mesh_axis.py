"""Which way up a mesh stands: in configurations, in runs made before it could be said, and in what we export."""

from __future__ import annotations

from copy import deepcopy
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from omegaconf import OmegaConf

from origami_lab.config.instantiate import build_parts
from origami_lab.config.mesh_axis import as_it_was, with_resolved_up
from origami_lab.config.resumed_settings import like_begun
from origami_lab.config.settings import read_settings
from origami_lab.config.warnings import remarks
from origami_lab.errors import InputError
from origami_lab.export.folded_mesh import write_mesh
from origami_lab.file_names import FOLDER_FORMAT
from origami_lab.fold_format.writer import as_fold_file
from origami_lab.runs.run_folder import RunFolder
from origami_lab.sweep.studies import SearchJob
from origami_lab.targets.mesh_target import mesh
from tests.config.test_compose import composed, settings
from tests.known_designs import closed_forms as designs
from tests.small_runs import run
from tests.sweep.conftest import declare
from tests.targets import mesh_files as files

FILES = {
    "bar.glb": files.glb(),
    "bar.gltf": files.gltf().encode(),
    "bar.stl": files.binary_stl(),
    "bar.obj": files.obj().encode(),
}


@pytest.fixture
def folder(tmp_path: Path) -> Path:
    for name, data in FILES.items():
        (tmp_path / name).write_bytes(data)
    return tmp_path


@pytest.mark.parametrize(("name", "axis"), [("bar.glb", "y"), ("bar.gltf", "y"), ("bar.stl", "z"), ("bar.obj", "z")])
def test_auto_is_resolved_before_it_is_written(folder: Path, name: str, axis: str) -> None:
    found = settings("target=mesh", f"target.path={folder / name}", "target.translate=[0,0,0]")
    assert found.config["target"]["up"] == found.config["objective"]["target"]["up"] == axis
    target = build_parts(found).target
    assert target is not None
    assert target.vertices.max(axis=0).tolist() == [4, 3, 2]
    for given in ("y", "z"):
        assert (
            settings("target=mesh", f"target.path={folder / name}", f"target.up={given}").config["target"]["up"]
            == given
        )
    with pytest.raises(InputError, match=r"^target\.up=x: must be auto, y or z"):
        build_parts(settings("target=mesh", f"target.path={folder / name}", "target.up=x"))


def test_a_configuration_that_does_not_say_it_is_read_as_it_was(folder: Path) -> None:
    config = composed("target=mesh", f"target.path={folder / 'bar.glb'}", "target.fit=board")
    for part in (config.target, config.objective.target):
        OmegaConf.set_struct(config, False)
        if "up" in part:
            del part["up"]
    config.objective.target = OmegaConf.create(OmegaConf.to_container(config.target))
    found = read_settings(config)
    assert "up" not in found.config["target"]
    assert "up" not in found.config["objective"]["target"]
    parts = build_parts(found)
    assert parts.target is not None
    width, depth, height = np.ptp(parts.target.vertices, axis=0)
    assert width / depth == pytest.approx(4 / 2)  # on its side
    assert height / depth == pytest.approx(3 / 2)
    assert any("version 0.1.0" in line for line in remarks(found, parts))
    assert not any(
        "version 0.1.0" in line for line in remarks(settings("target=mesh", f"target.path={folder / 'bar.glb'}"), parts)
    )


def test_only_our_meshes_are_touched() -> None:
    own: dict[str, Any] = {"_target_": "mine.mesh", "path": "a.glb", "up": "auto"}
    bowl = {"_target_": "origami_lab.targets.solids.bowl"}
    for target in (own, bowl, None):
        values = {"target": target, "objective": {"_target_": "x", "target": target}}
        assert with_resolved_up(values) == values
    assert as_it_was(own) == own
    assert as_it_was(bowl) == bowl
    assert with_resolved_up({"target": None, "objective": {}}) == {"target": None, "objective": {}}


def test_a_run_goes_on_as_it_began(folder: Path) -> None:
    now = settings("target=mesh", f"target.path={folder / 'bar.glb'}")
    today = {"folder_format": FOLDER_FORMAT}
    before = today | {"target": {key: value for key, value in now.config["target"].items() if key != "up"}}
    kept = like_begun(now, before)
    assert kept.target == {**before["target"], "up": None}
    assert kept.config["target"] == kept.config["objective"]["target"] == before["target"]
    for begun in ({}, {"target": None}, {"target": now.config["target"]}, {"target": {"_target_": "mine.mesh"}}):
        assert like_begun(now, today | begun) == now
    bowl = settings("target=bowl")
    assert like_begun(bowl, before) == bowl


@pytest.mark.slow
def test_a_run_made_before_is_resumed_with_its_target(folder: Path, capsys: pytest.CaptureFixture[str]) -> None:
    same = [
        "target=mesh",
        "target.path=bar.glb",
        "target.translate=[0,0,0]",
        "search=rdm",
        "budget=200",
        "files=designs",
        "tracking=none",
        "workers=1",
    ]
    now = settings(*same, f"target.path={folder / 'bar.glb'}")
    for name, up in (("old", None), ("new", "z")):
        (folder / name).mkdir()
        begun = {**deepcopy(now.config), "output": None, "resume": False, "seed": 0}
        for part in (begun, begun["objective"]):
            part["target"] = {key: value for key, value in part["target"].items() if key != "up"}
            part["target"] |= {} if up is None else {"up": up}
        RunFolder(folder / name).begin(begun, mesh(folder / "bar.glb", up="z"), None)
    target = (folder / "old/target.ply").read_bytes()
    assert run(folder, *same, "output=old", "resume=true") == 0
    assert (folder / "old/target.ply").read_bytes() == target
    assert "up" not in OmegaConf.load(folder / "old/config.yaml").target
    assert run(folder, *same, "output=new", "resume=true") == 2
    assert "target.up was z, is y" in capsys.readouterr().err
    assert run(folder, *same, "output=new", "resume=true", "target.up=z") == 0


@pytest.mark.parametrize("up", [None, "z", "y"])
def test_a_sweep_goes_on_as_its_first_trial_began(folder: Path, up: str | None) -> None:
    declaration = declare(folder, task=["target=mesh", f"target.path={folder / 'bar.glb'}"])
    new = SearchJob(declaration).settings(declaration.base)
    assert new.config["target"]["up"] == "y"
    first = declaration.folder / "trials/0000"
    first.mkdir(parents=True)
    target = {key: value for key, value in new.config["target"].items() if key != "up"} | (
        {} if up is None else {"up": up}
    )
    RunFolder(first).begin({**new.config, "target": target}, None, None)
    kept = SearchJob(declaration).settings(declaration.base)
    assert kept.config["target"].get("up") == (None if up is None else "y")
    assert kept.target is not None
    assert kept.target["up"] == (None if up is None else "y")


@pytest.mark.parametrize("kind", ["glb", "stl", "obj", "ply"])
def test_what_we_export_comes_back_upright(tmp_path: Path, kind: str) -> None:
    fold = as_fold_file(designs.pyramid())
    path = tmp_path / f"sheet.{kind}"
    write_mesh(fold, fold.best, path)
    target = mesh(path)
    folded = fold.best.coords
    near = np.linalg.norm(target.vertices[:, None] - folded[None], axis=2)
    assert near.min(axis=1).max() < 1e-6
    assert near.min(axis=0).max() < 1e-6
