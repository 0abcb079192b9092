"""Public names, and the modules that they live in; each is imported when it is first used."""

from .crease_pattern import CreasePattern
from .edits import with_vertex_moved, without_vertices
from .folded_sheet import FoldedSheet
from .game import Game
from .legality import Reason, reaches, why_no_further, why_not_leaf, why_not_place
from .moves import Extend, Lay, Move, Place, Source, Terminate, move_from_dict, move_to_dict
from .observation import CompactView, TensorView
from .start_file import SavedPattern, read_pattern
from .start_from_moves import FromFile, FromMoves
from .start_patterns import Crease, Panel, Rectangle, Square, Start

__all__ = [
    "CompactView",
    "Crease",
    "CreasePattern",
    "Extend",
    "FoldedSheet",
    "FromFile",
    "FromMoves",
    "Game",
    "Lay",
    "Move",
    "Panel",
    "Place",
    "Reason",
    "Rectangle",
    "SavedPattern",
    "Source",
    "Square",
    "Start",
    "TensorView",
    "Terminate",
    "move_from_dict",
    "move_to_dict",
    "reaches",
    "read_pattern",
    "why_no_further",
    "why_not_leaf",
    "why_not_place",
    "with_vertex_moved",
    "without_vertices",
]
