"""What the page is told of a board: the sheet with its motion, what may be played, and what would come of it."""

from __future__ import annotations

import math
from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from origami_lab.drawing.viewer import viewer_data
from origami_lab.fold_format.writer import as_fold_file
from origami_lab.game.folded_sheet import FoldedSheet
from origami_lab.game.game import Game
from origami_lab.game.kernels.extension import outer_place
from origami_lab.game.kernels.legal_actions import placing_side
from origami_lab.game.kernels.play import replay_unchecked
from origami_lab.game.kernels.state import FIRST, SECOND, SELECTION, STATUS_NAMES, THIRD, States
from origami_lab.game.moves import Extend, Move, Place, Point, Source
from origami_lab.studio.design_board import PHASES, DesignBoard
from origami_lab.studio.motion_limits import closing_angles, motion_end
from origami_lab.studio.replies import (
    Ghost,
    Leaf,
    LegalPlace,
    Proposal,
    SheetData,
    SheetState,
    SourceSegment,
    TellBoard,
    TellMotion,
    TellPointed,
    Worth,
)

STEP = math.radians(3.0)
"""Between two states of the motion that the page has; it moves in straight lines between them."""
FOLDS = {-1: "mountain", 1: "valley"}
"""Rigid body modes and signs of driven creases in the page's words."""
NOTHING_MORE = {
    "terminated": "the game was ended here; undo to go on",
    "stuck": "nothing more can be extended",
    "capacity exhausted": "the board has no room for more vertices (capacity)",
    "not foldable": "the sheet does not fold",
}


def fine_angles(largest: float) -> NDArray[np.float64]:
    """Driving angles up to one, in even steps, radians."""
    return np.linspace(0.0, largest, max(1, math.ceil(largest / STEP - 1e-9)) + 1)[1:]


def worth_of(board: DesignBoard) -> Worth | None:
    """What a design is worth."""
    score = board.score()
    return None if score is None else Worth(value=score.value, angle=math.degrees(board.game.angles[score.angle]))


def sheet_data(game: Game, actions: Sequence[int]) -> SheetData | None:
    """The sheet of a log of actions, with its motion in fine steps; None before there is one."""
    states = game.replay(actions)
    if not int(states["n_vertices"][0]):
        return None
    reach = int(states["reach"][0])
    angles = closing_angles(game, actions, fine_angles(float(game.angles[reach - 1])))
    fold = as_fold_file(game.motion(actions, angles))
    data = viewer_data(fold, None, fold.best)
    # not validated: thousands of numbers that are ours
    return SheetData.model_construct(**{**data, "states": [SheetState.model_construct(**at) for at in data["states"]]})


def motion_told(revision: int, game: Game, actions: Sequence[int]) -> TellMotion:
    """The end of a design's motion, with the states up to there that :func:`sheet_data` has not."""
    end = motion_end(game, actions)
    last = float(game.angles[int(game.replay(actions)["reach"][0]) - 1])
    further = math.radians(end.free_to) - last
    angles = last + fine_angles(further) if further > 1e-6 else np.empty(0)
    design = game.motion(actions, closing_angles(game, actions, np.array([last, *angles])))
    fold = as_fold_file(design)
    states = [SheetState.model_construct(**at) for at in viewer_data(fold, None, fold.best)["states"][2:]]
    meeting = {frozenset(triangle.tolist()) for triangle in end.meeting}
    panels = {
        int(panel)
        for triangle, panel in zip(design.triangles.tolist(), design.triangle_panels, strict=True)
        if frozenset(triangle) in meeting
    }
    return TellMotion(revision=revision, free_to=end.free_to, ends=end.ends, panels=sorted(panels), further=states)


