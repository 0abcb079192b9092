"""The target's surface as a file of the run folder."""

from __future__ import annotations

from typing import Any, Protocol

import numpy as np


class HasTriangles(Protocol):
    """What has a surface of triangles, (V, 3) and (F, 3), such as a target."""

    @property
    def vertices(self) -> np.ndarray[Any, Any]:
        """Places of the vertices."""

    @property
    def faces(self) -> np.ndarray[Any, Any]:
        """Numbers of each triangle's vertices."""


def ply_bytes(vertices: np.ndarray[Any, Any], faces: np.ndarray[Any, Any]) -> bytes:
    """A triangle mesh, (V, 3) and (F, 3), as binary PLY; by hand: importing trimesh takes a second."""
    header = (
        "ply\nformat binary_little_endian 1.0\n"
        f"element vertex {len(vertices)}\nproperty double x\nproperty double y\nproperty double z\n"
        f"element face {len(faces)}\nproperty list uchar int vertex_indices\nend_header\n"
    )
    records = np.empty(len(faces), dtype=[("count", "u1"), ("corners", "<i4", (3,))])
    records["count"] = 3
    records["corners"] = faces
    body = np.ascontiguousarray(vertices, dtype="<f8").tobytes() + records.tobytes()
    return header.encode("ascii") + body
