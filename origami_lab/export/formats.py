"""The formats that a design is written in, by name, and one function that writes them."""

from __future__ import annotations

import math
import os
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field, replace
from functools import cached_property
from pathlib import Path

from origami_lab.drawing.scene import TargetSurface, read_target, target_of
from origami_lab.errors import InputError
from origami_lab.export.cp import write_cp
from origami_lab.export.cut_sheet import lay_out, parse_sheet, write_cut
from origami_lab.export.dxf import PALETTES, write_dxf
from origami_lab.export.folded_mesh import write_mesh
from origami_lab.export.svg import write_svg
from origami_lab.fold_format.fold_file import FoldFile, FoldFrame
from origami_lab.fold_format.motion_frames import fold_path, read_even_motion, read_motion, state_at
from origami_lab.fold_format.reader import read_fold
from origami_lab.fold_format.writer import as_fold_file, write_fold
from origami_lab.game.crease_pattern import CreasePattern
from origami_lab.lengths import MARGIN


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
    """The file whose motion in even steps is filmed; None where the states at hand are."""
    fold: FoldFile
    shown: FoldFile
    """The same with folded forms, where those were found by folding it."""
    frame: FoldFrame
    """The folded sheet."""
    creases: FoldFrame
    """Whose letters and angles the flat formats bear."""
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
        return self.shown if self.source is None else read_even_motion(self.source)


@dataclass(frozen=True)
class Format:
    """One of the formats."""

    suffixes: tuple[str, ...]
    """Endings of the files that are written; longer ones, like ``.cut.svg``, only where the user gives no name."""
    says: str
    write: Callable[[_Order, Path], None]
    takes: tuple[str, ...] = ()
    """The choices that make a difference."""
    folded: bool = False
    """Whether it shows the folded sheet."""
    moving: bool = False
    """Whether it shows the motion."""


def _fold(order: _Order, path: Path) -> None:
    write_fold(path, order.fold)


def _svg(order: _Order, path: Path) -> None:
    write_svg(order.fold, order.creases, path, cell=order.cell)


def _dxf(order: _Order, path: Path) -> None:
    write_dxf(order.fold, order.creases, path, scale=order.scale, palette=order.palette)


def _cp(order: _Order, path: Path) -> None:
    write_cp(order.fold, order.creases, path)


def _mesh(order: _Order, path: Path) -> None:
    write_mesh(order.shown, order.frame, path, scale=order.scale, thickness=order.thickness)


def _html(order: _Order, path: Path) -> None:
    from origami_lab.drawing.viewer import LARGEST_TARGET, write_viewer

    write_viewer(order.shown, path, order.target, order.frame)
    if order.target is not None and len(order.target.faces) > LARGEST_TARGET:
        order.notes.append(f"html: the target has more than {LARGEST_TARGET} triangles and is left out")