def board_view(
    board: DesignBoard, revision: int, sheet: SheetData | None, *, unsaved: bool, note: str | None = None
) -> TellBoard:
    """All that the page shows of a board; ``sheet`` is None where it has that already."""
    state, status = board.states[0], STATUS_NAMES[int(board.states["status"][0])]
    counts = _counts(board.game, board.states) if board.is_placed else (0, 0, 0)
    placing = board.phase in (FIRST, SECOND, THIRD)
    return TellBoard(
        revision=revision,
        what=board.steps[board.at].what,
        phase=PHASES[board.phase],  # type: ignore[arg-type]
        ended=NOTHING_MORE.get(status),
        sheet=sheet,
        reach=int(state["reach"]),
        leaves=[Leaf(at=at, says=None if reason is None else reason.says) for at, reason in board.leaves()],
        places=[LegalPlace(at=at, reach=reach) for at, reach in board.places()],
        placements=board.placements(),
        sources=[SourceSegment(number=k, ends=list(found.ends)) for k, found in enumerate(board.sources())],
        selected=board.selected_point if placing else None,
        mode=int(state["mode"]) if placing else 0,
        children=board.chosen_points,
        worth=worth_of(board),
        scoring=not board.is_scored,
        undo=board.at,
        redo=len(board.steps) - 1 - board.at,
        vertices=counts[0],
        creases=counts[1],
        panels=counts[2],
        unsaved=unsaved,
        note=note,
    )


def _counts(game: Game, states: States) -> tuple[int, int, int]:
    """Vertices, creases and panels of the whole sheet: of a sheet without holes, by Euler's formula."""
    sheet = game.sheet(states)
    vertices, leaves = len(sheet.flat), len(sheet.leaves)
    if not len(sheet.triangles):  # a single crease, and nothing on either side of it
        return vertices, 0, 0
    inner = len(sheet.creases) - _creases_on_boundary(sheet)
    return vertices, inner, inner + leaves - vertices + 1


def _creases_on_boundary(sheet: FoldedSheet) -> int:
    """Driven creases on which nothing has grown: they are edges of one panel only."""
    triangles = sheet.triangles
    sides = np.concatenate([triangles[:, [0, 1]], triangles[:, [1, 2]], triangles[:, [2, 0]]])
    seen, times = np.unique(np.sort(sides, axis=1), axis=0, return_counts=True)
    once = {(int(u), int(v)) for (u, v), count in zip(seen, times, strict=True) if count == 1}
    return sum(pair in once for pair, sign in sheet.creases.items() if sign)


# --- what would come of a place --------------------------------------------------------------------------------------


def pointed_view(board: DesignBoard, number: int, point: Point) -> TellPointed:
    """The answer to a point of the board, whichever image of it is meant."""
    at = board.playable(point)
    says = board.why_not(at)
    legal = says is None
    places: list[Point] = []
    ghost = None
    if legal and board.phase == SELECTION:
        places = board.first_places(at)
    elif legal and board.phase in (FIRST, SECOND):
        ghost = _outer_ghost(board, at)
    elif legal and board.phase == THIRD:
        ghost, says = _middle_ghost(board, at), board.warning(at)
    return TellPointed(id=number, at=at, legal=legal, says=says, places=places, ghost=ghost)


def _outer_ghost(board: DesignBoard, at: Point) -> Ghost:
    """The outer panel of a child: it is known before the other children are."""
    state, record, game = board.states[0], board.game.rules.record[0], board.game
    v, side = int(state["selected"]), int(placing_side(state, record))
    reach = int(state["reach"])
    child = np.array([outer_place(state, record, k, side, *at) for k in range(reach)])
    sheet = game.sheet(board.states)
    code = int(state["prev"][v] if side == 0 else state["next"][v])
    flat = np.array([state["xy"][v], game.symmetry.matrices[code & 7] @ state["xy"][code >> 3]])
    numbers = [int(np.flatnonzero((sheet.flat == corner).all(axis=1))[0]) for corner in flat]
    corners = np.stack([sheet.points[:, numbers[0]], sheet.points[:, numbers[1]], child], axis=1)  # (reach, 3, 3)
    return _imaged(game, game.angles[:reach], corners, [[0, 1, 2]], [(board.selected_point, at)])


def _middle_ghost(board: DesignBoard, at: Point) -> Ghost:
    """All panels that an extension adds, through its motion."""
    game, trial = board.game, board.states.copy()
    before = int(trial["n_triangles"][0])
    leaf, first, second = board.selected_point, *board.chosen_points
    game.play(trial, board.location(at))
    angles = fine_angles(float(game.angles[int(trial["reach"][0]) - 1]))
    actions = game.finished_actions(trial)
    angles = closing_angles(game, actions, angles)
    points = motion_points(game, actions, angles)
    # the new triangles of the representatives and their images
    new = game.sheet(_only_triangles(trial, before)).triangles
    used, numbers = np.unique(new, return_inverse=True)
    coords = points[:, used].reshape(len(angles), -1)
    creases = [[*leaf, *child] for child in (first, second, at)]
    return Ghost(
        angles=np.degrees(angles).tolist(),
        coords=np.round(coords, 4).tolist(),
        triangles=numbers.reshape(-1, 3).tolist(),
        creases=_all_images(game, creases),
    )


