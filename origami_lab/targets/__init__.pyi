"""Public names, and the modules that they live in; each is imported when it is first used."""

from .face_surface import face
from .mesh_target import load_mesh, mesh
from .solids import bowl, cube, pyramid
from .target import Target

__all__ = [
    "Target",
    "bowl",
    "cube",
    "face",
    "load_mesh",
    "mesh",
    "pyramid",
]
