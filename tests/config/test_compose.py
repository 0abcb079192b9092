"""The configuration tree: every option composes and becomes objects; rows of settings and who wins."""

from __future__ import annotations

import json
import re
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from hydra import compose, initialize_config_dir
from hydra.core.hydra_config import HydraConfig
from omegaconf import DictConfig

import origami_lab
from origami_lab.config.compose import hydra_words, without_hydra
from origami_lab.config.instantiate import build_parts
from origami_lab.config.node import flatten
from origami_lab.config.option_files import CONFIG_NAME, config_dir, explained_keys
from origami_lab.config.settings import Settings, fit_workers, read_settings
from origami_lab.config.warnings import remarks
from origami_lab.errors import InputError

GROUPS = ("target", "objective", "board", "symmetry", "start", "search", "tracking", "experiment")
OPTIONS = [
    (group, file.relative_to(folder).with_suffix("").as_posix())
    for group in GROUPS
    for folder in [Path(config_dir()) / group]
    for file in sorted(folder.rglob("*.yaml"))
]
TETRAHEDRON = """\
v 0 0 0
v 2 0 0
v 0 2 0
v 0 0 2
f 1 3 2
f 1 2 4
f 2 3 4
f 1 4 3
"""


def composed(*overrides: str) -> DictConfig:
    with initialize_config_dir(str(config_dir()), version_base="1.3"):
        config = compose(CONFIG_NAME, hydra_words(overrides), return_hydra_config=True)
    HydraConfig.instance().set_config(config)
    return without_hydra(config)


def settings(*overrides: str) -> Settings:
    return read_settings(composed(*overrides))


@pytest.fixture
def mesh(tmp_path: Path) -> Path:
    file = tmp_path / "part.obj"
    file.write_text(TETRAHEDRON)
    return file


@pytest.mark.parametrize(("group", "option"), OPTIONS, ids=[f"{group}={option}" for group, option in OPTIONS])
def test_every_option_becomes_objects(group: str, option: str, mesh: Path) -> None:
    overrides = [f"{group}={option}"]
    by_part = option == "auto"
    if group != "target":
        overrides.append("target=mesh" if by_part else "target=cube")
    if option == "mesh" or by_part:
        overrides.append(f"target.path={mesh}")
    if option in ("crease", "centre_crease", "chair"):
        overrides.append("symmetry=y")
    if option == "chair":
        overrides.append("board=13x13")
    if option == "panel":
        overrides.append("start.corners=[[2,0],[0,2],[-2,0],[0,-2]]")
    if option == "ppo":
        pytest.importorskip("sb3_contrib", reason="needs the extra ppo")
    if (group, option) == ("start", "file"):
        overrides.append(f"start.path={_trial(mesh.parent)}")
    if (group, option) == ("target", "none"):  # the default objective needs one
        with pytest.raises(InputError, match="target=none"):
            settings(*overrides)
        return
    parts = build_parts(settings(*overrides))
    assert parts.target is not None
    assert callable(parts.searcher.search)


def _trial(folder: Path) -> Path:
    """The folder of a trial on the cube's board, with an equals sign in its name."""
    game = {"symmetry": "xy", "start": {"_target_": "origami_lab.game.Square", "size": 1}}
    moves = [{"kind": "place", "value": 1, "sign": 1}]
    (folder / "seed=0").mkdir(exist_ok=True)
    (folder / "seed=0/actions.json").write_text(json.dumps({"game": game, "moves": moves}))
    return folder / "seed=0"