def _cut(order: _Order, path: Path) -> None:
    sheet = lay_out(order.fold, order.creases, order.cell, order.sheet, order.margin)
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
    "svg": Format((".svg",), "the pattern for Origami Simulator", _svg, ("angle", "cell")),
    "dxf": Format((".dxf",), "the pattern for CAD, lines on layers", _dxf, ("angle", "cell", "palette")),
    "cp": Format((".cp",), "the pattern for ORIPA, Oriedita", _cp, ("angle",)),
    "obj": Format((".obj",), "the folded sheet", _mesh, _SOLID, folded=True),
    "stl": Format((".stl",), "the folded sheet", _mesh, _SOLID, folded=True),
    "ply": Format((".ply",), "the folded sheet", _mesh, _SOLID, folded=True),
    "glb": Format((".glb",), "the folded sheet", _mesh, _SOLID, folded=True),
    "html": Format(
        (".html",), "a page with both, in motion, for any browser", _html, ("angle", "target"), folded=True, moving=True
    ),
    "gif": Format((".gif",), "the motion", _gif, ("target",), folded=True, moving=True),
    "mp4": Format((".mp4",), "the motion, made by ffmpeg", _mp4, ("target",), folded=True, moving=True),
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
    frame: int | None = None,
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
        Names of formats, each by itself or several with commas between them.
    output
        The file or, also for several formats, an existing folder; by default beside ``source``, or here.
    frame
        Which frame of the file to write, 0 for the key frame: a crease pattern, or a state. By default the first crease
        pattern, folded as in the last state.
    angle
        Driving angle in degrees; the nearest state that is stored is written, or folded where none is. By default the
        best one in folded formats, the pattern's own assignments and fold angles in flat ones.
    target
        A mesh to draw beside the sheet.
    thickness
        Of solid panels in meshes, in board cells, with ``cell`` in millimetres.
    cell
        Millimetres a board cell, in cut sheets, SVG, DXF and meshes; by default what the file says, from a run with
        ``cell`` or ``sheet``.
    sheet, margin
        What to cut from: ``"A4"``, ``"A3"`` … or width and height, and what stays free at each side, in millimetres.
        By default that of the run, too.
    palette
        Colours of a DXF: ``"simulator"`` or ``"oripa"``.

    Raises
    ------
    InputError
        If a file cannot be read, a choice is wrong or has no meaning in any of the formats, or there is no place to
        write to.
    """
    listed = [to] if isinstance(to, str) else to
    names = list(dict.fromkeys(name.strip() for text in listed for name in text.split(",")))
    given: dict[str, object] = {"angle": angle, "target": target, "thickness": thickness, "cell": cell}
    given |= {"sheet": sheet, "margin": margin, "palette": palette}
    _check_choices(names, {name: value for name, value in given.items() if value is not None})
    path = None if isinstance(source, CreasePattern | FoldFile) else fold_path(source)
    if path is not None:
        fold = read_motion(path) if frame is None else read_fold(path, frame)
    else:
        assert not isinstance(source, str | os.PathLike)
        fold = source if isinstance(source, FoldFile) else as_fold_file(source)
        if frame is not None:
            raise InputError("frame", frame, "must be left out: only files have frames")
    if cell is None and (cell := fold.cell) is not None:
        sheet = fold.sheet if sheet is None else sheet
    if isinstance(target, str | os.PathLike):
        target = read_target(target)
    elif target is None and path is not None and any("target" in FORMATS[name].takes for name in names):
        target = target_of(path)
    shown, notes = _folded(fold, names, angle)
    state = state_at(shown, angle)
    order = _Order(
        source=path if fold.frames and frame is None else None,
        fold=fold,
        shown=shown,
        frame=state,
        creases=fold.pattern if angle is None else state,
        target=target,
        thickness=thickness or 0.0,
        cell=cell,
        sheet=parse_sheet(sheet) if isinstance(sheet, str) else sheet,
        margin=MARGIN if margin is None else margin,
        palette=palette or "simulator",
        notes=[*fold.remarks, *notes],
    )
    files = _places(names, path, None if output is None else Path(output))
    for name, file in files:
        try:
            FORMATS[name].write(order, file)
        except OSError as error:
            raise InputError("output", file, f"cannot be written: {error.strerror or error}") from None
    degrees = None if state.driving_angle is None else abs(math.degrees(state.driving_angle))
    if angle is not None and degrees is not None and abs(degrees - angle) > 0.005:
        order.notes.append(f"angle: the nearest stored state to {angle:g}° is that at {degrees:.2f}°")
    return Exported(tuple(file for _, file in files), degrees, tuple(order.notes))


def _folded(fold: FoldFile, names: Sequence[str], angle: float | None) -> tuple[FoldFile, list[str]]:
    """The file with folded forms: its own, or such as its fold angles lead to; notes on those."""
    folded = [name for name in names if FORMATS[name].folded]
    if fold.frames or angle == 0.0 or not (folded or angle):
        return fold, []
    from origami_lab.verification.pattern_folding import FoldingError, fold_pattern

    try:
        frames, note = fold_pattern(fold, angle or None, any(FORMATS[name].moving for name in names))
    except FoldingError as error:
        field, value = ("to", ", ".join(folded)) if folded else ("angle", f"{angle:g}")
        raise InputError(field, value, f"cannot fold the crease pattern: {error}") from None
    return replace(fold, frames=frames), [note] if note else []


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
