"""What is said of a part: what it is, how it will lie, and what to expect, in plain words."""

from __future__ import annotations

import shlex
from collections.abc import Iterator
from typing import Any

import numpy as np

from origami_lab.lengths import smallest_sheet
from origami_lab.parts.analysis import PartAnalysis
from origami_lab.text import short_of

COVERED, FULL, TIGHT = 0.05, 0.6, 0.1
"""Parts of an area from which a warning is worth it: under something else, of the largest sheet, bent too tightly."""
UNIT_WORDS = {"mm": "millimetres", "cm": "centimetres", "m": "metres", "in": "inches"}
GROUP_WORDS = {
    "none": "none",
    "y": "left and right are mirror images",
    "x": "front and back are mirror images",
    "xy": "left and right, front and back are mirror images",
    "xyd": "mirror images left and right, front and back, and across the diagonals",
}


def summary_lines(part: PartAnalysis) -> Iterator[str]:
    """A few lines for the beginning of a run: what was chosen, and warnings."""
    setup = part.setup
    yield (
        f"{part.path.name}: 1 board cell = {1.0 / setup.scale:.4g} units of the file; lies {lies(part)};"
        f" board {setup.board[0]}×{setup.board[1]}, symmetry={setup.symmetry}, start: {start_words(part)}"
    )
    for warning in warnings(part):
        yield f"warning: {warning}"


def lies(part: PartAnalysis) -> str:
    """How the part is turned."""
    if not any(part.setup.rotate):
        return "as it is in the file"
    return "turned by " + ", ".join(f"{angle:.4g}" for angle in part.setup.rotate) + " degrees about x, y, z"


def kind_words(part: PartAnalysis) -> str:
    """What sort of part it is."""
    form = f"flat-faced, {len(part.regions)} faces" if part.is_flat_faced else "curved"
    if part.skin is not None:
        return f"{form}, the {part.skin} skin of a solid with thin walls"
    return f"{form}, {'a closed solid' if part.surface.is_closed else 'an open surface'}"


def start_words(part: PartAnalysis) -> str:
    """The start pattern."""
    start = part.setup.start
    name = str(start["_target_"]).rpartition(".")[2].lower()
    if name == "crease":
        return f"a crease from {point(start['ends'][0])} to {point(start['ends'][1])}"
    if name == "panel":
        driven = sum(sign != 0 for sign in start["signs"])
        corners = " ".join(map(point, start["corners"]))
        sizes = np.ptp(np.array(start["corners"]), axis=0) / part.setup.scale
        floor = " × ".join(f"{length:.4g}" for length in sizes)
        return f"the panel {corners}, {floor} {part.unit}, with {driven} side{'s' * (driven != 1)} that fold"
    return "a square about the middle, its size chosen in the game"


def point(place: Any) -> str:
    return f"({place[0]},{place[1]})"


def warnings(part: PartAnalysis) -> Iterator[str]:
    """What may keep a sheet from becoming this part, one sentence each."""
    surface, layout, setup = part.surface, part.layout, part.setup
    if surface.bodies > 1:
        yield f"it has {surface.bodies} pieces that do not hang together; one sheet is to become all of them"
    if part.walls is not None:
        yield (
            f"its walls are about {part.walls:.3g} {part.unit} thick: a sheet is to become their {part.skin} side, and"
            f" distances are to that (target.skin={'inner' if part.skin == 'outer' else 'outer'} is the other side)"
        )
    if part.rounded > 0.0:
        yield (
            f"its edges are rounded, and creases are sharp: along them the sheet will lie up to {part.rounded:.3g}"
            f" {part.unit} outside of the part, and everywhere else on it"
        )
    if surface.is_closed:
        yield "it is a closed solid: only its outside counts, all of it, its underside too; what is inside is free"
    if part.holes:
        yield f"it has {part.holes} hole{'s' * (part.holes > 1)}; the sheet has none, it will cover them or stop short"
    if not part.frame.on_surface:
        yield "it has no surface in its middle, where the sheet begins: the sheet's first panel will be too much"
    if part.covered > COVERED:
        yield (f"{100 * part.covered:.0f} % of it lies under another part of it; a sheet is rarely tucked in there")
    if layout is None and part.area_cells > FULL * part.board_cells:
        yield (
            f"its area is {part.area_cells:.0f} square cells of the board's {part.board_cells}: a sheet of that size"
            " may not reach all of it"
        )
    if layout is not None:
        if not layout.is_exact:
            off = layout.lattice.off / setup.scale
            yield (
                f"its corners are up to {off:.3g} {part.unit} from board points, so it cannot be met more exactly"
                " than that"
            )
        others = {
            round(abs(side.fold), 2)
            for side, is_driven in zip(layout.unfolding.sides, layout.driven, strict=True)
            if side.wall >= 0 and not is_driven
        }
        if others:
            shown = ", ".join(f"{angle:g}" for angle in sorted(others))
            yield f"one driving angle folds the walls at {layout.fold:g}°; those at {shown}° are left to the search"
    elif part.is_flat_faced:
        yield "its faces do not hang on one floor with walls, so it is treated as a curved part"
    else:
        if (share := part.curvature.share_tighter_than(1.0 / setup.scale)) > TIGHT:
            yield f"{100 * share:.0f} % of it bends more tightly than a board cell: details finer than that are lost"
        crease = setup.max_crease_length
        if crease is not None and (share := part.curvature.share_tighter_than(crease / setup.scale)) > 2 * TIGHT:
            yield (
                f"{100 * share:.0f} % of it bends more tightly than creases of {crease:g} cells can follow; shorter"
                " ones (max_crease_length=2) or a larger board may"
            )


