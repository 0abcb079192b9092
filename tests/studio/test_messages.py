"""The schema of the messages: the page is checked against it, and what does not fit is refused."""

from __future__ import annotations

import asyncio
import json
from pathlib import Path

import pytest
from hypothesis import given
from hypothesis import strategies as st

from origami_lab.studio.loading import Loading
from origami_lab.studio.message_types import typescript
from origami_lab.studio.messages import LARGEST_REQUEST, MOST_POINTS, REQUESTS, Message
from origami_lab.studio.opening import open_design
from origami_lab.studio.replies import REPLIES, TellBoard, TellPointed, TellRefused
from origami_lab.studio.session import Session

ROOT = Path(__file__).parents[2]

GOOD = [
    {"kind": "open", "task": "bowl", "start": "default"},
    {"kind": "point", "id": 3, "at": [-1, 4]},
    {"kind": "select", "at": [1, 1], "mode": -1},
    {"kind": "cut", "points": [[0, 0], [1, -100]]},
    {"kind": "partner", "task": "improve", "searcher": "bfts", "budget": 1000},
    {"kind": "stop"},
    {"kind": "undo"},
    {"kind": "export", "format": "stl"},
]
BAD = [
    b"",
    b"{",
    b"null",
    b"[]",
    b"\xff\xfe",
    b'{"kind": "open"}',
    b'{"kind": "open", "task": "../../etc/passwd", "start": "default"}',
    b'{"kind": "open", "task": "bowl", "start": "default", "output": "/tmp"}',
    b'{"kind": "export", "format": "/tmp/x.stl"}',
    b'{"kind": "export", "format": "stl", "path": "/tmp/x.stl"}',
    b'{"kind": "partner", "task": "improve", "searcher": "os.system"}',
    b'{"kind": "partner", "task": "improve", "budget": 1e99}',
    b'{"kind": "partner", "task": "rm"}',
    b'{"kind": "point", "id": 1, "at": ["1", 2]}',
    b'{"kind": "point", "id": 1, "at": [1.5, 2]}',
    b'{"kind": "point", "id": 1, "at": [1000000, 2]}',
    b'{"kind": "point", "id": true, "at": [1, 2]}',
    b'{"kind": "point", "id": 1, "at": [NaN, 2]}',
    b'{"kind": "select", "at": [1, 1], "mode": 0}',
    b'{"kind": "cut", "points": []}',
    json.dumps({"kind": "cut", "points": [[0, 0]] * (MOST_POINTS + 1)}).encode(),
    b'{"kind": ["undo"]}',
    b'{"kind": "undo", "kind2": 1}',
    b"[" * 10_000,
]


def test_the_page_s_types_are_those_of_the_schema() -> None:
    """`npm run types` makes them."""
    assert (ROOT / "viewer/src/studio/messages.ts").read_text(encoding="utf-8") == typescript()


@pytest.mark.parametrize("message", GOOD, ids=lambda message: str(message["kind"]))
def test_what_the_page_says_is_understood(message: dict[str, object]) -> None:
    text = json.dumps(message)
    assert REQUESTS.validate_json(text).kind == message["kind"]
    assert len(text) < LARGEST_REQUEST


def tell(opened: bool, *texts: str | bytes) -> list[Message]:
    """What a tab is told when it sends these messages."""

    async def talk() -> list[Message]:
        said: list[Message] = []
        first = open_design(["target=cube"]) if opened else None
        session = Session(first, lambda task: Path("nowhere"), Loading(), said.append)
        await session.begin()
        said.clear()
        for text in texts:
            await session.take(text)
        session.close()
        return said

    return asyncio.run(talk())


def test_what_does_not_fit_is_refused_in_a_line() -> None:
    for told in tell(True, *BAD):
        assert isinstance(told, TellRefused)
        assert "\n" not in told.says
        assert len(told.says) <= 300
        assert "passwd" not in told.says


def test_nothing_is_played_before_there_is_a_game() -> None:
    for told in tell(False, *(json.dumps(message) for message in GOOD[1:])):
        assert isinstance(told, TellRefused)


def test_answers_keep_their_schema() -> None:
    asked = [
        {"kind": "select", "at": [1, -1], "mode": -1},
        {"kind": "point", "id": 9, "at": [-1, 3]},
        {"kind": "point", "id": 10, "at": [0, 0]},
        {"kind": "place", "at": [1, 3]},
        {"kind": "place", "at": [0, 0]},
        {"kind": "undo"},
    ]
    told = tell(True, *(json.dumps(message) for message in asked))
    for message in told:
        assert REPLIES.validate_json(message.model_dump_json()) == message
    selected, legal, illegal, placed, refused, undone = told
    assert isinstance(selected, TellBoard)
    assert (selected.phase, selected.selected, selected.mode) == ("first", (-1, 1), -1)
    assert isinstance(legal, TellPointed)
    assert legal.legal
    assert legal.ghost is not None
    assert isinstance(illegal, TellPointed)
    assert (illegal.legal, illegal.says) == (False, "new creases leave on the outside of the sheet")
    assert isinstance(placed, TellBoard)
    assert placed.children == [(-1, 3)]
    assert isinstance(refused, TellRefused)
    assert isinstance(undone, TellBoard)
    assert undone.phase == "leaf"
    assert undone.sheet is None  # it is what the page has


@given(st.binary(max_size=200) | st.text(max_size=200))
def test_anything_else_is_refused(text: str | bytes) -> None:
    try:
        REQUESTS.validate_json(text)
    except ValueError:
        return
    raise AssertionError("no message is made by chance")
