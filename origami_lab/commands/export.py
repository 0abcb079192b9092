"""`origami-lab export`: a design in the formats of other programs, of cutters, printers and browsers."""

from __future__ import annotations

import argparse
import sys
from collections.abc import Sequence

from origami_lab.commands import number, whole
from origami_lab.commands.parser import Parser


def main(arguments: Sequence[str]) -> int:
    """Write the files and name them on stdout, notes on stderr; returns the exit code."""
    from origami_lab.export.formats import FORMATS, export_design

    formats = "\n".join(f"  {name:<5} {known.says}" for name, known in FORMATS.items())
    parser = Parser(
        "origami-lab export",
        description="Write a design in other formats:\n" + formats,
        formatter_class=argparse.RawDescriptionHelpFormatter,
    )
    parser.add_argument("file", metavar="FILE", help="a FOLD file, or the folder of a trial, results/.../seed=N")
    parser.add_argument(
        "--to", metavar="FORMAT", action="append", required=True, help="svg, or svg,dxf,cp; may be given several times"
    )
    parser.add_argument("--output", metavar="PATH", help="a file, or an existing folder (default: beside FILE)")
    parser.add_argument("--frame", metavar="N", help="the frame of a file that has several, 0 for the key frame")
    parser.add_argument(
        "--angle",
        metavar="DEGREES",
        help="the driving angle whose creases or folded sheet to write, the nearest one stored (default: the best)",
    )
    parser.add_argument("--target", metavar="MESH", help="what to draw beside the sheet (default: the run's target)")
    parser.add_argument("--thickness", metavar="T", help="solid panels in meshes; board cells or, with --cell, mm")
    parser.add_argument("--cell", metavar="MM", help="millimetres a board cell, for cut, dxf and meshes")
    parser.add_argument("--sheet", metavar="SIZE", help="what to cut from: A4, A3 or WIDTHxHEIGHT in mm (default: A4)")
    parser.add_argument("--margin", metavar="MM", help="what stays free at each side of it (default: 10)")
    parser.add_argument("--palette", metavar="NAME", help="colours of a DXF: simulator (default), oripa")
    options = parser.parse_args(arguments)
    done = export_design(
        options.file,
        options.to,
        options.output,
        frame=whole("frame", options.frame),
        angle=number("angle", options.angle),
        target=options.target,
        thickness=number("thickness", options.thickness),
        cell=number("cell", options.cell),
        sheet=options.sheet,
        margin=number("margin", options.margin),
        palette=options.palette,
    )
    for note in done.notes:
        print(f"note: {note}", file=sys.stderr)
    for file in done.files:
        print(file)
    return 0
