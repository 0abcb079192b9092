"""What a board needs, in memory before anybody plays on it: on a new installation kernels are compiled for a while."""

from __future__ import annotations

import asyncio
import threading
from collections.abc import Callable
from contextlib import suppress

from origami_lab.jit import compile_clock
from origami_lab.studio.board_telling import board_view, motion_told, pointed_view, sheet_data
from origami_lab.studio.design_board import DesignBoard
from origami_lab.studio.opening import Opened

COMPILES = "compiling what this installation needs: once, for a minute or two, or longer on a busy machine"
MOST_TRIED = 30
"""Places that are tried for an extension."""
Kind = tuple[object, ...]


class Loading:
    """Loads in a thread, for all tabs, what each kind of game needs."""

    def __init__(self) -> None:
        self._kinds: dict[Kind, asyncio.Task[None]] = {}
        self._listeners: list[Callable[[str], None]] = []
        self._compiles = False

    def begin(self, opened: Opened) -> asyncio.Task[None]:
        """Load for a game, once for all of its kind."""
        kind = (type(opened.objective), opened.game.symmetry.name, type(opened.game.start))
        if kind not in self._kinds:
            self._kinds[kind] = asyncio.create_task(self._load(opened))
        return self._kinds[kind]

    async def wait(self, opened: Opened, say: Callable[[str], None]) -> None:
        """Load for a game; ``say`` is told where that takes long."""
        self._listeners.append(say)
        try:
            if self._compiles:
                say(COMPILES)
            await asyncio.shield(self.begin(opened))
        finally:
            self._listeners.remove(say)

    async def _load(self, opened: Opened) -> None:
        loop = asyncio.get_running_loop()

        def compiles() -> None:
            loop.call_soon_threadsafe(self._say)

        with compile_clock(compiles):
            await _in_daemon(lambda: play_once(opened))
        self._compiles = False

    def _say(self) -> None:
        self._compiles = True
        for say in self._listeners:
            say(COMPILES)


async def _in_daemon(work: Callable[[], None]) -> None:
    """Wait for work in a thread that ends with the process: Ctrl-C waits for no compiler."""
    loop, done = asyncio.get_running_loop(), asyncio.Event()

    def run() -> None:
        work()
        with suppress(RuntimeError):  # the loop has ended
            loop.call_soon_threadsafe(done.set)

    threading.Thread(target=run, daemon=True, name="loading").start()
    await done.wait()


def play_once(opened: Opened) -> None:
    """Do on a board of its own what is done on one, so that all that it takes is loaded."""
    board = DesignBoard(opened.game, opened.objective)
    with suppress(Exception):  # whatever it is, it is said where it matters
        for _ in range(MOST_TRIED):
            _play(board)
            if board.has_design:
                break
    with suppress(Exception):
        sheet = sheet_data(board.game, board.actions)
        board_view(board, 0, sheet, unsaved=False)
        motion_told(0, board.game, board.actions)
        board.undo()
        board.redo()


def _play(board: DesignBoard) -> None:
    """One action, pointed at before."""
    if board.placements():
        board.place_start(0, 1)
    elif board.phase == 1:
        board.sources()
        leaf = next(at for at, reason in board.leaves() if reason is None)
        pointed_view(board, 0, leaf)
        board.select(leaf, -1)
    elif places := board.places():
        at = places[len(places) // 2][0]
        pointed_view(board, 0, at)
        pointed_view(board, 0, (0, 0))
        board.place(at)
    else:
        board.back()
