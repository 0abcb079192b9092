"""Files that are made to be certified though they must not be, by the dozen, and their honest neighbours.

Every attack yields files whose claim is false for a reason that is known from how they are made: two states at one
driving angle, a second mechanism, panels that cross where tolerances are to be stretched, frames that nobody looks at,
rounding. An honest file beside each kind shows that it is not the kind alone that is turned down.
"""

from __future__ import annotations

import copy
import math
from collections.abc import Callable, Iterator, Sequence
from contextlib import suppress
from dataclasses import dataclass, replace
from itertools import pairwise
from typing import Any

import numpy as np
from numpy.typing import NDArray

from origami_lab.errors import InputError
from origami_lab.fold_format.writer import to_fold
from origami_lab.game.moves import Extend
from tests.known_designs import closed_forms as designs
from tests.known_designs.fold_documents import miura_sheet
from tests.verification.dense import RandomPattern, first_crossing, random_pattern

Array = NDArray[np.float64]
Fold = dict[str, Any]
FOLDED = {"frame_parent": 0, "frame_inherit": True, "frame_classes": ["foldedForm"]}
DRIVING, DRIVEN = "origami_lab:driving_angle", "edges_origami_lab:driven"


@dataclass(frozen=True)
class Attack:
    """A file and whether its claim holds."""

    name: str
    fold: Fold
    honest: bool = False
    """Whether it ought to be certified."""


def free_pattern(rng: np.random.Generator, most: int = 30) -> tuple[RandomPattern, Fold]:
    """A random pattern of the game with at most so many panels that a dense look finds free of crossings."""
    while True:
        pattern = random_pattern(rng, collisions=True)
        design = pattern.design()
        with suppress(ValueError):  # between its angles the motion may not exist
            if len(design.panels) <= most and math.isinf(first_crossing(pattern, 300)):
                return pattern, to_fold(design)


# two states at one driving angle


def other_branch(pattern: RandomPattern, rng: np.random.Generator) -> Fold | None:
    """The same crease pattern folded with the rigid body mode of one vertex turned over, or None if it does not."""
    moves = pattern.game.moves(pattern.actions)
    extensions = [k for k, move in enumerate(moves) if isinstance(move, Extend)]
    k = int(rng.choice(extensions))
    move = moves[k]
    assert isinstance(move, Extend)
    moves[k] = replace(move, mode=-move.mode)
    game = pattern.game
    try:
        actions = tuple(int(a) for a in game.finished_actions(game.replay_moves(moves)))
        other = to_fold(game.motion(actions, game.angles[: pattern.reach], {}))
    except (InputError, ValueError):
        return None
    return other


def same_angle(rng: np.random.Generator) -> Attack:
    """One more frame at the driving angle of another one, of another branch; sometimes it is the best state."""
    while True:
        pattern, fold = free_pattern(rng)
        other = other_branch(pattern, rng)
        if other is None or other["vertices_coords"] != fold["vertices_coords"]:
            continue
        if other["edges_vertices"] != fold["edges_vertices"]:
            continue
        frames = fold["file_frames"]
        k = int(rng.integers(len(frames)))
        angle = frames[k][DRIVING]
        [twin] = [frame for frame in other["file_frames"] if abs(frame[DRIVING] - angle) < 1e-9]
        differ = np.abs(np.subtract(twin["edges_foldAngle"], frames[k]["edges_foldAngle"]))
        if np.minimum(differ, 360.0 - differ).max() < 1e-3:
            continue
        twin = copy.deepcopy(twin)
        twin["edges_assignment"] = letters_of(twin, fold)
        for frame in frames:
            frame["edges_assignment"] = letters_of(frame, fold)
        where = int(rng.integers(3))
        frames.insert((k, k + 1, len(frames))[where], twin)
        if rng.integers(2):  # the crease pattern's own letters and angles are those of the twin
            fold["edges_foldAngle"], fold["edges_assignment"] = twin["edges_foldAngle"], twin["edges_assignment"]
        return Attack(f"same angle, {('before', 'after', 'last')[where]}", fold)


