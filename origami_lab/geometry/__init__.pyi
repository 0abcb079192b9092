"""Public names, and the modules that they live in; each is imported when it is first used."""

from .bvh import Bvh, build_bvh
from .groups import SymmetryGroup
from .hausdorff import directed_distance
from .sampled import Sampled, sample_surface
from .sampling import covering_points, sample_triangles

__all__ = [
    "Bvh",
    "Sampled",
    "SymmetryGroup",
    "build_bvh",
    "covering_points",
    "directed_distance",
    "sample_surface",
    "sample_triangles",
]