def facts(part: PartAnalysis) -> list[tuple[str, str]]:
    """What the file holds and what was chosen for it, as names and words."""
    surface, setup = part.surface, part.setup
    unit = part.unit
    sizes = " × ".join(f"{length:.4g}" for length in part.extent)
    guess = f"taken for {UNIT_WORDS[unit]}"
    pieces = f"{surface.bodies} piece{'s' * (surface.bodies != 1)}, {len(surface.faces)} triangles"
    rims = "no open edge" if surface.is_closed else f"{surface.rims} rim{'s' * (surface.rims != 1)}"
    share = part.area_cells / part.board_cells
    longest = setup.max_crease_length
    cell = part.cell
    return [
        ("part", f"{kind_words(part)}: {pieces}, {rims}"),
        ("size", f"{sizes} as it will lie (x, y, z), {guess}"),
        ("symmetry", f"{GROUP_WORDS[part.frame.symmetry]}; played with symmetry={setup.symmetry}"),
        ("lies", lies(part)),
        ("scale", f"a board cell is {cell:.4g} mm; the part {_cells(part)} cells"),
        (
            "board",
            f"{setup.board[0]} × {setup.board[1]} points; the part's area is {100 * share:.0f} % of the largest sheet",
        ),
        ("start", start_words(part)),
        ("paper", paper_words(part)),
        ("angles", f"{setup.driving_angle_count} driving angles up to {setup.driving_angle_max:.6g}°"),
        ("creases", "of any length" if longest is None else f"up to {longest:g} cells, {longest * cell:.3g} mm"),
        ("expect", expectation(part)),
    ]


def paper_words(part: PartAnalysis) -> str:
    """How much paper the largest pattern takes at the part's true size, and the smallest sheet that has it."""
    short, long = sorted(_sides(part))
    room = f"at true size a pattern is {long:.4g} × {short:.4g} mm at most"
    if settings := paper_settings(part):
        return f"{room}: {' '.join(settings)}; {settings[1]} alone would make the part fill the sheet"
    return f"{room}, more than A0; sheet=A0 alone makes the part as large as there is room"


def paper_settings(part: PartAnalysis) -> list[str]:
    """The settings for a pattern of the part's true size on the smallest sheet that has it; none if no sheet has."""
    name = smallest_sheet(*_sides(part))
    return [] if name is None else [f"cell={part.cell:.6g}mm", f"sheet={name}"]


def _sides(part: PartAnalysis) -> tuple[float, float]:
    """The largest sheet of the board at the part's true size, in millimetres."""
    width, height = ((points - 1) * part.cell for points in part.setup.board)
    return width, height


def expectation(part: PartAnalysis) -> str:
    """What a search is to come to with a part of its kind."""
    layout = part.layout
    if layout is None:
        return "near it, not exact; a longer run (budget=2_000_000) and polish=60000 come nearer"
    sides = layout.unfolding.sides
    hinged = {side.wall for side in sides if side.wall >= 0}
    if not layout.is_exact or not all(layout.driven[k] for k, side in enumerate(sides) if side.wall >= 0):
        return "most of it met; the rest as the remarks say"
    met = "floor and walls met exactly" if part.rounded == 0.0 else "floor and walls met, but for their rounded edges"
    if len(part.regions) > 1 + len(hinged):
        met += ", what hangs on the walls only nearly"
    if any(corner.height > 0.0 for corner in layout.corners):
        met += (
            "; where walls meet, left-over paper lies flat on one of them, which verify cannot certify: no fault, and"
            f" with {short_of(part.setup.driving_angle_max)}, a little off, it can"
        )
    return met


def _cells(part: PartAnalysis) -> str:
    return " × ".join(f"{length * part.setup.scale:.4g}" for length in part.extent)


def command(part: PartAnalysis, path: str, *given: str) -> str:
    """The command to run, with settings that were given."""
    return shlex.join(["origami-lab", "target=mesh", f"target.path={path}", *given, "seed=0..4"])