def letters_of(frame: Fold, fold: Fold) -> list[str]:
    """Mountains and valleys of a frame by its fold angles."""
    return [
        "B" if known == "B" else "F" if abs(angle) < 1e-4 else "V" if angle > 0 else "M"
        for known, angle in zip(fold["edges_assignment"], frame["edges_foldAngle"], strict=True)
    ]


# second mechanisms


def with_flap(fold: Fold, angles: Sequence[float], rng: np.random.Generator) -> Fold:
    """A flat sheet with a triangular flap on one of its sides, the only crease that is driven and that folds."""
    coords = np.array(fold["vertices_coords"], dtype=float)
    edges = [tuple(edge) for edge in fold["edges_vertices"]]
    letters = list(fold["edges_assignment"])
    faces = [list(face) for face in fold["faces_vertices"]]
    sides = {(u, v) for face in faces for u, v in zip(face, [*face[1:], face[0]], strict=True)}
    outer = [(u, v) for u, v in sides if (v, u) not in sides]
    hull = [side for side in outer if _outermost(coords, side)]
    u, v = hull[int(rng.integers(len(hull)))]
    along = coords[v] - coords[u]
    out = np.array([along[1], -along[0]])  # counter-clockwise faces have the outside on the right
    tip = (coords[u] + coords[v]) / 2 + 0.4 * out
    count = len(coords)
    coords = np.vstack([coords, tip])
    e = next(k for k, edge in enumerate(edges) if set(edge) == {u, v})
    letters[e] = "V"
    edges += [(u, count), (count, v)]
    letters += ["B", "B"]
    faces.append([v, u, count])
    driven = [k == e for k in range(len(edges))]
    frames = []
    for angle in angles:
        points = np.column_stack([coords, np.zeros(len(coords))])
        axis = np.array([*(along / np.linalg.norm(along)), 0.0])
        left_to_right = designs.rotation(axis, -math.radians(angle))
        points[count] = points[u] + left_to_right @ (points[count] - points[u])
        stated = [angle if k == e else 0.0 for k in range(len(edges))]
        frames.append(FOLDED | {DRIVING: angle, "vertices_coords": points.tolist(), "edges_foldAngle": stated})
    return {
        "file_spec": 1.2,
        "frame_classes": ["creasePattern"],
        "vertices_coords": coords.tolist(),
        "edges_vertices": [list(edge) for edge in edges],
        "edges_assignment": letters,
        "edges_foldAngle": frames[-1]["edges_foldAngle"],
        "faces_vertices": faces,
        DRIVEN: driven,
        "file_frames": frames,
    }


def _outermost(coords: Array, side: tuple[int, int]) -> bool:
    """Whether all of a sheet lies on the left of one of its sides: a flap on the right is then free."""
    a, b = coords[list(side)]
    rel = coords - a
    return bool(np.all((b - a)[0] * rel[:, 1] - (b - a)[1] * rel[:, 0] > -1e-9))


def star(headings: Array, letters: Sequence[str]) -> Fold:
    """An interior vertex in the middle of a polygon with a crease to each corner; flat."""
    count = len(headings)
    rim = np.column_stack([np.cos(headings), np.sin(headings)]) * 2.0
    points, faces, edges, marks = [(0.0, 0.0), *map(tuple, rim)], [], [], []
    for i in range(count):
        j = (i + 1) % count
        edges.append((0, i + 1))
        marks.append(letters[i % len(letters)])
        gap = (headings[j] - headings[i]) % (2 * math.pi)
        ring = [0, i + 1]
        if gap > 2.5:  # one more corner keeps the panel a polygon around its sector
            for part in (1, 2):
                middle = headings[i] + gap * part / 3.0
                points.append((2.0 * math.cos(middle), 2.0 * math.sin(middle)))
                ring.append(len(points) - 1)
        ring.append(j + 1)
        edges += list(pairwise(ring[1:]))
        marks += ["B"] * (len(ring) - 2)
        faces.append(ring)
    return {
        "vertices_coords": [list(point) for point in points],
        "edges_vertices": [list(edge) for edge in edges],
        "edges_assignment": marks,
        "faces_vertices": faces,
    }