def test_a_start_pattern_is_found_from_another_folder(mesh: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    _trial(mesh.parent)
    monkeypatch.chdir(mesh.parent)
    found = settings("target=cube", "start=file", "start.path=seed=0")
    assert found.config["start"]["path"] == str(mesh.parent / "seed=0")
    assert found.start["path"] == "seed=0"
    assert len(build_parts(found).game.start_moves) == 1
    assert settings("target=cube", "start=chair").config["start"]["path"] == "chair"
    with pytest.raises(InputError, match=r"start\.path=.*must be given: start\.path="):
        settings("target=cube", "start=file")
    with pytest.raises(InputError, match=r"driving_angle\.fixed=begin: .*start or null"):
        settings("target=cube", "driving_angle.fixed=begin")


def test_the_face_brings_its_row() -> None:
    found = settings("target=face")
    assert dict(found.start) == {"_target_": CREASE, "position": 0, **UPPER}
    assert (found.game.board_size, found.game.symmetry, found.game.max_crease_length) == (25, "y", 2.9)
    assert found.game.source_action is True
    assert dict(settings("target=face", "start=square").start)["size"] == "choose"


# the settings table of the design (paper, table of settings), as far as its targets are there
ROWS: dict[str, tuple[int, str, Any, str, float | None, bool]] = {
    "pyramid": (9, "Square", 1, "xy", None, True),
    "cube": (9, "Square", 1, "xy", 2.0, True),
    "bowl": (25, "Square", "choose", "xyd", 2.9, True),
    "mesh": (25, "Square", "choose", "none", 2.9, True),
}


@pytest.mark.parametrize("target", ROWS)
def test_a_target_brings_its_row(target: str, mesh: Path) -> None:
    extra = [f"target.path={mesh}", "target.fit=board"] if target == "mesh" else []  # else its analysis chooses
    board, kind, size, symmetry, length, sources = ROWS[target]
    found = settings(f"target={target}", *extra)
    assert found.game.board_size == board
    assert found.start["_target_"].endswith(f".{kind}")
    assert found.start["size"] == size
    assert found.game.symmetry == symmetry
    assert found.game.max_crease_length == length
    assert found.game.source_action is sources
    task = "part" if target == "mesh" else target  # meshes are told apart by their files
    assert (found.task, found.method, found.budget) == (task, "lns", 500_000)


SQUARE, SEEDING, CREASE = (f"origami_lab.game.{name}" for name in ("Square", "FromFile", "Crease"))
UPPER = {"ends": None, "stays": "upper"}
OBJECTIVE_ROWS: dict[str, tuple[int, dict[str, Any], str, Any]] = {
    "bucket": (13, {"_target_": SQUARE, "size": "choose", "position": None}, "xyd", None),
    "shelf": (13, {"_target_": SQUARE, "size": "choose", "position": None}, "xy", None),
    "table": (13, {"_target_": SQUARE, "size": "choose", "position": None}, "xyd", None),
    "chair": (13, {"_target_": SEEDING, "path": "chair", "remove": []}, "y", "start"),
    "packaging": (13, {"_target_": SQUARE, "size": 2, "position": None}, "xyd", None),
}


@pytest.mark.parametrize("objective", OBJECTIVE_ROWS)
def test_an_objective_without_a_target_brings_its_row(objective: str) -> None:
    found = settings(f"objective={objective}")
    assert found.task == objective
    assert found.target is None
    row = found.game.board_size, dict(found.start), found.game.symmetry, found.game.driving_angle_fixed
    assert row == OBJECTIVE_ROWS[objective]
    assert found.game.max_crease_length is None
    assert found.game.source_action is False
    # every key of the file is an argument, and the command line wins
    built = build_parts(settings(f"objective={objective}", "objective.compactness=0.5", "board.size=15", "symmetry=y"))
    assert (built.objective.compactness, built.game.board_size, built.target) == (0.5, 15, None)


# the paper: settings, sections 4.2 and 4.3, appendix G (task, board, start, symmetry, crease length, sources)
PAPER: dict[str, tuple[str, int, dict[str, Any], str, float | None, bool]] = {
    "pyramid": ("pyramid", 9, {"_target_": SQUARE, "size": 1, "position": None}, "xy", None, True),
    "cube": ("cube", 9, {"_target_": SQUARE, "size": 1, "position": None}, "xy", 2, True),
    "bowl": ("bowl", 25, {"_target_": SQUARE, "size": "choose", "position": None}, "xyd", 2.9, True),
    # the panel that stays is the lower one in the paper's program
    "face": ("face", 25, {"_target_": CREASE, "position": 0, **UPPER, "stays": "lower"}, "y", 2.9, True),
    "bucket": ("bucket", 13, {"_target_": SQUARE, "size": "choose", "position": None}, "xyd", None, False),
    "shelf": ("shelf", 13, {"_target_": SQUARE, "size": "choose", "position": None}, "xy", None, False),
    "table": ("table", 13, {"_target_": SQUARE, "size": "choose", "position": None}, "xyd", None, False),
    "chair": ("chair", 13, {"_target_": SEEDING, "path": "chair", "remove": []}, "y", None, False),
    "bucket_xy": ("bucket", 13, {"_target_": SQUARE, "size": "choose", "position": None}, "xy", None, False),
    "shelf_y": ("shelf", 9, {"_target_": SQUARE, "size": "choose", "position": None}, "y", None, False),
    "table_xy": ("table", 13, {"_target_": SQUARE, "size": "choose", "position": None}, "xy", None, False),
}


@pytest.mark.parametrize("name", PAPER)
def test_the_papers_experiments_have_its_settings(name: str) -> None:
    what, board, start, symmetry, length, sources = PAPER[name]
    found = settings(f"+experiment=paper/{name}", "search=dfts")
    game = found.game
    row = game.board_size, dict(found.start), game.symmetry, game.max_crease_length, game.source_action
    assert row == (board, start, symmetry, length, sources)
    assert game.straight_sectors is False  # as its tables were made
    assert (found.task, found.method, found.budget, found.seeds) == (name, "dfts", 500_000, tuple(range(10)))
    assert game.driving_angle_fixed == ("start" if what == "chair" else None)
    assert (game.driving_angle_max, game.driving_angle_count) == (pytest.approx(np.degrees(3.14)), 10)
    assert what in (found.target or found.objective)["_target_"].lower()
    assert settings(f"experiment=paper/{name}").method == ("bfts" if found.target else "evo")


def test_overlays_can_be_laid_over_each_other() -> None:
    found = settings("+experiment=[paper/face,paper/as_published]")
    assert (found.task, found.objective["distance"], found.game.stuck) == (
        "face_as_published",
        "sampled",
        "penalise",
    )
    assert (found.certify, found.game.symmetry) == (False, "y")


# what the authors' program does, where it is not what the paper's text says
PUBLISHED: dict[str, dict[str, Any]] = {
    "rdm": {},
    "dfts": {"restarts": 100, "children": 11, "aspiration": None, "inside_moves": False},
    "bfts": {"restarts": 100, "children": 11, "aspiration": None, "inside_moves": False},
    "mcts": {"unvisited": 0.0, "epsilon": 0.25, "alpha": 0.03, "simulations": 100, "temperature": 1.5},
    "evo": {"rescale": False, "population": 128, "sigma_1": 0.1, "sigma_2": 0.5, "sigma_3": 1.0},
}


@pytest.mark.parametrize(
    ("task", "method"),
    [("bowl", "dfts"), ("face", "bfts"), ("cube", "mcts"), ("bucket_xy", "evo"), ("chair", "rdm"), ("shelf_y", "dfts")],
)
def test_as_published(task: str, method: str) -> None:
    found = settings(f"+experiment=[paper/{task},paper/as_published]", f"search={method}")
    assert {**found.search, **PUBLISHED[method]} == found.search
    game = found.game
    assert (found.certify, game.stuck, game.straight_sectors) == (False, "penalise", True)
    assert (game.driving_angle_max, game.driving_angle_count) == (pytest.approx(np.degrees(3.14)), 10)
    what, board, start, symmetry, length, sources = PAPER[task]
    assert (game.board_size, dict(found.start), game.symmetry) == (board, start, symmetry)
    assert (game.max_crease_length, game.source_action) == (length, sources)
    assert (found.task, found.method, found.budget) == (f"{what}_as_published", method, 500_000)
    if found.target is not None:
        assert found.objective["distance"] == "sampled"
    if what == "bucket":
        assert found.objective["norm_of"] == "vertices"
    # the command line wins
    own = settings(f"+experiment=[paper/{task},paper/as_published]", "search=dfts", "search.restarts=10", "stuck=score")
    assert (own.search["restarts"], own.search["children"], own.game.stuck) == (10, 11, "score")


def test_any_crease_as_published_keeps_its_lower_panel() -> None:
    overlay = "+experiment=paper/as_published"
    for start in ("crease", "centre_crease"):
        assert settings("target=bowl", f"start={start}", "symmetry=none", overlay).start["stays"] == "lower"
        assert settings("target=bowl", f"start={start}", "symmetry=none").start["stays"] == "upper"
    assert settings("target=bowl", "search=dfts").search["restarts"] == 200


@pytest.mark.parametrize("task", ["cube", "face", "bucket"])
def test_as_published_plays(task: str, tmp_path: Path) -> None:
    words = [f"+experiment=[paper/{task},paper/as_published]", "search=dfts", "seed=0", "budget=300", "workers=1"]
    result = origami_lab.run(
        [*words, "tracking=none", "files=designs", "verbosity=quiet", f"output={tmp_path / 'run'}"]
    )
    row = result.trials.loc[0]
    assert (row["status"], row["interactions"]) == ("ok", 300)


@pytest.mark.parametrize(
    ("override", "key", "value"),
    [
        ("board.size=11", "board_size", 11),
        ("board=13x13", "board_size", 13),
        ("symmetry=y", "symmetry", "y"),
        ("max_crease_length=null", "max_crease_length", None),
        ("max_crease_length=3", "max_crease_length", 3.0),
        ("source_action=false", "source_action", False),
        ("straight_sectors=false", "straight_sectors", False),
        ("driving_angle.max=90", "driving_angle_max", 90.0),
        ("driving_angle.count=5", "driving_angle_count", 5),
        ("driving_angle.fixed=45.5", "driving_angle_fixed", 45.5),
        ("stuck=penalise", "stuck", "penalise"),
        ("capacity=100", "capacity", 100),
    ],
)
@pytest.mark.parametrize("order", [1, -1])
def test_the_command_line_wins_over_the_row(override: str, key: str, value: object, order: int) -> None:
    found = settings(*["target=bowl", override][::order])
    assert getattr(found.game, key) == value


def test_a_start_of_another_kind_takes_the_rows_cell_away() -> None:
    found = settings("target=cube", "start=crease", "symmetry=none")
    assert dict(found.start) == {"_target_": CREASE, "position": "choose", **UPPER}
    assert settings("target=cube", "start=square").start["size"] == "choose"
    assert settings("target=bowl", "start.size=2").start["size"] == 2


def test_an_experiment_overlay_sets_anything_and_the_command_line_still_wins(tmp_path: Path) -> None:
    (tmp_path / "experiment").mkdir()
    (tmp_path / "experiment/night.yaml").write_text(
        "# @package _global_\n"
        "defaults:\n  - override /target: bowl\n  - override /search: rdm\n  - override /symmetry: xy\n"
        "budget: 7\nmax_crease_length: 4\n"
    )
    searchpath = f"hydra.searchpath=[file://{tmp_path}]"
    found = settings(searchpath, "experiment=night")
    assert (found.task, found.method, found.budget) == ("bowl", "rdm", 7)
    assert (found.game.symmetry, found.game.max_crease_length) == ("xy", 4.0)
    found = settings(searchpath, "experiment=night", "target=cube", "symmetry=none", "budget=8")
    assert (found.task, found.game.symmetry, found.budget) == ("cube", "none", 8)


def test_distance_reaches_the_objective_and_the_target_is_built_once() -> None:
    parts = build_parts(settings("target=cube", "objective.distance=surface"))
    assert parts.objective.distance == "surface"
    assert parts.objective.target is parts.target


def test_a_mesh_is_found_from_another_folder(mesh: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(mesh.parent)
    found = settings("target=mesh", "target.path=part.obj")
    assert found.config["target"]["path"] == found.config["objective"]["target"]["path"] == str(mesh)
    assert found.target is not None
    assert found.target["path"] == "part.obj"  # as it was written, for messages


def test_scale_and_symmetry_of_a_mesh_are_said(mesh: Path) -> None:
    mesh.write_text("v -1 0 0\nv 1 0 0\nv 0 2 1\nf 1 2 3\n")
    said = {}
    by_hand = "target.scale=0.5", "target.translate=[0,0,0]"
    for symmetry in ("none", "y", "xyd"):
        found = settings("target=mesh", f"target.path={mesh}", *by_hand, f"symmetry={symmetry}")
        said[symmetry] = list(remarks(found, build_parts(found)))
    assert said["none"] == said["y"] == ["part.obj: 1 board cell = 2 units of the file"]
    assert said["xyd"][0] == said["y"][0]
    assert "symmetry=xyd" in said["xyd"][1]
    assert said["xyd"][1].endswith("the mesh has symmetry=y")
    found = settings("target=bowl")
    assert list(remarks(found, build_parts(found))) == []


def test_a_target_that_nobody_looks_at_is_said() -> None:
    found = settings("target=cube", "objective=table")
    assert list(remarks(found, build_parts(found))) == [
        "warning: the objective (table) does not look at the target (cube); leave target out"
    ]
    found = settings("objective=table")
    assert list(remarks(found, build_parts(found))) == []


def test_search_numbers_reach_the_searcher() -> None:
    found = settings("target=cube", "search=dfts", "search.children=4", "search.restarts=7")
    searcher: Any = build_parts(found).searcher
    assert (searcher.children, searcher.restarts) == (4, 7)


def test_no_file_has_a_key_that_yaml_1_1_reads_as_a_truth() -> None:
    for file in config_dir().rglob("*.yaml"):
        assert not re.search(r"^\s*(y|n|yes|no|on|off):", file.read_text(), re.MULTILINE | re.IGNORECASE), file


def test_help_explains_every_key() -> None:
    explained = explained_keys()
    known = {"tracking.kind", "symmetry.name"}  # the groups' own words
    for target in ("bowl", "cube", "face"):
        for search in ("mcts", "evo", "ppo", "bfts", "lns"):
            for key in flatten(settings(f"target={target}", f"search={search}").config):
                assert key in explained or "_target_" in key or key in known or key.startswith("objective.target."), key
    assert explained["search.children"] == "children sampled at each node"
    assert explained["driving_angle.max"].startswith("the largest driving angle, in degrees")


def test_a_search_has_to_fit_into_the_memory(monkeypatch: pytest.MonkeyPatch) -> None:
    large = settings("target=bowl", "capacity=100000", "driving_angle.count=100", "workers=2", "seed=0..1")
    for gigabytes in (2, 12):
        monkeypatch.setattr("origami_lab.config.settings.physical_memory", lambda n=gigabytes: n * 2**30)
        with pytest.raises(
            InputError, match="capacity=100000: .* choose" if gigabytes == 2 else "workers=2: .*at most 1"
        ):
            fit_workers(large)
    monkeypatch.setattr("origami_lab.config.settings.physical_memory", lambda: 2**40)
    assert fit_workers(large).workers == 2


NAMES = ["José/part (1).stl", "a#b&c;d!~^", "~/日本", "run/seed=3", "é=ü", "x y", "<ß>"]


@pytest.mark.parametrize("name", NAMES)
def test_names_of_files_need_no_quotes(name: str) -> None:
    assert settings("target=cube", f"output={name}").config["output"] == name


def test_names_of_files_in_lists_and_texts_in_quotes_stay_what_they_are() -> None:
    assert hydra_words(["a=é,b c,d"]) == ["a='é',b c,d"]
    for word in ("a='é,ü'", "a=[é,ü]", "a=range(1,5)", "a=choice(x,y)", "a=", "a=1,2", "a={b:é}", "~a"):
        assert hydra_words([word]) == [word]


def test_a_text_without_letters_in_the_terminals_encoding_is_refused() -> None:
    with pytest.raises(InputError, match=r"^output=.*: is no text in this terminal's encoding .*C\.UTF-8"):
        settings("target=cube", "output=\udcc3\udca9")
