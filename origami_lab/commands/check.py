"""`origami-lab check`: what a part is, how it will lie on the board, and what to expect, before anything is run."""

from __future__ import annotations

import shutil
import sys
import textwrap
from collections.abc import Sequence
from pathlib import Path

from origami_lab.commands.parser import Parser
from origami_lab.errors import InputError
from origami_lab.files import expanded, write_whole
from origami_lab.lengths import MILLIMETRES
from origami_lab.text import one_line

WIDEST, NAMES = 110, 10


def main(arguments: Sequence[str]) -> int:
    """Print what was found, write the picture and the page; returns the exit code."""
    parser = Parser(
        "origami-lab check",
        description="Look at a part before it is folded: its size and symmetry, how it will lie on the board, at what"
        " scale, with which start pattern, what may go wrong, and the command to run.",
    )
    parser.add_argument("file", metavar="FILE", help="a mesh: stl, obj, ply, off, glb or gltf")
    parser.add_argument(
        "--output", metavar="DIR", help="where NAME-check.html and NAME-check.png go (default: beside FILE)"
    )
    parser.add_argument(
        "--unit", choices=("auto", *MILLIMETRES), default="auto", help="of the file's numbers (default: by its size)"
    )
    parser.add_argument("--text", action="store_true", help="print only, write no picture and no page")
    options = parser.parse_args(arguments)
    from origami_lab.parts.analysis import analyse_part
    from origami_lab.parts.words import command, facts, paper_settings, warnings

    path = expanded(options.file)
    folder = path.parent if options.output is None else expanded(options.output)
    if options.output is not None and not folder.is_dir():
        raise InputError("--output", options.output, "must be a folder")
    part = analyse_part(path, unit=options.unit)
    given = [] if options.unit == "auto" else [f"target.unit={options.unit}"]
    found, remarks, line = facts(part), list(warnings(part)), command(part, options.file, *given)
    width = min(WIDEST, shutil.get_terminal_size().columns)
    print(one_line(path.name))
    for name, words in found:
        print(_paragraph(f"  {name:<{NAMES}}", one_line(words), width))
    for remark in remarks:
        print(_paragraph("  ! ", one_line(remark), width))
    print(f"run it:\n  {one_line(line)}")
    if paper := paper_settings(part):
        print(f"with a pattern to cut, at true size:\n  {one_line(command(part, options.file, *given, *paper))}")
    if options.text:
        return 0
    from origami_lab.drawing.part_drawing import part_page, part_picture, png_bytes

    picture = png_bytes(part_picture(part))
    page = part_page(part, picture, found, remarks, line)
    for ending, content in (("png", picture), ("html", page.encode())):
        _write(folder / f"{path.stem}-check.{ending}", content)
    return 0


def _paragraph(begin: str, words: str, width: int) -> str:
    return textwrap.fill(words, width, initial_indent=begin, subsequent_indent=" " * len(begin))


def _write(file: Path, content: bytes) -> None:
    """Write a file and name it; raises InputError where it cannot be written."""
    try:
        write_whole(file, content)
    except OSError as error:
        raise InputError("--output", file.parent, f"cannot be written to ({error.strerror or error})") from None
    print(file)
    sys.stdout.flush()
