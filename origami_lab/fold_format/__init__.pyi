"""Public names, and the modules that they live in; each is imported when it is first used."""

from .fold_file import FoldFile, FoldFrame
from .motion_frames import fold_path, read_even_motion, read_motion, state_at
from .panel_triangles import triangulate
from .reader import read_fold
from .writer import as_fold_file, fold_title, to_fold, write_fold

__all__ = [
    "FoldFile",
    "FoldFrame",
    "as_fold_file",
    "fold_path",
    "fold_title",
    "read_even_motion",
    "read_fold",
    "read_motion",
    "state_at",
    "to_fold",
    "triangulate",
    "write_fold",
]
