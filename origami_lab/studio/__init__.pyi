"""Public names, and the modules that they live in; each is imported when it is first used."""

from .by_hand import DesignedByHand
from .design_board import DesignBoard, Refused
from .opening import Opened, open_design
from .server import StudioServer, serve_studio

__all__ = [
    "DesignBoard",
    "DesignedByHand",
    "Opened",
    "Refused",
    "StudioServer",
    "open_design",
    "serve_studio",
]
