"""Settings that are chosen by the analysis of a mesh: ``auto`` becomes a value before a run, and is written as that.

Each is chosen unless it is given. A part that is laid on the board by hand (``target.fit``, ``target.translate`` or
``target.align_z``) is not analysed: whatever is auto then is what it was before there was an analysis.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from pathlib import Path
from typing import TYPE_CHECKING, Any

from origami_lab.config.config_file import read_config_file
from origami_lab.config.earlier_versions import as_of_today
from origami_lab.config.mesh_axis import is_mesh, resolved_up, with_target
from origami_lab.config.node import Node
from origami_lab.errors import InputError
from origami_lab.file_names import CONFIG
from origami_lab.files import expanded
from origami_lab.lengths import MILLIMETRES, millimetres
from origami_lab.targets.mesh_reader import unit_of

if TYPE_CHECKING:
    from origami_lab.parts.analysis import PartAnalysis

AUTO = "auto"
GROUPS_BELOW = {"xyd": ("xy", "y", "x"), "xy": ("y", "x")}
"""Symmetry groups within a group, the largest first."""
BY_HAND: dict[str, Any] = {
    **{"target.rotate": [0, 0, 0], "target.scale": 1.0, "target.translate": [0, 0, 0], "target.skin": None},
    "target.unit": None,
    **{"board.size": 25, "board.width": None, "board.height": None, "symmetry.name": "none"},
    **{"start.size": "choose", "start.position": None, "max_crease_length": 2.9, "source_action": True},
    **{"driving_angle.max": 179.90874767107852, "driving_angle.count": 10},
}
"""What a setting is that is auto, where no part is analysed."""


def with_part_settings(values: Node) -> tuple[dict[str, Any], tuple[str, ...]]:
    """A whole configuration without ``auto``, and what is to be said of a part that was analysed for it.

    A run that goes on keeps what was chosen when it began.

    Raises
    ------
    InputError
        If something is auto and there is no mesh to choose it by, or if the mesh cannot be read.
    """
    wanted = [key for key in BY_HAND if _get(values, key) == AUTO]
    if not wanted:
        return dict(values), ()
    target = values.get("target")
    if not isinstance(target, Mapping) or not is_mesh(target):
        raise InputError(wanted[0].removesuffix(".name"), AUTO, "is chosen by a part, which needs target=mesh")
    begun = _begun(values)
    if begun is not None:
        lines: tuple[str, ...] = ()
        chosen = {key: _get(begun, key) for key in wanted}
        if "start.size" in wanted and "start.position" in wanted:
            chosen["start"] = begun.get("start")
    elif is_by_hand(target):
        chosen, lines = {key: BY_HAND[key] for key in wanted}, ()
    else:
        chosen, lines = _chosen(values, wanted)
    return _with(values, chosen), lines


def is_by_hand(target: Node) -> bool:
    """Whether a mesh is laid on the board by the user's own settings, which say where its middle is to be."""
    places = (target.get("translate"), target.get("fit"), target.get("align_z"))
    return places[0] not in (None, AUTO) or places[1] is not None or places[2] not in (None, False)


