"""Every invariant of a sheet and its motion, checked over many states at once.

Nothing here uses the package's own view of a sheet (``FoldedSheet``), its panels or its fold angles: the states'
representatives are expanded by the group matrices, vertices are identified by their place on the board, and all
the rest follows from flat triangles, creases and folded positions.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy.sparse import coo_array
from scipy.sparse.csgraph import connected_components

from origami_lab.game.game import Game
from origami_lab.game.kernels.state import ALL_IMAGES, SINGLE, States

Ints = NDArray[np.int64]
Floats = NDArray[np.float64]

TOLERANCE = 1e-9


@dataclass
class Report:
    violations: list[tuple[int, str]]
    """Number of the state and what is wrong with it."""
    largest: int
    """Vertices of the largest sheet."""
    error: float
    """Largest relative deviation from rigid panels and closed vertices."""


def cross2(a: NDArray[np.int64], b: NDArray[np.int64]) -> NDArray[np.int64]:
    return a[..., 0] * b[..., 1] - a[..., 1] * b[..., 0]


def polygon_is_simple(points: Ints) -> NDArray[np.bool_]:
    """Which of the (m, n, 2) polygons are simple, exactly: all pairs of their n segments."""
    n = points.shape[1]
    p, q = points, np.roll(points, -1, axis=1)
    i, j = np.triu_indices(n, 1)
    beside = (j == i + 1) | ((i == 0) & (j == n - 1))
    bad = segments_meet(p[:, i], q[:, i], p[:, j], q[:, j]) & ~beside
    step, following = q - p, np.roll(q - p, -1, axis=1)
    back = (cross2(step, following) == 0) & ((step * following).sum(axis=-1) <= 0)
    return ~(bad.any(axis=1) | back.any(axis=1))


def segments_meet(a: Ints, b: Ints, c: Ints, d: Ints) -> NDArray[np.bool_]:
    """Whether closed segments a–b and c–d have a common point, exactly (arrays of points)."""

    def side(p: Ints, q: Ints, r: Ints) -> Ints:
        return np.sign(cross2(q - p, r - p))

    def between(p: Ints, q: Ints, r: Ints) -> NDArray[np.bool_]:
        return ((np.minimum(p, q) <= r) & (r <= np.maximum(p, q))).all(axis=-1)

    abc, abd, cda, cdb = side(a, b, c), side(a, b, d), side(c, d, a), side(c, d, b)
    meets = (abc * abd < 0) & (cda * cdb < 0)
    for zero, p, q, r in ((abc, a, b, c), (abd, a, b, d), (cda, c, d, a), (cdb, c, d, b)):
        meets |= (zero == 0) & between(p, q, r)
    return meets


def check_sheets(game: Game, states: States, middles: Ints, extensions: Ints) -> Report:
    """Check finished states; ``middles`` (E, n, 5) has leaf, middle child and mode of each extension."""
    sheets = _Sheets(game, states, middles, extensions)
    sheets.check_planar()
    sheets.check_links()
    error = max(sheets.check_panels(), sheets.check_creases(), sheets.check_leaf_frames())
    sizes = np.bincount(sheets.sheet, minlength=len(states))
    return Report(sorted(set(sheets.violations)), int(sizes.max()), error)


class _Sheets:
    """All sheets side by side: ``V`` vertices, ``T`` triangles, numbered throughout."""

    def __init__(self, game: Game, states: States, middles: Ints, extensions: Ints) -> None:
        self.violations: list[tuple[int, str]] = []
        self.game, self.states, self.count = game, states, len(states)
        self.middles, self.extensions = middles, extensions
        self.matrices = game.symmetry.matrices
        self.products = game.symmetry.products
        self.mirrors = np.linalg.det(self.matrices) < 0
        n, order = int(states["n_vertices"].max()), len(self.matrices)
        live = np.arange(n) < states["n_vertices"][:, None]
        xy = states["xy"][:, :n].astype(np.int64)
        images = np.einsum("gij,enj->engi", self.matrices, xy)
        keys = self.key(np.arange(self.count)[:, None, None], images)
        self.keys, inverse = np.unique(keys[live], return_inverse=True)
        self.ids = np.full((self.count, n, order), -1, dtype=np.int64)
        self.ids[live] = inverse.reshape(-1, order)
        self.sheet, place = self.keys // game.rules.points, self.keys % game.rules.points
        self.flat = np.stack([place % game.board[0], place // game.board[0]], axis=1) - game.rules.half
        self.live = live
        # folded positions; past its reach a sheet stays at its last angle
        angles = np.arange(len(game.angles))
        self.angle = np.minimum(angles, states["reach"][:, None] - 1)
        position = np.take_along_axis(states["position"][:, :n], self.angle[:, None, :, None], axis=2)
        folded = np.empty((self.count, n, order, len(angles), 3))
        for g, matrix in enumerate(self.matrices):
            folded[:, :, g, :, :2] = position[..., :2] @ matrix.T
            folded[:, :, g, :, 2] = position[..., 2]
        self.folded = np.empty((len(self.keys), len(angles), 3))
        self.folded[self.ids[live]] = folded[live]
        same = (folded[live] == self.folded[self.ids[live]]).all(axis=(1, 2, 3))
        self.fail(np.nonzero(live)[0][~same], "folded form not exactly symmetric")
        self._expand_triangles()
        self._expand_creases()

    def key(self, sheet: Ints, xy: Ints) -> Ints:
        half_x, half_y = self.game.rules.half
        place = (xy[..., 1] + half_y) * self.game.board[0] + xy[..., 0] + half_x
        out: Ints = sheet * self.game.rules.points + place
        return out

    def find(self, keys: Ints) -> Ints:
        """Vertex numbers of keys, −1 where there is no vertex."""
        at = np.minimum(np.searchsorted(self.keys, keys), len(self.keys) - 1)
        return np.where(self.keys[at] == keys, at, -1)

    def fail(self, sheets: Ints, what: str) -> None:
        self.violations += [(int(e), what) for e in np.unique(sheets)]

    def decode(self, sheet: Ints, codes: Ints, g: int) -> Ints:
        return self.ids[sheet, codes >> 3, self.products[g, codes & 7]]

    def _expand_triangles(self) -> None:
        states = self.states
        t = np.arange(int(states["n_triangles"].max()))
        e, t = np.nonzero(t < states["n_triangles"][:, None])
        corners, images = states["corners"][e, t], states["images"][e, t]
        parts = []
        for g, mirror in enumerate(self.mirrors):
            # over a seam a mirrored pair of triangles fills a quadrilateral once: one image of each coset
            keep = (images == ALL_IMAGES) | ((images == SINGLE) & (g == 0))
            keep |= (images > 0) & (g < self.products[g][np.maximum(images, 0)])
            part = self.decode(e[keep, None], corners[keep], g)
            parts.append(part[:, ::-1] if mirror else part)
        self.triangles = np.concatenate(parts)

    def _expand_creases(self) -> None:
        states = self.states
        i = np.arange(int(states["n_creases"].max()))
        e, i = np.nonzero(i < states["n_creases"][:, None])
        ends, driven = states["creases"][e, i], states["driven"][e, i]
        pairs = np.concatenate([self.decode(e[:, None], ends, g) for g in range(len(self.mirrors))])
        pairs.sort(axis=1)
        rows = np.column_stack([pairs, np.tile(driven, len(self.mirrors))])
        rows = np.unique(rows, axis=0)
        self.creases, self.driven = rows[:, :2], rows[:, 2]
        self.crease_keys = self.creases[:, 0] * len(self.keys) + self.creases[:, 1]
        twice = self.crease_keys[1:] == self.crease_keys[:-1]
        self.fail(self.sheet[self.creases[1:][twice, 0]], "a crease with two signs")

    def is_crease(self, u: Ints, v: Ints) -> NDArray[np.bool_]:
        return np.isin(np.minimum(u, v) * len(self.keys) + np.maximum(u, v), self.crease_keys)

    def check_planar(self) -> None:
        """Simple boundary, area, Euler characteristic, orientation; exact."""
        flat, tri = self.flat, self.triangles
        corner = flat[tri]
        twice_area = cross2(corner[:, 1] - corner[:, 0], corner[:, 2] - corner[:, 0])
        self.fail(self.sheet[tri[twice_area <= 0, 0]], "triangle not counter-clockwise")
        # sides of triangles, split at all vertices on them
        u, v = tri.ravel(), np.roll(tri, -1, axis=1).ravel()
        steps = np.gcd(*(flat[v] - flat[u]).T)
        owner = np.repeat(np.arange(len(u)), steps + 1)
        along = np.arange(len(owner)) - np.repeat(np.cumsum(steps + 1) - steps - 1, steps + 1)
        points = flat[u][owner] + (flat[v] - flat[u])[owner] // steps[owner, None] * along[:, None]
        found = self.find(self.key(self.sheet[u][owner], points))
        owner, found = owner[found >= 0], found[found >= 0]
        inner = owner[1:] == owner[:-1]
        self.seg_u, self.seg_v, self.seg_t = found[:-1][inner], found[1:][inner], owner[1:][inner] // 3
        total = len(self.keys)
        key, back = self.seg_u * total + self.seg_v, self.seg_v * total + self.seg_u
        order = np.argsort(key)
        self.fail(self.sheet[self.seg_u[order][1:][np.diff(key[order]) == 0]], "two triangles on one side")
        at = np.minimum(np.searchsorted(key[order], back), len(key) - 1)
        across = order[at] if len(order) else at
        self.across = np.where(key[across] == back, self.seg_t[across], -1) if len(order) else at
        border = self.across < 0
        self.border_u, self.border_v = self.seg_u[border], self.seg_v[border]
        edges = np.bincount(self.sheet[self.seg_u], minlength=self.count)
        borders = np.bincount(self.sheet[self.border_u], minlength=self.count)
        vertices = np.bincount(self.sheet, minlength=self.count)
        faces = np.bincount(self.sheet[tri[:, 0]], minlength=self.count)
        self.solid = faces > 0
        euler = vertices - (edges + borders) // 2 + faces
        self.fail(np.flatnonzero((euler != 1) & self.solid), "Euler characteristic is not 1")
        area = np.bincount(self.sheet[tri[:, 0]], twice_area, minlength=self.count)
        ring = cross2(flat[self.border_u], flat[self.border_v])
        ring_area = np.bincount(self.sheet[self.border_u], ring, minlength=self.count)
        self.fail(np.flatnonzero(area != ring_area), "triangles do not fill the polygon")
        self._check_simple()

    def _check_simple(self) -> None:
        total = len(self.keys)
        once_out = np.bincount(self.border_u, minlength=total) <= 1
        once_in = np.bincount(self.border_v, minlength=total) <= 1
        self.fail(self.sheet[~(once_out & once_in)], "boundary touches itself at a vertex")
        graph = coo_array((np.ones(len(self.border_u)), (self.border_u, self.border_v)), (total, total))
        _, label = connected_components(graph, directed=False)
        pieces = np.unique(np.stack([self.sheet[self.border_u], label[self.border_u]]), axis=1)[0]
        self.fail(np.flatnonzero(np.bincount(pieces, minlength=self.count) > 1), "boundary in pieces")
        order = np.argsort(self.sheet[self.border_u], kind="stable")
        u, v = self.border_u[order], self.border_v[order]
        sizes = np.bincount(self.sheet[u], minlength=self.count)
        starts = np.cumsum(sizes) - sizes
        for e in np.flatnonzero(sizes):
            a, b = u[starts[e] : starts[e] + sizes[e]], v[starts[e] : starts[e] + sizes[e]]
            i, j = np.triu_indices(len(a), 1)
            shared = (b[i] == a[j]) | (a[i] == b[j])
            meet = segments_meet(self.flat[a[i]], self.flat[b[i]], self.flat[a[j]], self.flat[b[j]])
            fold = cross2(self.flat[b] - self.flat[a], self.flat[_following(a, b)] - self.flat[b]) == 0
            dots = ((self.flat[b] - self.flat[a]) * (self.flat[_following(a, b)] - self.flat[b])).sum(axis=1)
            if (meet & ~shared).any() or (fold & (dots < 0)).any():
                self.fail(np.array([e]), "boundary is not a simple polygon")

    def check_links(self) -> None:
        """The cycle of leaves is the polygon that the triangles leave."""
        n = self.ids.shape[1]
        e, w = np.nonzero(self.live & (self.states["modes"][:, :n] == 0))
        after, before = self.states["next"][e, w], self.states["prev"][e, w]
        pairs = []
        for g, mirror in enumerate(self.mirrors):
            here = self.ids[e, w, g]
            there, behind = self.decode(e, after, g), self.decode(e, before, g)
            if mirror:
                there, behind = behind, there
            pairs += [np.stack([here, there]), np.stack([behind, here])]
        links = np.unique(np.concatenate(pairs, axis=1), axis=1)
        links = links[:, self.solid[self.sheet[links[0]]]]
        border = np.unique(np.stack([self.border_u, self.border_v]), axis=1)
        if links.shape != border.shape or (links != border).any():
            total = len(self.keys)
            odd = np.setxor1d(links[0] * total + links[1], border[0] * total + border[1]) // total
            self.fail(self.sheet[odd], "leaves do not follow the boundary")
        extended = np.zeros(len(self.keys), dtype=np.bool_)
        e, w = np.nonzero(self.live & (self.states["modes"][:, :n] != 0))
        extended[self.ids[e, w]] = True
        on_border = np.zeros(len(self.keys), dtype=np.bool_)
        on_border[self.border_u] = True
        self.interior = extended
        solid = self.solid[self.sheet]
        self.fail(self.sheet[(extended == on_border) & solid], "extended vertices are not the interior ones")

    def check_panels(self) -> float:
        """Each panel moves as one rigid body: isometric and planar; returns the largest relative deviation."""
        if not len(self.triangles):
            return 0.0
        soft = (self.across >= 0) & ~self.is_crease(self.seg_u, self.seg_v)
        count = len(self.triangles)
        graph = coo_array((np.ones(soft.sum()), (self.seg_t[soft], self.across[soft])), (count, count))
        panels, self.panel = connected_components(graph, directed=False)
        corner = self.flat[self.triangles]
        area = cross2(corner[:, 1] - corner[:, 0], corner[:, 2] - corner[:, 0])
        order = np.lexsort((area, self.panel))
        reference = order[np.append(np.flatnonzero(np.diff(self.panel[order])), count - 1)]
        a, b, c = (self.triangles[reference, i] for i in range(3))
        flat = np.stack([self.flat[b] - self.flat[a], self.flat[c] - self.flat[a]], axis=2).astype(float)
        folded = np.stack([self.folded[b] - self.folded[a], self.folded[c] - self.folded[a]], axis=3)
        self.frames = folded @ np.linalg.inv(flat)[:, None]  # (panels, K, 3, 2)
        gram = np.einsum("pkix,pkiy->pkxy", self.frames, self.frames) - np.eye(2)
        size = np.ones(panels)
        base = self.triangles[reference, 0][self.panel][:, None]
        offset = (self.flat[self.triangles] - self.flat[base]).astype(float)
        np.maximum.at(size, self.panel, np.linalg.norm(offset, axis=2).max(axis=1))
        expected = np.einsum("tkix,tcx->tcki", self.frames[self.panel], offset)
        deviation = np.abs(self.folded[self.triangles] - self.folded[base] - expected).max(axis=(1, 2, 3))
        deviation /= size[self.panel]
        skew = np.abs(gram).max(axis=(1, 2, 3))
        self.fail(self.sheet[self.triangles[~(deviation < TOLERANCE), 0]], "panel not rigid or not planar")
        self.fail(self.sheet[a[~(skew < TOLERANCE)]], "panel not isometric")
        self.normals = np.cross(self.frames[..., 0], self.frames[..., 1])
        self.normals /= np.linalg.norm(self.normals, axis=2, keepdims=True)
        return float(max(deviation.max(), skew.max()))

    def check_creases(self) -> float:
        """Signs of fold angles, sectors, and the loop closure of each interior vertex."""
        if not len(self.triangles):
            return 0.0
        # every crease is one segment of the sheet
        inner = (self.across >= 0) & self.is_crease(self.seg_u, self.seg_v)
        total = len(self.keys)
        low, high = np.minimum(self.seg_u, self.seg_v), np.maximum(self.seg_u, self.seg_v)
        lost = ~np.isin(self.crease_keys, low * total + high) & self.solid[self.sheet[self.creases[:, 0]]]
        self.fail(self.sheet[self.creases[lost, 0]], "crease is not a segment of the sheet")
        outer = np.isin(self.crease_keys, (low * total + high)[self.across < 0])
        self.fail(self.sheet[self.creases[outer & (self.driven == 0), 0]], "undriven crease on the boundary")
        u, v = self.seg_u[inner], self.seg_v[inner]
        left, right = self.panel[self.seg_t[inner]], self.panel[self.across[inner]]
        self.fail(self.sheet[u[left == right]], "crease within a panel")
        axis = self.folded[v] - self.folded[u]
        axis /= np.linalg.norm(axis, axis=2, keepdims=True)
        n_left, n_right = self.normals[left], self.normals[right]
        sine = np.einsum("ski,ski->sk", np.cross(n_right, n_left), axis)
        rho = np.arctan2(sine, np.einsum("ski,ski->sk", n_right, n_left))
        # driven creases turn by the driving angle
        key = np.minimum(u, v) * total + np.maximum(u, v)
        at = np.searchsorted(self.crease_keys, key)
        sign = self.driven[at]
        driving = self.game.angles[self.angle[self.sheet[u]]]
        wrong = (np.abs(rho - sign[:, None] * driving) > TOLERANCE).any(axis=1) & (sign != 0)
        self.fail(self.sheet[u[wrong]], "driven crease not at the driving angle")
        self._check_middle_signs(key, rho)
        return self._check_closure(u, v, rho)

    def _check_middle_signs(self, key: Ints, rho: Floats) -> None:
        mode_of: dict[int, int] = {}
        e, i = np.nonzero(np.arange(self.middles.shape[1]) < self.extensions[:, None])
        middle, total = self.middles[e, i], len(self.keys)
        for matrix in self.matrices:
            leaf = self.find(self.key(e, middle[:, :2] @ matrix.T))
            child = self.find(self.key(e, middle[:, 2:4] @ matrix.T))
            keys = np.minimum(leaf, child) * total + np.maximum(leaf, child)
            mode_of.update(zip(keys.tolist(), middle[:, 4].tolist(), strict=True))
        mode = np.array([mode_of.get(k, 0) for k in key.tolist()])
        # flat or folded shut, the sign is rounding
        wrong = (mode[:, None] * rho < -1e-6) & (np.abs(rho) < np.pi - 1e-5)
        self.fail(self.sheet[key[wrong.any(axis=1)] // total], "sign of middle crease")
        lost = set(mode_of) - set(key.tolist())
        self.fail(np.array([self.sheet[k // total] for k in lost], dtype=np.int64), "middle crease missing")

    def _check_closure(self, u: Ints, v: Ints, rho: Floats) -> float:
        """∏ Rx(ρᵢ) Rz(αᵢ) = I around each interior vertex, creases outward, counter-clockwise."""
        direction = (self.flat[v] - self.flat[u]).astype(float)
        order = np.lexsort((np.arctan2(direction[:, 1], direction[:, 0]), u))
        u, rho, step = u[order], rho[order], (self.flat[v] - self.flat[u])[order]
        inner = self.interior[u]
        u, rho, step = u[inner], rho[inner], step[inner]
        vertex, first, degree = np.unique(u, return_index=True, return_counts=True)
        missing = self.interior & self.solid[self.sheet]
        missing[vertex] = False
        self.fail(self.sheet[missing], "interior vertex without creases")
        self.fail(self.sheet[vertex[degree < 4]], "interior vertex of degree less than 4")
        last = np.zeros(len(u), dtype=np.bool_)
        last[first + degree - 1] = True
        following = np.where(last, np.repeat(first, degree), np.arange(len(u)) + 1)
        turn, dots = cross2(step, step[following]), (step * step[following]).sum(axis=1)
        straight = (turn == 0) & (dots < 0) & bool(self.game.rules.record["straight_sectors"][0])
        self.fail(self.sheet[u[(turn <= 0) & ~straight]], "sector angle not in (0, π)")
        self._check_straight(u, rho, following, straight)
        alpha = np.arctan2(turn, dots)
        product = np.broadcast_to(np.eye(3), (len(vertex), rho.shape[1], 3, 3)).copy()
        for i in range(int(degree.max(initial=0))):
            has = degree > i
            at = first[has] + i
            product[has] = product[has] @ rotation_x(rho[at]) @ rotation_z(alpha[at])[:, None]
        error = np.abs(product - np.eye(3)).max(axis=(1, 2, 3), initial=0.0)
        self.fail(self.sheet[vertex[~(error < TOLERANCE)]], "closure at a vertex")
        return float(error.max(initial=0.0))

    def _check_straight(self, u: Ints, rho: Floats, following: Ints, straight: NDArray[np.bool_]) -> None:
        """Beside a sector of π two creases fold alike; all others of that vertex are flat."""
        turned = rho[straight] - rho[following[straight]]
        # folded shut, the sign is rounding
        apart = np.abs(np.remainder(turned + np.pi, 2 * np.pi) - np.pi)
        uneven = apart.max(axis=1, initial=0.0) > 10 * TOLERANCE
        self.fail(self.sheet[u[straight][uneven]], "a straight line does not fold alike on both sides of a vertex")
        beside = straight.copy()
        beside[following[straight]] = True
        flat = np.isin(u, u[straight]) & ~beside
        folds = (np.abs(rho) > 10 * TOLERANCE).any(axis=1)
        self.fail(self.sheet[u[flat & folds]], "a crease beside a straight line folds")

    def check_leaf_frames(self) -> float:
        """The stored orientations beside each leaf carry its boundary segments and are rotations."""
        n, worst = self.ids.shape[1], 0.0
        e, w = np.nonzero(self.live & (self.states["modes"][:, :n] == 0))
        here = self.ids[e, w, 0]
        for link, field in (("next", "frame_next"), ("prev", "frame_prev")):
            other = self.decode(e, self.states[link][e, w], 0)
            frames = np.take_along_axis(self.states[field][e, w], self.angle[e][:, :, None], axis=1)
            frames = frames.reshape(len(e), -1, 2, 3)  # rows: images of the x and y directions
            gram = np.einsum("lkxi,lkyi->lkxy", frames, frames) - np.eye(2)
            span = (self.flat[other] - self.flat[here]).astype(float)
            error = np.einsum("lkxi,lx->lki", frames, span) - (self.folded[other] - self.folded[here])
            error = np.abs(error).max(axis=(1, 2)) / np.linalg.norm(span, axis=1)
            bad = ~(np.maximum(error, np.abs(gram).max(axis=(1, 2, 3))) < TOLERANCE)
            self.fail(e[bad], f"{field} of a leaf")
            worst = max(worst, float(error.max(initial=0.0)))
        return worst


def _following(a: Ints, b: Ints) -> Ints:
    """For each segment a–b the end of the segment that starts at b."""
    end = dict(zip(a.tolist(), b.tolist(), strict=True))
    return np.array([end.get(w, w) for w in b.tolist()])


def rotation_x(angle: Floats) -> Floats:
    out = np.zeros((*angle.shape, 3, 3))
    out[..., 0, 0] = 1.0
    out[..., 1, 1] = out[..., 2, 2] = np.cos(angle)
    out[..., 2, 1] = np.sin(angle)
    out[..., 1, 2] = -np.sin(angle)
    return out


def rotation_z(angle: Floats) -> Floats:
    out = np.zeros((*angle.shape, 3, 3))
    out[..., 2, 2] = 1.0
    out[..., 0, 0] = out[..., 1, 1] = np.cos(angle)
    out[..., 1, 0] = np.sin(angle)
    out[..., 0, 1] = -np.sin(angle)
    return out