def _only_triangles(states: States, first: int) -> States:
    """A copy of a state that has only the triangles from a number on."""
    found = states.copy()
    count = int(found["n_triangles"][0]) - first
    for name in ("corners", "images"):
        found[name][0][:count] = states[name][0][first : first + count]
    found["n_triangles"] = count
    return found


def motion_points(game: Game, actions: Sequence[int], angles: NDArray[np.float64]) -> NDArray[np.float64]:
    """(K, V, 3) the folded vertices of legal actions at any driving angles within their reach."""
    record, states = game.rules.replaced(min_reach=1, collisions=0).record, game.new_states(1)
    count, log = len(game.angles), np.array(actions, dtype=np.int32)
    parts = []
    for start in range(0, len(angles), count):
        chunk = angles[start : start + count]
        record["angles"][0] = np.concatenate([chunk, np.full(count - len(chunk), chunk[-1])])
        reached = min(int(replay_unchecked(states, 0, record, log)), len(chunk))
        parts.append(FoldedSheet(states, 0, record).points[:reached])
    return np.concatenate(parts)


def _imaged(
    game: Game,
    angles: NDArray[np.float64],
    corners: NDArray[np.float64],
    triangles: list[list[int]],
    creases: list[tuple[Point, Point]],
) -> Ghost:
    """A ghost with all its mirror images."""
    count, parts, faces = corners.shape[1], [], []
    for number, matrix in enumerate(game.symmetry.matrices):
        turn = np.eye(3)
        turn[:2, :2] = matrix
        parts.append(corners @ turn.T)
        faces += [[k + number * count for k in triangle] for triangle in triangles]
    coords = np.concatenate(parts, axis=1).reshape(len(angles), -1)
    return Ghost(
        angles=np.degrees(angles).tolist(),
        coords=np.round(coords, 4).tolist(),
        triangles=faces,
        creases=_all_images(game, [[*a, *b] for a, b in creases]),
    )


def _all_images(game: Game, creases: list[list[int]]) -> list[list[int]]:
    """Creases (x, y, x, y) with all their mirror images, each once."""
    found: dict[tuple[int, ...], None] = {}
    for crease in creases:
        for matrix in game.symmetry.matrices:
            ends = (np.array(crease).reshape(2, 2) @ matrix.T).ravel()
            found[tuple(int(t) for t in ends)] = None
    return [list(ends) for ends in found]


def proposal_of(
    game: Game, number: int, present: Sequence[int], offered: Sequence[int], worth: Worth | None, says: str
) -> Proposal:
    """A proposal, both designs as logs of actions, with the creases that it has and the present one has not."""
    added = _creases_of(game, offered) - _creases_of(game, present)
    return Proposal(number=number, worth=worth, says=says, creases=[list(ends) for ends in sorted(added)])


def _creases_of(game: Game, actions: Sequence[int]) -> set[tuple[int, ...]]:
    """The creases (x, y, x, y) of a sheet, with all images; driven ones that are on its boundary among them."""
    states = game.replay(actions)
    if not int(states["n_vertices"][0]):
        return set()
    sheet = game.sheet(states)
    return {tuple(int(t) for end in sorted(sheet.flat[[u, v]].tolist()) for t in end) for u, v in sheet.creases}


def spoken(move: Move) -> str:
    """A move in a few words."""
    if isinstance(move, Extend):
        leaf, *children = (f"({x}, {y})".replace("-", "−") for x, y in (move.leaf, move.a, move.c, move.b))
        return f"extend {leaf} to {', '.join(children)}, {FOLDS[move.mode]}"
    if isinstance(move, Source):
        return f"driven crease at ({move.leaf[0]}, {move.leaf[1]}), {FOLDS[move.sign]}".replace("-", "−")
    return "start pattern" if isinstance(move, Place) else move.kind
