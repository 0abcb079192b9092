"""An objective of the user's: scored in a process of its own, however slow, endless or wrong it is."""

from __future__ import annotations

import asyncio
import json
from collections.abc import Callable
from pathlib import Path

import pytest

from origami_lab.config.compose import working_directory_importable
from origami_lab.studio.loading import Loading
from origami_lab.studio.messages import Message
from origami_lab.studio.opening import open_design
from origami_lab.studio.replies import TellBoard, TellPartner, TellPointed, TellRefused, TellWelcome
from origami_lab.studio.session import Session

pytestmark = pytest.mark.slow
SECONDS = 120.0
"""How long anything may take on a busy machine."""
FILE = """
import ctypes, math, os
from pathlib import Path

class Moody:
    def score(self, sheet):
        mood = Path(MOOD).read_text()
        if mood == "endless":
            ctypes.PyDLL(None).sleep(1000)  # in C, with the interpreter's lock
        if mood == "dies":
            os._exit(3)
        if mood == "nan":
            return math.nan
        if mood == "raises":
            raise RuntimeError("the kettle is empty")
        return float(sheet.points[sheet.reach - 1][:, 2].max())
"""
OPTION = """
# @package _global_
task: moody
objective:
  _target_: moody_objective.Moody
"""


class Tab:
    """A tab's session, and what it was told."""

    def __init__(self, folder: Path, words: list[str], *, gallery: bool = False) -> None:
        self.told: list[Message] = []
        opened = None if gallery else open_design(words, folder / "conf")
        self.session = Session(opened, lambda task: folder / "out", Loading(), self.told.append, folder / "conf")

    async def __aenter__(self) -> Tab:
        await self.session.begin()
        return self

    async def __aexit__(self, *how: object) -> None:
        self.session.close()

    async def ask(self, **message: object) -> None:
        await self.session.take(json.dumps(message))

    @property
    def board(self) -> TellBoard:
        return [told for told in self.told if isinstance(told, TellBoard)][-1]

    async def until(self, holds: Callable[[], object]) -> None:
        async with asyncio.timeout(SECONDS):
            while not holds():
                await asyncio.sleep(0.02)


@pytest.fixture
def folder(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """A working directory with an objective of the user's."""
    monkeypatch.chdir(tmp_path)
    (tmp_path / "conf/objective").mkdir(parents=True)
    (tmp_path / "conf/objective/moody.yaml").write_text(OPTION)
    (tmp_path / "moody_objective.py").write_text(FILE.replace("MOOD)", f"{str(tmp_path / 'mood')!r})"))
    (tmp_path / "mood").write_text("")
    return tmp_path


WORDS = ["objective=moody", "board.size=9", "symmetry=xy", "start.size=1", "objective_seconds=1"]
EXTEND = [
    {"kind": "select", "at": [-1, 1], "mode": -1},
    *({"kind": "place", "at": at} for at in ([-1, 3], [-3, 1], [-2, 2])),
]


def test_whatever_it_does_the_page_is_answered_and_it_is_asked_again(folder: Path) -> None:
    async def talk() -> None:
        async with Tab(folder, WORDS) as tab:
            await moods(tab)

    async def moods(tab: Tab) -> None:
        await tab.until(lambda: not tab.board.scoring)
        assert tab.board.worth is not None
        assert tab.board.worth.value == 0.0  # a sheet that lies flat
        (folder / "mood").write_text("endless")
        for message in EXTEND:
            await tab.ask(**message)
        assert tab.board.scoring  # it is at work, and the page is told everything else
        assert (tab.board.worth, tab.board.panels) == (None, 13)
        await tab.ask(kind="point", id=1, at=[-3, 3])
        assert isinstance(tab.told[-1], TellPointed)
        for task in ({"kind": "save"}, {"kind": "partner", "task": "finish"}, {"kind": "partner", "task": "measure"}):
            await tab.ask(**task)
            refused = tab.told[-1]
            assert isinstance(refused, TellRefused)
            assert refused.says == "the objective is still at work on this design: wait for its return"
        await tab.until(lambda: not tab.board.scoring)
        assert tab.board.note == "no return: the objective took longer than objective_seconds=1 in one call"
        assert tab.board.worth is None
        await tab.ask(kind="save")
        assert isinstance(tab.told[-1], TellRefused)
        for mood, says in (
            ("dies", "its process died"),
            ("nan", "objective=Moody: score returned NaN; it must return a number"),
            ("raises", "RuntimeError: the kettle is empty"),
            ("", None),
        ):
            (folder / "mood").write_text(mood)
            await tab.ask(kind="cut", points=[[-1, 1]])
            await tab.until(lambda: not tab.board.scoring)
            for message in EXTEND[:-1]:
                await tab.ask(**message)
            at = {"dies": [-3, 3], "nan": [-2, 3], "raises": [-3, 2], "": [-2, 2]}[mood]
            await tab.ask(kind="place", at=at)
            if mood == "":  # a design that was asked about before is asked about no more
                continue
            await tab.until(lambda: not tab.board.scoring)
            assert tab.board.note == f"no return: {says}", mood

    with working_directory_importable():
        asyncio.run(talk())


def test_it_is_saved_and_searched_for_like_any_other(folder: Path) -> None:
    async def talk() -> None:
        async with Tab(folder, [], gallery=True) as tab:
            welcome = tab.told[0]
            assert isinstance(welcome, TellWelcome)
            assert "moody" in [task.name for task in welcome.tasks]
        async with Tab(folder, [*WORDS, "max_crease_length=2"]) as tab:
            await box(tab)

    async def box(tab: Tab) -> None:
        for message in EXTEND:
            await tab.ask(**message)
        await tab.until(lambda: not tab.board.scoring)
        worth = tab.board.worth
        assert worth is not None
        assert worth.value == pytest.approx(2.0, abs=0.01)  # the walls of a box
        await tab.ask(kind="partner", task="finish", searcher="rdm", budget=500)
        await tab.until(lambda: isinstance(tab.told[-1], TellPartner) and not tab.told[-1].running)
        await tab.ask(kind="save")
        await tab.until(lambda: (folder / "out/seed=0/best.fold").is_file() and not tab.board.unsaved)

    with working_directory_importable():
        asyncio.run(talk())
    again = open_design([str(folder / "out")])
    assert type(again.objective).__name__ == "Moody"
