"""Public names, and the modules that they live in; each is imported when it is first used."""

from .cp import write_cp
from .cut_sheet import write_cut
from .dxf import write_dxf
from .folded_mesh import write_mesh
from .formats import FORMATS, Exported, export_design
from .svg import svg_text, write_svg

__all__ = [
    "FORMATS",
    "Exported",
    "export_design",
    "svg_text",
    "write_cp",
    "write_cut",
    "write_dxf",
    "write_mesh",
    "write_svg",
]
