"""The messages between page and server, as typed schemas: what the page may ask for, and what it is told.

``viewer/src/studio/messages.ts`` is made of these (:mod:`origami_lab.studio.typescript`). Nothing that the page sends
is a path or code: tasks, searchers and formats are names of closed lists, everything else is numbers.
"""

from __future__ import annotations

from typing import Annotated, Any, Literal

from pydantic import BaseModel, ConfigDict, Field, TypeAdapter

LARGEST_REQUEST = 16_384
"""Bytes of a message from the page; the largest that it sends names a region of the board, point by point."""
MOST_POINTS = 400
Coordinate = Annotated[int, Field(ge=-100, le=100)]
BoardPoint = tuple[Coordinate, Coordinate]
Name = Annotated[str, Field(pattern=r"^[A-Za-z0-9_]{1,40}$")]
Sign = Literal[-1, 1]
Budget = Annotated[int, Field(ge=1, le=100_000_000)]


class Message(BaseModel):
    """A message: no other fields than these, of just these types."""

    model_config = ConfigDict(extra="forbid", strict=True, json_schema_serialization_defaults_required=True)


# --- what the page asks for ------------------------------------------------------------------------------------------


class AskOpen(Message):
    """Begin a design for a task of the gallery."""

    kind: Literal["open"]
    task: Name
    start: Name
    """``default``, or another start pattern of the gallery."""


class AskPoint(Message):
    """The board point that is pointed at: may it be chosen, why not, and what would come of it."""

    kind: Literal["point"]
    id: Annotated[int, Field(ge=0, lt=2**31)]
    at: BoardPoint


class AskSelect(Message):
    """Begin to extend a leaf."""

    kind: Literal["select"]
    at: BoardPoint
    mode: Sign


class AskPlace(Message):
    """Place the next child, or the next corner of the start pattern."""

    kind: Literal["place"]
    at: BoardPoint


class AskStart(Message):
    """Lay a start pattern."""

    kind: Literal["start"]
    option: Annotated[int, Field(ge=0, le=10_000)]
    sign: Sign


class AskSource(Message):
    """Lay a driven crease on a boundary segment, by its number among those that may have one."""

    kind: Literal["source"]
    number: Annotated[int, Field(ge=0, le=10_000)]
    sign: Sign


class AskStep(Message):
    """Back by one action, undo, redo, or end the game."""

    kind: Literal["back", "undo", "redo", "terminate"]


class AskCut(Message):
    """Take the extensions of vertices away, and what grew from them."""

    kind: Literal["cut"]
    points: Annotated[list[BoardPoint], Field(min_length=1, max_length=MOST_POINTS)]


class AskShift(Message):
    """Move a vertex to another board point."""

    kind: Literal["shift"]
    at: BoardPoint
    to: BoardPoint


class AskPartner(Message):
    """Have a partner work on the design."""

    kind: Literal["partner"]
    task: Literal["suggest", "finish", "improve", "repair", "certify", "measure", "polish", "simplify"]
    searcher: Name = "lns"
    budget: Budget = 200_000
    region: Annotated[list[BoardPoint], Field(max_length=MOST_POINTS)] = []
    """Vertices to be repaired."""


class AskProposal(Message):
    """Look at a proposal of the partner's, take it, or leave all."""

    kind: Literal["look", "take", "leave", "stop"]
    number: Annotated[int, Field(ge=0, le=1000)] = 0


class AskSave(Message):
    """Save the design as a run folder."""

    kind: Literal["save"]


class AskExport(Message):
    """Save, and write the design in another format."""

    kind: Literal["export"]
    format: Name


Request = Annotated[
    AskOpen
    | AskPoint
    | AskSelect
    | AskPlace
    | AskStart
    | AskSource
    | AskStep
    | AskCut
    | AskShift
    | AskPartner
    | AskProposal
    | AskSave
    | AskExport,
    Field(discriminator="kind"),
]
REQUESTS: TypeAdapter[Any] = TypeAdapter(Request)


# --- what the page is told -------------------------------------------------------------------------------------------


class Task(Message):
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
    tasks: list[Task]
    starts: list[str]
    opens: bool
    """Whether a design was named when the studio was started: it follows."""


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
