"""The formats that a design is written in, by name, and one function that writes them."""

from __future__ import annotations

import math
import os
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field
from functools import cached_property
from pathlib import Path

from origami_lab.drawing.scene import TargetSurface, read_target, target_of
from origami_lab.errors import InputError
from origami_lab.export.cp import write_cp
from origami_lab.export.cut_sheet import MARGIN, lay_out, parse_sheet, write_cut
from origami_lab.export.dxf import PALETTES, write_dxf
from origami_lab.export.folded_mesh import write_mesh
from origami_lab.export.svg import write_svg
from origami_lab.fold_format.fold_file import FoldFile, FoldFrame
from origami_lab.fold_format.motion_frames import fold_path, read_even_motion, read_motion, state_at
from origami_lab.fold_format.writer import as_fold_file, write_fold
from origami_lab.game.crease_pattern import CreasePattern


@dataclass(frozen=True)
class Exported:
    """Files that were written."""

    files: tuple[Path, ...]
    driving_angle: float | None
    """Degrees: of the state whose creases or folded sheet were written; None where the file does not say."""
    notes: tuple[str, ...]
    """Facts to know, a line each."""


@dataclass(frozen=True)
class _Order:
    """One export with all choices checked."""

    source: Path | None
    fold: FoldFile
    frame: FoldFrame
    target: TargetSurface | None
    thickness: float
    cell: float | None
    sheet: tuple[float, float] | None
    margin: float
    palette: str
    notes: list[str] = field(default_factory=list)

    @property
    def scale(self) -> float:
        """Units a board cell."""
        return 1.0 if self.cell is None else self.cell

    @cached_property
    def film(self) -> FoldFile:
        """The motion in even steps."""
        return self.fold if self.source is None else read_even_motion(self.source)


@dataclass(frozen=True)
class Format:
    """One of the formats."""

    suffixes: tuple[str, ...]
    """Endings of the files that are written; longer ones, like ``.cut.svg``, only where the user gives no name."""
    says: str
    write: Callable[[_Order, Path], None]
    takes: tuple[str, ...] = ()
    """The choices that make a difference."""


def _fold(order: _Order, path: Path) -> None:
    write_fold(path, order.fold)


def _svg(order: _Order, path: Path) -> None:
    write_svg(order.fold, order.frame, path)


def _dxf(order: _Order, path: Path) -> None:
    write_dxf(order.fold, order.frame, path, scale=order.scale, palette=order.palette)


def _cp(order: _Order, path: Path) -> None:
    write_cp(order.fold, order.frame, path)


def _mesh(order: _Order, path: Path) -> None:
    write_mesh(order.fold, order.frame, path, scale=order.scale, thickness=order.thickness)


def _html(order: _Order, path: Path) -> None:
    from origami_lab.drawing.viewer import LARGEST_TARGET, write_viewer

    write_viewer(order.fold, path, order.target, order.frame)
    if order.target is not None and len(order.target.faces) > LARGEST_TARGET:
        order.notes.append(f"html: the target has more than {LARGEST_TARGET} triangles and is left out")


def _cut(order: _Order, path: Path) -> None:
    sheet = lay_out(order.fold, order.frame, order.cell, order.sheet, order.margin)
    note = f"cut: {sheet.cell:.4g} mm a cell on {sheet.width:.4g} × {sheet.height:.4g} mm"
    if note not in order.notes:
        order.notes.append(note)
    write_cut(sheet, path)


def _gif(order: _Order, path: Path) -> None:
    from origami_lab.drawing.motion_gif import draw_motion

    draw_motion(order.film, path, order.target)


def _mp4(order: _Order, path: Path) -> None:
    from origami_lab.drawing.motion_mp4 import draw_movie

    draw_movie(order.film, path, order.target)


_SOLID = ("angle", "cell", "thickness")
FORMATS: Mapping[str, Format] = {
    "fold": Format((".full.fold",), "FOLD 1.2, pattern and motion in one file", _fold),
    "svg": Format(
        (".svg",), "the pattern for Origami Simulator", lambda o, p: write_svg(o.fold, o.frame, p), ("angle",)
    ),
    "dxf": Format((".dxf",), "the pattern for CAD, lines on layers", _dxf, ("angle", "cell", "palette")),
    "cp": Format((".cp",), "the pattern for ORIPA, Oriedita", _cp, ("angle",)),
    "obj": Format((".obj",), "the folded sheet", _mesh, _SOLID),
    "stl": Format((".stl",), "the folded sheet", _mesh, _SOLID),
    "ply": Format((".ply",), "the folded sheet", _mesh, _SOLID),
    "glb": Format((".glb",), "the folded sheet", _mesh, _SOLID),
    "html": Format((".html",), "a page with both, in motion, for any browser", _html, ("angle", "target")),
    "gif": Format((".gif",), "the motion", _gif, ("target",)),
    "mp4": Format((".mp4",), "the motion, made by ffmpeg", _mp4, ("target",)),
    "cut": Format(
        (".cut.svg", ".cut.pdf"), "a sheet in millimetres to cut and score", _cut, ("angle", "cell", "sheet", "margin")
    ),
}
"""Name → format."""