def sectors(rng: np.random.Generator, count: int, least: float = 0.35) -> Array:
    """Headings of so many creases, each sector between ``least`` and 180° less that."""
    while True:
        parts = rng.dirichlet(np.full(count, 3.0)) * 2 * math.pi
        if parts.min() > least and parts.max() < math.pi - least:
            return np.asarray(np.cumsum(parts) - parts[0])


def second_mechanism(rng: np.random.Generator) -> Attack:
    """A driven flap on a sheet that lies flat in every state and would fold by itself."""
    letters = ["U"] if rng.integers(2) else ["M", "V"]
    if rng.integers(2):
        rows, columns = (int(n) for n in rng.integers(2, 5, 2))
        sheet = miura_sheet(rows, columns, float(rng.uniform(40.0, 80.0)), 30.0)
        sheet["edges_assignment"] = [
            "B" if letter == "B" else str(rng.choice(letters)) for letter in sheet["edges_assignment"]
        ]
        name = f"Miura {rows}×{columns}"
    else:
        count = int(rng.integers(4, 8))
        sheet, name = star(sectors(rng, count), letters), f"vertex of degree {count}"
    angles = np.sort(rng.uniform(5.0, 170.0, int(rng.integers(1, 6))))
    return Attack(f"flat second mechanism, {name}", with_flap(sheet, angles.tolist(), rng))


def blocked(rng: np.random.Generator) -> Attack:
    """The same with an interior vertex that cannot fold: of degree 3, or with all creases on one side."""
    if rng.integers(2):
        headings = sectors(rng, 3)
    else:
        headings = np.sort(rng.uniform(0.1, math.pi - 0.3, 4))
        while np.diff(headings).min() < 0.3:
            headings = np.sort(rng.uniform(0.1, math.pi - 0.3, 4))
    sheet = star(headings, ["U"])
    return Attack("blocked freedoms", with_flap(sheet, [20.0, 60.0], rng), honest=True)


# tolerances


def gate(excess: float, far: float, kind: str, last: float = 180.0, frames: int = 10) -> Fold:
    """Two flaps that fold onto their base and overlap in the middle by twice ``excess``; negative: they do not meet.

    Something far away makes the file, or the sheet, large: a vertex that nothing uses, or a spike of the base.
    """
    tip = 2.0 + excess
    vertices = [(-1.0, 0.0), (1.0, 0.0), (1.0, 1.0), (-1.0, 1.0), (tip, 0.0), (tip, 1.0), (-tip, 0.0), (-tip, 1.0)]
    base = [0, 1, 2, 3]
    if kind == "spike":
        vertices.append((0.0, -far))
        base = [0, len(vertices) - 1, 1, 2, 3]
    panels = [base, [1, 4, 5, 2], [0, 3, 7, 6]]

    def fold(rho: float) -> Array:
        x, z = 1.0 + (tip - 1.0) * math.cos(rho), (tip - 1.0) * math.sin(rho)
        points = np.column_stack([np.array(vertices), np.zeros(len(vertices))])
        points[[4, 5, 6, 7], 0] = x, x, -x, -x
        points[[4, 5, 6, 7], 2] = z
        return points

    angles = np.radians(np.linspace(last / frames, last, frames))
    made = to_fold(
        designs.design(vertices, panels, fold, best=frames - 1, driven=[(1, 2), (0, 3)], driving_angles=angles)
    )
    if kind == "unused":
        made["vertices_coords"].append([far, 0.0])
        for frame in made["file_frames"]:
            frame["vertices_coords"].append([far, 0.0, 0.0])
        made.pop("vertices_origami_lab:mode", None)
    return made


