"""The same pattern in any order, in any plane, listed either way round: the same verdict, the same sheet."""

from __future__ import annotations

import json
from pathlib import Path

import numpy as np
import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st

import origami_lab
from origami_lab.fold_format.reader import read_fold
from tests.fold_format.corpus import Pattern, corpus
from tests.fold_format.dialects import Fold, base, heir, state

CORPUS = corpus()
NAMES = ("huffman (80.0, 95.0, 70.0, 115.0)", "degree four, other mode", "valley")
quick = settings(max_examples=15, deadline=None, suppress_health_check=[HealthCheck.function_scoped_fixture])


def turn_of(rng: np.random.Generator) -> np.ndarray:
    """A rotation of space."""
    matrix, _ = np.linalg.qr(rng.normal(size=(3, 3)))
    return np.asarray(matrix * np.sign(np.linalg.det(matrix)))


def shuffled(p: Pattern, rng: np.random.Generator) -> Fold:
    """All numbers given anew, edges and faces beginning anywhere, edges either way."""
    vertices, edges, faces = (rng.permutation(n) for n in (len(p.flat), len(p.edges), len(p.faces)))
    new = np.argsort(vertices)

    def frame(fold: Fold) -> Fold:
        out = dict(fold)
        if "vertices_coords" in out:
            out["vertices_coords"] = [out["vertices_coords"][v] for v in vertices]
        for key in ("edges_assignment", "edges_foldAngle"):
            if key in out:
                out[key] = [out[key][e] for e in edges]
        return out

    fold = frame(base(p))
    ends = [p.edges[e] if rng.integers(2) else p.edges[e][::-1] for e in edges]
    fold["edges_vertices"] = [[int(new[u]), int(new[v])] for u, v in ends]
    rings = [np.roll(new[list(p.faces[f])], rng.integers(len(p.faces[f]))).tolist() for f in faces]
    fold["faces_vertices"] = rings
    fold["file_frames"] = [heir() | frame(state(p, k)) for k in rng.permutation(3)]
    return {"frame_classes": ["creasePattern"]} | fold


def check(fold: Fold, path: Path, pattern: Pattern, off: float = 1e-9) -> None:
    path.write_text(json.dumps(fold), encoding="utf-8")
    certificate = origami_lab.verify(path)
    assert certificate.verdict == "certified", certificate.words()
    read = read_fold(path)
    assert sorted(read.assignments) == sorted(pattern.letters)
    for frame in read.frames:  # folded sheets lie over the flat one: each panel is congruent, none is mirrored
        for panel in read.panels:
            ring = list(panel)
            flat, folded = read.vertices[ring], frame.coords[ring]
            assert np.allclose(
                np.linalg.norm(flat - np.roll(flat, 1, axis=0), axis=1),
                np.linalg.norm(folded - np.roll(folded, 1, axis=0), axis=1),
                atol=off,
            )
    widths = sorted(np.linalg.norm(np.diff(read.vertices[read.edges], axis=1)[:, 0], axis=1))
    assert widths == pytest.approx(
        sorted(np.linalg.norm(pattern.flat[u] - pattern.flat[v]) for u, v in pattern.edges), abs=off
    )


@pytest.mark.parametrize("name", NAMES)
@quick
@given(seed=st.integers(0, 10**6))
def test_any_order(name: str, seed: int, tmp_path: Path) -> None:
    check(shuffled(CORPUS[name], np.random.default_rng(seed)), tmp_path / "a.fold", CORPUS[name])


@pytest.mark.parametrize("name", NAMES)
@quick
@given(seed=st.integers(0, 10**6), decimals=st.sampled_from([7, 9, 12, 17]), faces=st.sampled_from(["listed", "none"]))
def test_any_plane(name: str, seed: int, decimals: int, faces: str, tmp_path: Path) -> None:
    """Turned anywhere and rounded; without faces the states tell which side is up."""
    rng = np.random.default_rng(seed)
    pattern = CORPUS[name]
    fold = shuffled(pattern, rng)
    flat = np.array(fold["vertices_coords"])
    coords = np.column_stack([flat, np.zeros(len(flat))]) @ turn_of(rng).T + rng.normal(size=3)
    fold["vertices_coords"] = np.round(coords, decimals).tolist()
    for frame in fold["file_frames"]:
        frame["vertices_coords"] = (np.array(frame["vertices_coords"]) @ turn_of(rng).T + rng.normal(size=3)).tolist()
    if faces == "none":
        del fold["faces_vertices"]
    check(fold, tmp_path / "a.fold", pattern, max(1e-9, 4.0 * 10.0**-decimals))


@pytest.mark.parametrize("name", NAMES)
@pytest.mark.parametrize("axis", range(6))
def test_coordinate_planes(name: str, axis: int, tmp_path: Path) -> None:
    """Each coordinate plane from both sides, at any height, with one coordinate off by the last bits."""
    pattern = CORPUS[name]
    x, y = pattern.flat.T
    zero = np.full(len(x), 2.0)
    zero[0] += 1e-15
    columns = [(x, y, zero), (zero, x, y), (y, zero, x), (y, x, zero), (zero, y, x), (x, zero, y)][axis]
    fold = {"frame_classes": ["creasePattern"]} | base(pattern)
    fold["vertices_coords"] = np.column_stack(columns).tolist()
    if axis == 3:  # in the plane z = 2 up is z, and this is the pattern's mirror image: so are its faces
        fold["edges_assignment"] = [{"M": "V", "V": "M"}.get(letter, letter) for letter in pattern.letters]
        fold["edges_foldAngle"] = [-angle for angle in pattern.degrees[-1]]
    fold["file_frames"] = [heir() | state(pattern, k) for k in range(3)]
    if axis == 3:
        for frame in fold["file_frames"]:
            frame["edges_foldAngle"] = [-angle for angle in frame["edges_foldAngle"]]
    check(fold, tmp_path / "a.fold", pattern) if axis != 3 else _certified(fold, tmp_path / "a.fold")


def _certified(fold: Fold, path: Path) -> None:
    path.write_text(json.dumps(fold), encoding="utf-8")
    certificate = origami_lab.verify(path)
    assert certificate.verdict == "certified", certificate.words()


@pytest.mark.parametrize("name", NAMES)
@quick
@given(seed=st.integers(0, 10**6))
def test_faces_listed_either_way(name: str, seed: int, tmp_path: Path) -> None:
    """Letters keep their meaning, whichever way single faces run around."""
    rng = np.random.default_rng(seed)
    fold = shuffled(CORPUS[name], rng)
    fold["faces_vertices"] = [face[::-1] if rng.integers(2) else face for face in fold["faces_vertices"]]
    check(fold, tmp_path / "a.fold", CORPUS[name])