def export_design(
    source: CreasePattern | FoldFile | str | os.PathLike[str],
    to: str | Sequence[str],
    output: str | os.PathLike[str] | None = None,
    *,
    angle: float | None = None,
    target: TargetSurface | str | os.PathLike[str] | None = None,
    thickness: float | None = None,
    cell: float | None = None,
    sheet: str | tuple[float, float] | None = None,
    margin: float | None = None,
    palette: str | None = None,
) -> Exported:
    """Write a design in one or several of :data:`FORMATS`.

    Parameters
    ----------
    source
        A design, a FOLD file, or its path, or the folder of a trial. Beside a trial's ``best.fold``, its
        ``motion.fold`` and the run's ``target.ply`` are used too.
    to
        Names of formats.
    output
        The file or, also for several formats, an existing folder; by default beside ``source``, or here.
    angle
        Driving angle in degrees; the nearest state that is stored is written. By default the best one.
    target
        A mesh to draw beside the sheet.
    thickness
        Of solid panels in meshes, in board cells, with ``cell`` in millimetres.
    cell
        Millimetres a board cell, in cut sheets, DXF and meshes.
    sheet, margin
        What to cut from: ``"A4"``, ``"A3"`` or width and height, and what stays free at each side, in millimetres.
    palette
        Colours of a DXF: ``"simulator"`` or ``"oripa"``.

    Raises
    ------
    InputError
        If a file cannot be read, a choice is wrong or has no meaning in any of the formats, or there is no place to
        write to.
    """
    names = [to] if isinstance(to, str) else list(dict.fromkeys(to))
    given: dict[str, object] = {"angle": angle, "target": target, "thickness": thickness, "cell": cell}
    given |= {"sheet": sheet, "margin": margin, "palette": palette}
    _check_choices(names, {name: value for name, value in given.items() if value is not None})
    path = None if isinstance(source, CreasePattern | FoldFile) else fold_path(source)
    if path is not None:
        fold = read_motion(path)
    else:
        assert not isinstance(source, str | os.PathLike)
        fold = source if isinstance(source, FoldFile) else as_fold_file(source)
    if isinstance(target, str | os.PathLike):
        target = read_target(target)
    elif target is None and path is not None and any("target" in FORMATS[name].takes for name in names):
        target = target_of(path)
    frame = state_at(fold, angle)
    order = _Order(
        source=path,
        fold=fold,
        frame=frame,
        target=target,
        thickness=thickness or 0.0,
        cell=cell,
        sheet=parse_sheet(sheet) if isinstance(sheet, str) else sheet,
        margin=MARGIN if margin is None else margin,
        palette=palette or "simulator",
    )
    files = _places(names, path, None if output is None else Path(output))
    for name, file in files:
        try:
            FORMATS[name].write(order, file)
        except OSError as error:
            raise InputError("output", file, f"cannot be written: {error.strerror or error}") from None
    degrees = None if frame.driving_angle is None else abs(math.degrees(frame.driving_angle))
    if angle is not None and degrees is not None and abs(degrees - angle) > 0.005:
        order.notes.append(f"angle: the nearest stored state to {angle:g}° is that at {degrees:.2f}°")
    return Exported(tuple(file for _, file in files), degrees, tuple(order.notes))


def _check_choices(names: Sequence[str], given: Mapping[str, object]) -> None:
    """Names are known, numbers are sane, and each choice makes a difference."""
    for name in names:
        if name not in FORMATS:
            raise InputError("to", name, f"must be one of {', '.join(FORMATS)}")
    if not names:
        raise InputError("to", "(nothing)", f"must be one of {', '.join(FORMATS)}")
    for name, value in given.items():
        takers = [key for key, known in FORMATS.items() if name in known.takes]
        if not set(takers) & set(names):
            raise InputError(name, str(value), f"means nothing to {', '.join(names)}, only to {', '.join(takers)}")
    for name, low, high in (("angle", -1e-12, 180), ("thickness", 0, 1e4), ("cell", 0, 1e4), ("margin", -1e-12, 1e4)):
        value = given.get(name)
        if value is not None and not (isinstance(value, int | float) and low < value <= high):
            least = "from 0" if low else "above 0 and at most"
            raise InputError(name, str(value), f"must be a number {least}{' to' if low else ''} {high:g}")
    palette = given.get("palette", "oripa")
    if palette not in PALETTES:
        raise InputError("palette", str(palette), f"must be {' or '.join(PALETTES)}")


def _places(names: Sequence[str], source: Path | None, output: Path | None) -> list[tuple[str, Path]]:
    """The files to write, a name of a format with each."""
    stem = "design" if source is None else source.name.removesuffix(".fold")
    folder = (Path() if source is None else source.parent) if output is None else output
    if output is None or output.is_dir():
        places = [(name, folder / (stem + suffix)) for name in names for suffix in FORMATS[name].suffixes]
    else:
        if len(names) > 1:
            raise InputError("output", output, "must be an existing folder, for several formats")
        if not output.parent.is_dir():
            raise InputError("output", output, f"must be in a folder that exists, {output.parent} does not")
        endings = [Path(suffix).suffix or suffix for suffix in FORMATS[names[0]].suffixes]
        if output.suffix.lower() not in endings:
            raise InputError("output", output, f"must end in {' or '.join(endings)}, or be an existing folder")
        places = [(names[0], output)]
    for _, file in places:
        if source is not None and file.exists() and source.exists() and file.samefile(source):
            raise InputError("output", file, "must not be the file that is read")
        if file.is_dir():
            raise InputError("output", file, "must be a file, there is a folder of that name")
    return places