def stretched(rng: np.random.Generator) -> Attack:
    """A gate whose flaps cross by a little, in a file that is large."""
    kind = str(rng.choice(["unused", "spike"]))
    excess = float(10.0 ** rng.uniform(-5.0, -2.0))
    far = float(10.0 ** rng.uniform(1.0, 5.0))
    last = float(rng.choice([180.0, 179.9]))
    return Attack(f"gate, {kind} {far:.0g}, {excess:.0g}", gate(excess, far, kind, last))


# frames that nobody looks at


def _garbage(fold: Fold, rng: np.random.Generator) -> Fold:
    return {
        DRIVING: float(rng.uniform(1.0, 150.0)),
        "vertices_coords": rng.normal(size=(len(fold["vertices_coords"]), 3)).tolist(),
    }


def garbage_3d(fold: Fold, rng: np.random.Generator) -> None:
    fold["file_frames"].append(FOLDED | _garbage(fold, rng))


def garbage_2d(fold: Fold, rng: np.random.Generator) -> None:
    frame = FOLDED | _garbage(fold, rng) | {"frame_classes": [[], ["foldedForm"]][int(rng.integers(2))]}
    frame["vertices_coords"] = rng.normal(size=(len(fold["vertices_coords"]), 2)).tolist()
    fold["file_frames"].append(frame)


def no_class(fold: Fold, rng: np.random.Generator) -> None:
    frame = FOLDED | _garbage(fold, rng)
    del frame["frame_classes"]
    fold["file_frames"].append(frame)


def other_edges(fold: Fold, rng: np.random.Generator) -> None:
    frame = FOLDED | _garbage(fold, rng)
    frame["edges_vertices"] = fold["edges_vertices"][:-1]
    frame["edges_assignment"] = fold["edges_assignment"][:-1]
    frame["edges_foldAngle"] = fold["edges_foldAngle"][:-1]
    fold["file_frames"].append(frame)


def nothing_in_it(fold: Fold, rng: np.random.Generator) -> None:
    fold["file_frames"].append(
        {"frame_classes": ["foldedForm"], "frame_inherit": bool(rng.integers(2)), "frame_parent": 0}
    )


def angles_only(fold: Fold, rng: np.random.Generator) -> None:
    """Fold angles that do not close around interior vertices."""
    last = fold["file_frames"][-1]["edges_foldAngle"]
    angles = [angle * float(rng.uniform(0.3, 0.8)) for angle in last]
    fold["file_frames"].append(FOLDED | {"edges_foldAngle": angles})


def angles_partly(fold: Fold, rng: np.random.Generator) -> None:
    angles: list[float | None] = list(fold["file_frames"][-1]["edges_foldAngle"])
    inner = [e for e, letter in enumerate(fold["edges_assignment"]) if letter != "B"]
    angles[int(rng.choice(inner))] = None
    fold["file_frames"].append(FOLDED | {"edges_foldAngle": angles})


def bent(fold: Fold, rng: np.random.Generator) -> None:
    frame = fold["file_frames"][int(rng.integers(len(fold["file_frames"])))]
    big = [face for face in fold["faces_vertices"] if len(face) > 3]
    v = int(rng.choice(big[0] if big else fold["faces_vertices"][0]))
    frame["vertices_coords"][v][int(rng.integers(3))] += float(rng.choice([-1.0, 1.0]) * 10.0 ** rng.uniform(-2.5, 0.0))


def turned_letter(fold: Fold, rng: np.random.Generator) -> None:
    folds = [e for e, angle in enumerate(fold["edges_foldAngle"]) if abs(angle) > 1.0]
    e = int(rng.choice(folds))
    fold["edges_assignment"][e] = {"M": "V", "V": "M"}[fold["edges_assignment"][e]]
    for frame in fold["file_frames"]:
        frame.setdefault("edges_assignment", [])  # every state keeps letters of its own, so that only the key's lie
        frame["edges_assignment"] = letters_of(frame, fold)


def turned_angles(fold: Fold, rng: np.random.Generator) -> None:
    inner = [e for e, letter in enumerate(fold["edges_assignment"]) if letter != "B"]
    e = int(rng.choice(inner))
    fold["edges_foldAngle"][e] = float(np.clip(fold["edges_foldAngle"][e] + rng.choice([-3.0, 3.0]), -180.0, 180.0))


