"""Taking out of designs what they do not need: what is left folds as before, and costs what was allowed."""

from __future__ import annotations

import math
from types import MappingProxyType

import numpy as np
import pytest
from trimesh.triangles import closest_point

from origami_lab.errors import InputError
from origami_lab.game.crease_pattern import CreasePattern
from origami_lab.game.game import Game
from origami_lab.game.moves import Extend, Place
from origami_lab.game.start_patterns import Start
from origami_lab.objectives.shape import ShapeObjective
from origami_lab.polish import GameDesign, PolishedDesign, pattern_figures, simplify_design
from origami_lab.polish.finer_board import fine_board
from origami_lab.polish.flat_creases import without_flat_creases
from origami_lab.polish.laid_design import folded_design
from origami_lab.polish.pattern_measures import width_of
from origami_lab.polish.simplifier import distances_to
from origami_lab.targets.solids import bowl
from origami_lab.targets.solids import pyramid as pyramid_target
from origami_lab.targets.target import Target
from origami_lab.verification.verify_design import verify
from tests.known_designs import closed_forms as designs
from tests.polish.designs import GROUPS, actions_of, cube, pyramid, random_designs


class Wide:
    """Rewards the extent along x, which the four flaps and the caps on them make."""

    def score(self, sheet: object) -> float:
        return float(np.ptp(sheet.points[-1, :, 0]))  # type: ignore[attr-defined]


WALLS = [Place(1, 1), Extend((-1, 1), -1, (-1, 3), (-3, 1), (-2, 2))]
"""The cube's moves without its lid."""


def dot() -> ShapeObjective:
    """A target about the origin: the corner that is furthest from there decides, and that is one of a wall."""
    corners = np.array([(-0.1, -0.1, 0.0), (0.1, -0.1, 0.0), (0.0, 0.1, 0.0)])
    return ShapeObjective(Target("dot", corners, np.array([(0, 1, 2)]), closed=False))


def test_what_decides_nothing_goes() -> None:
    """The cube's lid lies nearer to the origin than the corners of its walls; its source goes with it."""
    game, actions = cube()
    made = simplify_design(GameDesign(game, dot(), actions), 0.0)
    assert made.removed == 2
    assert made.value >= made.value_before
    alone = game.design(actions_of(game, WALLS))
    assert made.figures == pattern_figures(alone)
    assert made.figures_before.creases > made.figures.creases
    again = game.replay(made.design.actions)  # it is still a design of the game
    assert game.moves(made.design.actions) == WALLS
    assert int(again["n_extensions"][0]) == 1
    assert verify(made.design).verdict == made.certificate.verdict == "certified"


def test_what_is_needed_stays() -> None:
    for (game, actions), target in ((pyramid(), pyramid_target()),):
        made = simplify_design(GameDesign(game, ShapeObjective(target), actions), 0.01)
        assert made.removed == 0
        assert made.figures == made.figures_before


def lid_and_far() -> ShapeObjective:
    """A target in two pieces: one on the cube's lid, and one far below, whose distance decides the return."""
    piece = np.array([(-0.3, -0.2, 2.0), (0.3, -0.2, 2.0), (0.0, 0.4, 2.0)])
    corners = np.vstack([piece, piece - (0.0, 0.0, 11.0)])
    return ShapeObjective(Target("pieces", corners, np.array([(0, 1, 2), (3, 4, 5)]), closed=False))


@pytest.mark.parametrize("polished", [False, True])
def test_what_covers_stays_though_no_return_sees_it(polished: bool) -> None:
    """Without the lid the return is the same, but a point of the piece on it is up to 1 cell from the walls' rim."""
    game, actions = cube(driving_angle_fixed=89.9)
    objective, angle = lid_and_far(), math.radians(89.9)
    board = fine_board(game, actions, 64)
    whole = PolishedDesign(board, angle, objective) if polished else GameDesign(game, objective, actions)
    for tolerance, removed in ((0.0, 0), (0.9, 0), (1.01, 2)):
        made = simplify_design(whole, tolerance)
        assert made.removed == removed, tolerance
        assert made.value == pytest.approx(made.value_before, abs=1e-9)


def plain_distances(design: CreasePattern, points: np.ndarray) -> np.ndarray:
    """(n,) how far points are from the folded sheet, by trimesh, triangle by triangle."""
    triangles = design.folded[design.best][design.triangles]
    nearest = [closest_point(np.broadcast_to(t, (len(points), 3, 3)), points) for t in triangles]
    return np.asarray(np.linalg.norm(np.stack(nearest) - points, axis=2).min(axis=0))


@pytest.mark.parametrize("tolerance", [0.0, 0.5])
@pytest.mark.parametrize(("symmetry", "start"), GROUPS)
def test_no_point_gets_further_away_and_nothing_else_could_go(symmetry: str, start: Start, tolerance: float) -> None:
    """Against distances from scratch: all points stay within the tolerance, and without any more move one would not."""
    game, objective = Game(9, symmetry, start, driving_angle_fixed=50.0), ShapeObjective(bowl(outer=4.0))
    actions = next(random_designs(game, 1, seed=11))
    made = simplify_design(GameDesign(game, objective, actions), tolerance)
    before, points = game.design(actions), objective.cover.triangles[:, 0]
    some = points[::9]
    assert (plain_distances(made.design, some) - plain_distances(before, some)).max() <= tolerance + 1e-9
    assert made.value >= made.value_before - tolerance - 1e-9
    left = GameDesign(game, objective, made.design.actions)
    for m in left.removable:
        goes = np.zeros(left.moves, dtype=np.int8)
        goes[m] = 1
        less = left.without(goes)
        if less is None:
            continue  # it does not fold
        growth = distances_to(less.design, points) - distances_to(before, points)
        worst = points[[np.argmax(growth)]]
        lost = plain_distances(less.design, worst) - plain_distances(before, worst)
        assert lost[0] == pytest.approx(growth.max(), abs=1e-9)
        assert max(float(growth.max()), made.value_before - less.value) > tolerance


