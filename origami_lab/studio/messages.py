"""The messages of the page, as typed schemas: what it may ask for. Answers are in :mod:`origami_lab.studio.replies`.

``viewer/src/studio/messages.ts`` is made of these (:mod:`origami_lab.studio.message_types`). Nothing that the page
sends is a path or code: tasks, searchers and formats are names of closed lists, everything else is numbers.
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
