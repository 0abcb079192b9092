"""Connected pieces of a graph whose vertices are numbered."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray
from scipy.sparse import coo_array
from scipy.sparse.csgraph import connected_components

Indices = NDArray[np.int64]


def connected_pieces(count: int, pairs: Indices) -> Indices:
    """(count,) the piece of each vertex, numbered from 0, by the pairs (P, 2) of vertices that are joined."""
    graph = coo_array((np.ones(len(pairs), dtype=bool), (pairs[:, 0], pairs[:, 1])), shape=(count, count))
    return np.asarray(connected_components(graph, directed=False)[1], dtype=np.int64)