def _chosen(values: Node, wanted: list[str]) -> tuple[dict[str, Any], tuple[str, ...]]:
    """What the analysis of the part says, for the settings that are auto."""
    from origami_lab.parts.analysis import analyse_part  # here: only a mesh needs it
    from origami_lab.parts.words import summary_lines
    from origami_lab.targets.mesh_target import MOST_FACES, check_settings

    target = resolved_up(values["target"])
    given = {key: None if target.get(key) == AUTO else target.get(key) for key in ("rotate", "scale")}
    names = ("path", "closed", "max_faces", "up", "skin")
    said = {name: target[name] for name in names if name in target and not (name == "skin" and target[name] == AUTO)}
    check_settings(**said, **{key: value for key, value in given.items() if value is not None})
    cell = None if values.get("cell") is None else millimetres(values["cell"])
    part = analyse_part(
        expanded(target["path"]),
        up=str(target.get("up", "z")),
        max_faces=target.get("max_faces", MOST_FACES),
        skin=None if target.get("skin") == AUTO and target.get("closed") is True else target.get("skin"),
        unit=AUTO if target.get("unit") == AUTO else unit_of(target["path"], target.get("unit")),
        cell=cell,
        **given,
    )
    chosen = settings_of(part)
    if cell is not None:  # the scale is a factor on the true size
        chosen["target.scale"] = part.setup.scale * cell / MILLIMETRES[part.unit]
    some_given = "board.size" not in wanted or "board.width" not in wanted or "board.height" not in wanted
    if some_given or _get(values, "symmetry.name") == "xyd":  # whose board is as wide as high
        chosen |= {"board.width": None, "board.height": None, "board.size": max(part.setup.board)}
    start = chosen["start"]
    if not {"start.size", "start.position"} <= set(wanted):  # another pattern, or a size or a place of a square
        start = {**values["start"], **{key.removeprefix("start."): BY_HAND[key] for key in wanted if "start." in key}}
    elif "symmetry.name" not in wanted and not _has(start, str(_get(values, "symmetry.name"))):
        start = {"_target_": "origami_lab.game.Square", "size": BY_HAND["start.size"], "position": None}
    chosen |= {key: BY_HAND[key] for key in wanted if key.startswith("start.")}
    board = [_get(values, key) if key not in wanted else chosen[key] for key in ("board.width", "board.height")]
    chosen["symmetry.name"] = _symmetry(part.setup.symmetry, start, board[0] == board[1])
    kept = {key: chosen[key] for key in wanted}
    if {"start.size", "start.position"} <= set(wanted):
        kept["start"] = start
    return kept, tuple(summary_lines(part))


def settings_of(part: PartAnalysis) -> dict[str, Any]:
    """The settings that suit a part, by their keys."""
    setup = part.setup
    wide, high = setup.board
    same = wide == high
    return {
        "target.rotate": [float(angle) for angle in setup.rotate],
        "target.scale": setup.scale,
        "target.translate": [float(shift) for shift in setup.translate],
        "target.skin": part.skin,
        "target.unit": part.unit,
        "board.size": max(wide, high),
        "board.width": None if same else wide,
        "board.height": None if same else high,
        "symmetry.name": setup.symmetry,
        "start": dict(setup.start),
        "max_crease_length": setup.max_crease_length,
        "source_action": setup.source_action,
        "driving_angle.max": setup.driving_angle_max,
        "driving_angle.count": setup.driving_angle_count,
    }


def _symmetry(own: str, start: Node, square_board: bool) -> str:
    """The largest group of the part that the board and the start pattern have, too."""
    for name in (own, *GROUPS_BELOW.get(own, ())):
        if not (name == "xyd" and not square_board) and _has(start, name):
            return name
    return "none"


def _has(start: Node, symmetry: str) -> bool:
    """Whether a start pattern has a symmetry; squares about the middle have all."""
    from origami_lab.game import start_patterns  # here: it brings kernels

    kind = getattr(start_patterns, str(start.get("_target_")).rpartition(".")[2], None)
    if kind not in (start_patterns.Crease, start_patterns.Panel):
        return True
    try:
        kind(**{key: value for key, value in start.items() if key != "_target_"}).check_symmetry(symmetry)
    except (InputError, TypeError, KeyError):
        return False
    return True


def _begun(values: Node) -> dict[str, Any] | None:
    """The configuration of the run that is to go on; None if there is none, or none that can be read."""
    if values.get("resume") is not True or not isinstance(values.get("output"), str):
        return None
    try:
        found = read_config_file("output", Path(expanded(values["output"])) / CONFIG)
    except InputError:  # the run folder says so
        return None
    return as_of_today(found) if is_mesh(found.get("target")) else None


def _get(values: Node, key: str) -> Any:
    group, _, name = key.partition(".")
    part = values.get(group)
    if not name:
        return part
    return part.get(name) if isinstance(part, Mapping) else None


def _with(values: Node, chosen: Node) -> dict[str, Any]:
    """The configuration with other values, the board's also where a mesh has them."""
    found = dict(values)
    for key, value in sorted(chosen.items(), key=lambda item: item[0] == "start"):
        group, _, name = key.partition(".")
        found[group] = value if not name else {**found[group], name: value}
    sides = {f"board_{name}": found["board"].get(name) for name in ("size", "width", "height")}
    placed = dict(_placement(chosen))
    return with_target(found, lambda node: {**node, **placed, **{k: v for k, v in sides.items() if k in node}})


def _placement(chosen: Node) -> Iterator[tuple[str, Any]]:
    for key, value in chosen.items():
        if key.startswith("target."):
            yield key.removeprefix("target."), value
