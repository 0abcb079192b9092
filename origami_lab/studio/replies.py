"""The messages to the page, as typed schemas: what it is told."""

from __future__ import annotations

from typing import Annotated, Any, Literal

from pydantic import Field, TypeAdapter

from origami_lab.studio.messages import BoardPoint, Message


class GalleryTask(Message):
    """A task of the gallery."""

    name: str
    group: Literal["target", "objective"]
    says: str


class SheetState(Message):
    """The folded sheet at one driving angle, in degrees; 3 coordinates a vertex, one fold angle an edge."""

    at: float
    coords: list[float]
    folds: list[float]


class Packed(Message):
    """A surface: vertices and faces as base64 of little-endian float32 and uint32."""

    vertices: str
    faces: str


class SheetData(Message):
    """A sheet as the viewer draws it: the flat pattern, and its states by driving angle."""

    vertices: list[list[float]]
    modes: list[int] | None
    edges: list[list[int]]
    letters: list[str]
    driven: list[bool] | None
    panels: list[list[int]]
    sides: list[list[int]]
    triangles: list[list[int]]
    owners: list[int]
    states: list[SheetState]
    unit: str
    best: float
    upright: list[list[float]]
    target: Packed | None


class Ghost(Message):
    """What would be added: triangles in space at driving angles, and creases on the board."""

    angles: list[float]
    coords: list[list[float]]
    triangles: list[list[int]]
    creases: list[list[int]]
    """x, y of both ends."""


class Leaf(Message):
    """A vertex of the boundary in the playable area; ``says`` is why it cannot be extended."""

    at: BoardPoint
    says: str | None


class LegalPlace(Message):
    """A place that may be chosen, and how many driving angles the motion reaches then."""

    at: BoardPoint
    reach: int


class SourceSegment(Message):
    """A boundary segment that may have a driven crease."""

    number: int
    ends: list[BoardPoint]


class Worth(Message):
    """The return of a design, and its best driving angle in degrees."""

    value: float
    angle: float


class TellWelcome(Message):
    """The first message: what can be begun."""

    kind: Literal["welcome"] = "welcome"
    tasks: list[GalleryTask]
    starts: list[str]
    opens: bool
    """Whether a design was named when the studio was started: it follows."""


class TellOpening(Message):
    """What is waited for before a design can be played."""

    kind: Literal["opening"] = "opening"
    says: str


class TellOpened(Message):
    """What a design is for, and in which game it is played."""

    kind: Literal["opened"] = "opened"
    task: str
    title: str
    half: BoardPoint
    symmetry: str
    matrices: list[list[int]]
    """Of each mirror image of the board, row by row."""
    angles: list[float]
    """Driving angles of the game, degrees."""
    first_angle: int
    rules: list[str]
    searchers: list[str]
    formats: list[str]
    distance: bool
    """Whether the return is minus a distance to a target, in cells."""
    cell_mm: float | None
    target: Packed | None
    polishes: bool


class TellBoard(Message):
    """Where the design stands."""

    kind: Literal["board"] = "board"
    revision: int
    """Grows with every change of the design itself."""
    what: str
    phase: Literal["start", "leaf", "first", "second", "third"]
    ended: str | None
    """Why nothing more can be played."""
    sheet: SheetData | None
    """None where it is that of the revision told last, or where there is none yet."""
    reach: int
    leaves: list[Leaf]
    places: list[LegalPlace]
    placements: list[list[BoardPoint]]
    sources: list[SourceSegment]
    selected: BoardPoint | None
    mode: int
    children: list[BoardPoint]
    """Placed so far."""
    worth: Worth | None
    scoring: bool
    """Whether the objective, one of the user's, is still at work on its return: the board is told again then."""
    undo: int
    redo: int
    vertices: int
    creases: int
    panels: int
    unsaved: bool
    note: str | None
    """What the last request has come to, where that is worth a line."""


class TellPointed(Message):
    """The answer to a point."""

    kind: Literal["pointed"] = "pointed"
    id: int
    at: BoardPoint
    legal: bool
    says: str | None
    """Why not, or what it costs."""
    places: list[BoardPoint]
    """Of a leaf: where its first child may lie."""
    ghost: Ghost | None


class TellMotion(Message):
    """How far the design folds, looked at in tenths of a degree."""

    kind: Literal["motion"] = "motion"
    revision: int
    free_to: float
    ends: Literal["collides", "closes", "whole"]
    """What ends it: panels that meet, a vertex that no longer closes, or nothing up to the largest driving angle."""
    panels: list[int]
    """Those that would pass through each other behind the end, by their numbers in the sheet."""
    further: list[SheetState]
    """States that the sheet did not have: from the last driving angle of the game that it reaches up to the end."""


class TellPartner(Message):
    """How far a partner is."""

    kind: Literal["partner"] = "partner"
    task: str
    running: bool
    says: str
    interactions: int = 0
    best: float | None = None


class Proposal(Message):
    """A design, or a next move, that a partner offers."""

    number: int
    worth: Worth | None
    says: str
    creases: list[list[int]]
    """x, y of both ends of the creases that it adds, on the board."""


class TellProposals(Message):
    """What a partner offers, the best first."""

    kind: Literal["proposals"] = "proposals"
    task: str
    proposals: list[Proposal]


class TellLook(Message):
    """A proposal's sheet."""

    kind: Literal["look"] = "look"
    number: int
    sheet: SheetData
    worth: Worth | None


class Mark(Message):
    """A place in space, and on the board where it is one of the sheet's."""

    at: list[float]
    board: list[float] | None
    distance: float


class TellMeasured(Message):
    """The figures of a design."""

    kind: Literal["measured"] = "measured"
    revision: int
    figures: dict[str, float]
    sharpest: float | None
    """Smallest angle of a panel, degrees."""
    narrowest: float | None
    """Smallest width of a panel, board cells."""
    sheet: Mark | None
    """Where the sheet is furthest from the target."""
    target: Mark | None
    """Where the target is furthest from the sheet."""


class TellCertified(Message):
    """What the verification says of a design."""

    kind: Literal["certified"] = "certified"
    revision: int
    verdict: str
    says: str
    panels: list[int]
    """Those that meet, by their numbers."""


class TellSaved(Message):
    """Where the design is on disk."""

    kind: Literal["saved"] = "saved"
    path: str
    command: str
    notes: list[str]


class TellExported(Message):
    """A file of the saved design: its name and its content in base64."""

    kind: Literal["exported"] = "exported"
    name: str
    content: str


class TellRefused(Message):
    """What was asked for cannot be done; nothing has changed."""

    kind: Literal["refused"] = "refused"
    says: str


Reply = (
    TellWelcome
    | TellOpening
    | TellOpened
    | TellBoard
    | TellPointed
    | TellMotion
    | TellPartner
    | TellProposals
    | TellLook
    | TellMeasured
    | TellCertified
    | TellSaved
    | TellExported
    | TellRefused
)
REPLIES: TypeAdapter[Any] = TypeAdapter(Annotated[Reply, Field(discriminator="kind")])
