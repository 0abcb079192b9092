"""Symmetry groups: axioms, and the fundamental domain meets every orbit."""

from __future__ import annotations

import numpy as np
import pytest

from origami_lab.geometry.groups import GROUPS, SymmetryGroup

BOARD = np.array([(x, y) for x in range(-6, 7) for y in range(-6, 7)])
ORDERS = {"none": 1, "y": 2, "x": 2, "xy": 4, "xyd": 8}


@pytest.fixture(params=sorted(GROUPS))
def group(request: pytest.FixtureRequest) -> SymmetryGroup:
    return GROUPS[request.param]


def test_is_a_group_of_isometries(group: SymmetryGroup) -> None:
    assert group.order == ORDERS[group.name]
    assert (group.matrices[0] == np.eye(2)).all()
    assert (np.einsum("gij,gkj->gik", group.matrices, group.matrices) == np.eye(2)).all()
    assert len({m.tobytes() for m in group.matrices}) == group.order
    for i, p in enumerate(group.matrices):
        for j, q in enumerate(group.matrices):
            assert (group.matrices[group.products[i, j]] == p @ q).all()
        assert (p @ group.matrices[group.inverses[i]] == np.eye(2)).all()


def test_names_say_the_mirrors() -> None:
    """``y`` is the mirror in the y axis, x → −x; ``xyd`` has the diagonals as well."""
    assert GROUPS["y"].matrices[1].tolist() == [[-1, 0], [0, 1]]
    assert GROUPS["x"].matrices[1].tolist() == [[1, 0], [0, -1]]
    mirrors = [m.tolist() for m in GROUPS["xyd"].matrices if round(np.linalg.det(m)) == -1]
    assert sorted(mirrors) == sorted([[[-1, 0], [0, 1]], [[1, 0], [0, -1]], [[0, 1], [1, 0]], [[0, -1], [-1, 0]]])


def test_each_orbit_has_one_playable_point(group: SymmetryGroup) -> None:
    for p in BOARD:
        images = np.unique(group.matrices @ p, axis=0)
        assert group.playable(images).sum() == 1


def test_playable_area_of_the_design_page() -> None:
    x, y = BOARD.T
    areas = {"y": x <= 0, "x": y >= 0, "xy": (x <= 0) & (y >= 0), "xyd": (y >= 0) & (-x >= y), "none": x == x}
    for name, area in areas.items():
        assert (GROUPS[name].playable(BOARD) == area).all()


def test_sides_of_the_domain_are_axes(group: SymmetryGroup) -> None:
    for normal, mirror in zip(group.normals, group.mirrors, strict=True):
        on_side = BOARD[(BOARD @ normal == 0)]
        assert (on_side @ group.matrices[mirror].T == on_side).all()
        assert (group.matrices[mirror] @ normal == -normal).all()


def test_boundary_enters_over_the_start_axis(group: SymmetryGroup) -> None:
    """A counter-clockwise circle is outside the domain just before the start axis, inside just after it."""
    if group.name == "none":
        return
    angle = (np.arange(3600) + 0.5) * 2 * np.pi / 3600
    circle = 1e6 * np.stack([np.cos(angle), np.sin(angle)], axis=1)
    inside = group.playable(np.round(circle).astype(np.int64))
    for mirror, shift in ((group.start_mirror, 1), (group.end_mirror, -1)):
        at = circle[inside & ~np.roll(inside, shift)][0]
        assert np.abs(group.matrices[mirror] @ at - at).max() < 1e6 * 2e-3