def test_losses_add_up_to_no_more_than_the_tolerance() -> None:
    """Each cap of the cube's lid costs; with a large tolerance all goes that leaves anything, with none nothing."""
    game, actions = cube()
    whole = GameDesign(game, Wide(), actions)
    for tolerance in (0.0, 0.5, 100.0):
        made = simplify_design(whole, tolerance)
        assert made.value >= made.value_before - tolerance
    assert simplify_design(whole, 100.0).removed > 0


def test_so_it_does_off_the_grid() -> None:
    game, actions = cube()
    angle = float(game.angles[4])
    made = simplify_design(PolishedDesign(fine_board(game, actions, 64), angle, dot()), 0.0)
    assert made.removed == 2
    assert made.board is not None
    alone = folded_design(fine_board(game, actions_of(game, WALLS), 64), angle, {})
    assert np.array_equal(made.design.vertices, alone.vertices)
    assert np.abs(made.design.folded - alone.folded).max() < 1e-12
    corner = np.array([1 + 2 * math.cos(angle), 1.0, 2 * math.sin(angle)])  # of a wall, from the dot's nearest corner
    assert made.value == pytest.approx(-np.linalg.norm(corner), abs=0.15)


def test_a_tolerance_must_be_a_number() -> None:
    game, actions = pyramid()
    for wrong in (-1.0, math.nan, math.inf):
        with pytest.raises(InputError, match="tolerance"):
            simplify_design(GameDesign(game, ShapeObjective(pyramid_target()), actions), wrong)


def flat_cross() -> CreasePattern:
    """A sheet of four squares about a vertex, folded along x only: the two creases along y stay flat."""
    vertices = [(x, y) for y in (-1, 0, 1) for x in (-1, 0, 1)]
    panels = [(0, 1, 4, 3), (1, 2, 5, 4), (3, 4, 7, 6), (4, 5, 8, 7)]

    def fold(rho: float) -> np.ndarray:
        return np.array(
            [(x, y, 0.0) if y <= 0 else (x, y * np.cos(rho), y * np.sin(rho)) for x, y in vertices], dtype=float
        )

    return designs.design(vertices, panels, fold, best=4, driven=[(3, 4), (4, 5)])


def test_creases_that_never_fold_go_and_so_do_the_vertices_on_them() -> None:
    left = without_flat_creases(flat_cross())
    assert len(left.panels) == 2
    assert len(left.vertices) == 6  # the four corners and the two ends of the crease
    assert int((~left.boundary).sum()) == 1
    crease = int(np.flatnonzero(~left.boundary)[0])
    assert sorted(map(tuple, left.vertices[left.edges[crease]].tolist())) == [(-1.0, 0.0), (1.0, 0.0)]
    assert np.allclose(np.abs(left.fold_angles[:, crease]), left.driving_angles, atol=1e-9)
    assert left.driven[crease]
    assert len(left.triangles) == 4
    assert verify(left).verdict == "certified"


def test_a_pattern_without_such_creases_stays_what_it_is() -> None:
    for design in (designs.pyramid(), designs.single_valley(), designs.miura()):
        assert without_flat_creases(design) is design


def test_a_panel_with_a_hole_is_never_made() -> None:
    """Four flat panels around a square that folds out of them cannot become one: the fourth stays apart."""
    vertices = [(-1, -1), (1, -1), (1, 1), (-1, 1), (-3, -3), (3, -3), (3, 3), (-3, 3)]
    panels = [(0, 1, 2, 3), *((4 + i, 4 + (i + 1) % 4, (i + 1) % 4, i) for i in range(4))]
    still = np.array([(x, y, 0.0) for x, y in vertices])
    flat = designs.design(vertices, panels, lambda rho: still, best=4)
    # the square's own sides are said to fold, whatever the coordinates
    inner = (flat.edges < 4).all(axis=1)
    object.__setattr__(flat, "fold_angles", np.where(inner, 0.5, flat.fold_angles))
    left = without_flat_creases(flat)
    assert sorted(len(panel) for panel in left.panels) == [4, 4, 8]
    assert int((~left.boundary).sum()) == 4 + 2
    assert len(left.vertices) == 8


def test_figures_in_closed_form() -> None:
    pattern = designs.pyramid()
    figures = pattern_figures(pattern)
    assert (figures.creases, figures.panels) == (16, 13)
    assert figures.smallest_sector == pytest.approx(math.degrees(math.atan2(1, 2)))  # at a tip, of a pleat
    for angle in (0.0, 0.7):
        turn = np.array([[math.cos(angle), -math.sin(angle)], [math.sin(angle), math.cos(angle)]])
        assert width_of(np.array([(0, 0), (3, 0), (3, 1), (0, 1)]) @ turn.T) == pytest.approx(1)
        assert width_of(np.array([(0, 0), (3, 0), (0, 4)]) @ turn.T) == pytest.approx(12 / 5)  # the height on 5
    assert MappingProxyType(figures.to_json())["panels"] == 13