SPOILERS: tuple[Callable[[Fold, np.random.Generator], None], ...] = (
    *(garbage_3d, garbage_2d, no_class, other_edges, nothing_in_it),
    *(angles_only, angles_partly, bent, turned_letter, turned_angles),
)


def unseen(rng: np.random.Generator) -> Attack:
    """A pattern of the game with a frame, or letters, that are wrong where nobody might look."""
    _, fold = free_pattern(rng)
    spoil = SPOILERS[int(rng.integers(len(SPOILERS)))]
    spoil(fold, rng)
    return Attack(f"frames, {spoil.__name__}", fold)


# crossings, and rounding


def crossing(rng: np.random.Generator) -> Attack:
    """A pattern whose panels cross, as many of its states as one likes left out."""
    while True:
        pattern = random_pattern(rng, collisions=False)
        try:
            if len(pattern.design().panels) > 30 or math.isinf(first_crossing(pattern, 300)):
                continue
        except ValueError:
            continue
        fold = to_fold(pattern.design())
        frames = fold["file_frames"]
        kept = rng.random(len(frames)) < 0.6
        kept[-1] = True
        fold["file_frames"] = [frame for frame, keep in zip(frames, kept, strict=True) if keep]
        return Attack("crossing", fold)


def rounded(fold: Fold, digits: int) -> Fold:
    """All coordinates and fold angles with so many decimals."""
    fold = copy.deepcopy(fold)
    for frame in (fold, *fold["file_frames"]):
        for key in ("vertices_coords", "edges_foldAngle"):
            if key in frame:
                frame[key] = _round(frame[key], digits)
    return fold


def _round(value: Any, digits: int) -> Any:
    if isinstance(value, list):
        return [_round(item, digits) for item in value]
    return None if value is None else round(float(value), digits)


def rounding(rng: np.random.Generator) -> Attack:
    """One of the other attacks with three to six decimals, scaled and turned so that no coordinate is round."""
    attack = (same_angle, second_mechanism, stretched, unseen, crossing)[int(rng.integers(5))](rng)
    if attack.name.startswith("gate"):  # an overlap that rounding takes away is no fault of the rounded file
        attack = Attack("gate", gate(float(10.0 ** rng.uniform(-2.0, -1.0)), 100.0, "unused", 179.0))
    digits = int(rng.integers(3, 7))
    return Attack(f"{attack.name}, {digits} decimals", rounded(askew(attack.fold, rng), digits))


def askew(fold: Fold, rng: np.random.Generator) -> Fold:
    """The same design scaled by a number that is not round and turned in its plane."""
    fold = copy.deepcopy(fold)
    turn = float(rng.uniform(0.0, 2.0 * math.pi))
    scale = float(rng.uniform(0.7, 1.4))
    matrix = scale * np.array([[math.cos(turn), -math.sin(turn)], [math.sin(turn), math.cos(turn)]])
    for frame in (fold, *fold["file_frames"]):
        if "vertices_coords" in frame:
            frame["vertices_coords"] = [
                [*(matrix @ point[:2]).tolist(), *(scale * z for z in point[2:])] for point in frame["vertices_coords"]
            ]
    return fold


def honest(rng: np.random.Generator) -> Attack:
    """A pattern of the game as it is, or a gate whose flaps do not meet."""
    if rng.integers(2):
        return Attack("a pattern of the game", free_pattern(rng)[1], honest=True)
    return Attack("an open gate", gate(-float(rng.uniform(0.01, 0.5)), 10.0, "unused", 179.0), honest=True)


ATTACKS: tuple[Callable[[np.random.Generator], Attack], ...] = (
    *(same_angle, second_mechanism, stretched, unseen, crossing, rounding),
    *(blocked, honest),
)


def files(count: int, seed: int) -> Iterator[Attack]:
    """So many files of every kind."""
    for number, attack in enumerate(ATTACKS):
        rng = np.random.default_rng([seed, number])
        for _ in range(count):
            yield attack(rng)
