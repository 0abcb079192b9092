"""Lines that editors leave in a pattern: no part of the sheet wherever they lie, and remarked on."""

from __future__ import annotations

import json
from pathlib import Path

import networkx as nx
import numpy as np
import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st

import origami_lab
from origami_lab.fold_format.loose_lines import _blocks
from origami_lab.fold_format.reader import read_fold
from tests.fold_format.corpus import Pattern, corpus
from tests.fold_format.dialects import Fold, base, plain

CORPUS = corpus()
NAMES = ("miura 3×3", "huffman (100.0, 60.0, 110.0, 90.0)", "valley")


def with_lines(p: Pattern, lines: list[list[list[float] | int]], letters: str, faces: bool = False) -> Fold:
    """The pattern and lines whose ends are points, or numbers of its vertices."""
    fold = base(p) if faces else plain(p)
    for ends, letter in zip(lines, letters, strict=True):
        numbers = []
        for end in ends:
            if isinstance(end, int):
                numbers.append(end)
            else:
                fold["vertices_coords"] = [*fold["vertices_coords"], end]
                numbers.append(len(fold["vertices_coords"]) - 1)
        fold["edges_vertices"] = [*fold["edges_vertices"], numbers]
        fold["edges_assignment"] = [*fold["edges_assignment"], letter]
        fold["edges_foldAngle"] = [*fold["edges_foldAngle"], 0]
    return fold


@pytest.mark.parametrize("name", NAMES)
@pytest.mark.parametrize("faces", [False, True], ids=["found", "listed"])
@settings(max_examples=20, deadline=None, suppress_health_check=[HealthCheck.function_scoped_fixture])
@given(seed=st.integers(0, 10**6), count=st.integers(1, 6))
def test_lines_anywhere(name: str, faces: bool, seed: int, count: int, tmp_path: Path) -> None:
    """Random lines between vertices, points on edges, points within and outside the sheet."""
    pattern, rng = CORPUS[name], np.random.default_rng(seed)
    low, high = pattern.flat.min(axis=0) - 0.5, pattern.flat.max(axis=0) + 0.5

    def end() -> list[float] | int:
        kind = rng.integers(4)
        if kind == 0:
            return int(rng.integers(len(pattern.flat)))
        if kind == 1:
            u, v = pattern.edges[rng.integers(len(pattern.edges))]
            return (pattern.flat[u] + rng.uniform(0.1, 0.9) * (pattern.flat[v] - pattern.flat[u])).tolist()
        return rng.uniform(low, high).tolist()

    lines = []
    while len(lines) < count:
        a, b = end(), end()
        if a != b:
            lines.append([a, b])
    # from vertex to vertex an unassigned line would be a crease, of whose angle nothing is known
    letters = "".join(
        "U" if k == 2 and not all(isinstance(end, int) for end in ends) else "F" for k, ends in enumerate(lines)
    )
    path = tmp_path / "a.fold"
    path.write_text(json.dumps(with_lines(pattern, lines, letters, faces)), encoding="utf-8")
    certificate = origami_lab.verify(path)
    assert certificate.verdict == "certified", (lines, certificate.words())
    creases = certificate["degrees of freedom"].numbers
    assert creases["creases"] == sum(letter in "MV" for letter in pattern.letters)
    assert len(read_fold(path).edges) == len(pattern.edges) + count


def test_closed_lines_at_one_vertex_and_apart(tmp_path: Path) -> None:
    pattern = CORPUS["valley"]  # a rectangle from (−1, −1) to (3, 2) with the crease x = 1
    apart = [[[1.5, 0.5], [2.0, 0.5]], [[2.0, 0.5], [2.0, 1.0]]]
    fold = with_lines(pattern, apart, "FF")
    n = len(fold["vertices_coords"])
    fold["edges_vertices"] += [[n - 4, n - 3], [0, n], [n, n + 1], [n + 1, 0]]
    fold["vertices_coords"] += [[-0.5, 0.0], [0.0, -0.5]]
    fold["edges_assignment"] += list("FFFF")
    fold["edges_foldAngle"] += [0] * 4
    path = tmp_path / "a.fold"
    path.write_text(json.dumps(fold), encoding="utf-8")
    certificate = origami_lab.verify(path)
    assert certificate.verdict == "certified", certificate.words()
    assert any("6 edges are auxiliary lines" in remark or "5 edges" in remark for remark in certificate.remarks)


@pytest.mark.parametrize(("angle", "verdict"), [(40, "refuted"), (0, "not certifiable"), (None, "not certifiable")])
def test_a_crease_that_ends_inside_a_panel(angle: float | None, verdict: str, tmp_path: Path) -> None:
    """It is no auxiliary line: a file that says by how much it folds contradicts itself, else nothing is known."""
    fold = with_lines(CORPUS["valley"], [[[1.5, 0.5], [2.0, 0.5]]], "V")
    fold["edges_foldAngle"][-1] = angle
    (tmp_path / "a.fold").write_text(json.dumps(fold), encoding="utf-8")
    assert origami_lab.verify(tmp_path / "a.fold").verdict == verdict


@settings(max_examples=200, deadline=None)
@given(edges=st.sets(st.tuples(st.integers(0, 9), st.integers(0, 9)).filter(lambda e: e[0] < e[1]), min_size=1))
def test_blocks_are_those_of_a_graph_library(edges: set[tuple[int, int]]) -> None:
    listed = np.array(sorted(edges), dtype=np.int64)
    mine = {frozenset(tuple(listed[e].tolist()) for e in block) for block in _blocks(listed, np.arange(len(listed)))}
    graph = nx.Graph(sorted(edges))
    known = {frozenset((min(e), max(e)) for e in block) for block in nx.biconnected_component_edges(graph)}
    assert mine == known
