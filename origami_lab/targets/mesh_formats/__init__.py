"""Readers of mesh files whose faces may be any polygons, or that are often not quite as their format says.

Each takes the bytes of a file and returns :class:`~origami_lab.targets.mesh_formats.polygons.Polygons`. What follows
the promised content is ignored; content that is missing raises ValueError with the reason in a few words.
"""

from origami_lab.targets.mesh_formats.obj import read_obj
from origami_lab.targets.mesh_formats.off import read_off
from origami_lab.targets.mesh_formats.ply import read_ply
from origami_lab.targets.mesh_formats.stl import read_stl

READERS = {"obj": read_obj, "off": read_off, "ply": read_ply, "stl": read_stl}
"""By the suffix of the file."""
