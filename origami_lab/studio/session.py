"""One tab of the page: a board, its partner, and the answers to what the page asks for."""

from __future__ import annotations

import asyncio
import logging
import math
from collections.abc import Callable
from pathlib import Path
from typing import Any

from pydantic import ValidationError

from origami_lab.config.option_files import read_options
from origami_lab.config.physical_size import is_distance, millimetres_per_cell
from origami_lab.drawing.scene import TargetSurface
from origami_lab.drawing.viewer import LARGEST_TARGET, packed_surface
from origami_lab.errors import InputError
from origami_lab.export.formats import FORMATS
from origami_lab.objectives.objective import Score
from origami_lab.polish.polisher import can_be_polished
from origami_lab.studio.board_telling import board_view, motion_told, pointed_view, sheet_data
from origami_lab.studio.design_board import DesignBoard, Refused
from origami_lab.studio.loading import Loading
from origami_lab.studio.messages import (
    REQUESTS,
    AskCut,
    AskExport,
    AskOpen,
    AskPartner,
    AskPlace,
    AskPoint,
    AskProposal,
    AskSave,
    AskSelect,
    AskShift,
    AskSource,
    AskStart,
    AskStep,
    Message,
)
from origami_lab.studio.opening import Opened, open_settings
from origami_lab.studio.partnership import Partnership
from origami_lab.studio.replies import Packed, TellOpened, TellOpening, TellRefused, TellWelcome
from origami_lab.studio.score_process import ScoreProcess
from origami_lab.studio.start_gallery import STARTS, settings_of, tasks
from origami_lab.workers.guarded_objective import is_ours
from origami_lab.workers.worker_process import reason_of

Send = Callable[[Message], None]
NO_SEARCHERS = {"ppo"}
"""Those that learn for hours: no partners."""
PAGE_SECONDS = 1.0
"""For which the page has the machine to itself, before a partner's process loads what it needs."""
SLOW_FORMATS = {"mp4"}


class Session:
    """One tab.

    Parameters
    ----------
    opened
        What the studio was started with; None for the gallery.
    folder
        Gives the folder for a design to be saved in, by the name of its task.
    loading
        Of what all tabs need.
    send
        Takes messages for the page.
    own
        A folder with options of the user's own, for the gallery.
    """

    def __init__(
        self,
        opened: Opened | None,
        folder: Callable[[str], Path],
        loading: Loading,
        send: Send,
        own: Path | None = None,
    ) -> None:
        self.opened, self.folder, self.loading, self.send, self.own = opened, folder, loading, send, own
        self.scoring: ScoreProcess | None = None
        """Of a user's own objective."""
        self.board: DesignBoard | None = None
        self.partnership: Partnership | None = None
        self.revision = 0
        self._saved: tuple[int, ...] = ()
        """The design that is on disk."""
        self._told_sheet: tuple[int, ...] | None = None
        self._tasks: set[asyncio.Task[None]] = set()

    async def begin(self) -> None:
        """Say what there is, and open it."""
        self.send(TellWelcome(tasks=tasks(self.own), starts=list(STARTS), opens=self.opened is not None))
        if self.opened is not None:
            try:
                await self._open(self.opened)
            except (Refused, InputError) as error:
                self.send(TellRefused(says=str(error)))

    def close(self) -> None:
        """End all that works for it."""
        for task in self._tasks:
            task.cancel()
        self._end_processes()

    def _end_processes(self) -> None:
        for process in (self.partnership, self.scoring):
            if process is not None:
                process.close()
        self.partnership = self.scoring = None

    async def take(self, text: str | bytes) -> None:
        """Answer one message of the page; whatever is wrong with it is said in an answer."""
        try:
            request = REQUESTS.validate_json(text)
        except ValidationError as error:
            first = error.errors(include_url=False, include_input=False, include_context=False)[0]
            where = ".".join(str(part) for part in first["loc"]) or "message"
            self.send(TellRefused(says=f"not understood: {where}: {first['msg']}"[:300]))
            return
        try:
            if isinstance(request, AskOpen):
                await self._begin(request)
            else:
                self._answer(request)
        except (Refused, InputError) as error:
            self.send(TellRefused(says=str(error)))
        except Exception as error:  # of an objective of the user's, or ours: it ends no tab
            logging.getLogger(__name__).exception("a request could not be answered")
            self.send(TellRefused(says=f"internal error: {reason_of(error)}"))

    # --- opening -----------------------------------------------------------------------------------------------------

    async def _begin(self, request: AskOpen) -> None:
        settings = settings_of(request.task, request.start, self.own)
        if settings is None:
            raise Refused("there is no such task in the gallery")
        await self._open(await asyncio.to_thread(open_settings, settings, self.own))

    async def _open(self, opened: Opened) -> None:
        await self.loading.wait(opened, lambda says: self.send(TellOpening(says=says)))
        self._end_processes()
        self.opened = opened
        self.board = DesignBoard(opened.game, opened.objective, opened.actions)
        if not is_ours(opened.objective):
            self.scoring = ScoreProcess(opened, self._learn)
        self.partnership = Partnership(opened, self.board, self.folder, self.send, self._adopted)
        if self.board.phase == 0 and len(self.board.placements()) == 1 and opened.actions is None:
            self.board.place_start(0, 1)  # there is nothing to choose but its sign, which mirrors all that follows
        self.revision, self._told_sheet = self.revision + 1, None
        self._saved = self.board.actions
        self.send(_told_of(opened, self.board))
        self._tell_board()
        self._later(self._ready(self.partnership))

    async def _ready(self, partnership: Partnership) -> None:
        await asyncio.sleep(PAGE_SECONDS)
        if partnership is self.partnership:
            partnership.ready()

    # --- answers -----------------------------------------------------------------------------------------------------

    def _answer(self, request: Any) -> None:
        board, partnership = self.board, self.partnership
        if board is None or partnership is None:
            raise Refused("begin a design first")
        note = None
        match request:
            case AskPoint(id=number, at=at):
                self.send(pointed_view(board, number, self._inside(at)))
                return
            case AskPartner() | AskProposal() | AskSave() | AskExport():
                partnership.take(request, self.revision)
                return
            case AskSelect(at=at, mode=mode):
                board.select(board.playable(self._inside(at)), mode)
            case AskPlace(at=at):
                board.place(board.playable(self._inside(at)))
            case AskStart(option=option, sign=sign):
                board.place_start(option, sign)
            case AskSource(number=number, sign=sign):
                board.lay_source(number, sign)
            case AskStep(kind=kind):
                {"back": board.back, "undo": board.undo, "redo": board.redo, "terminate": board.terminate}[kind]()
            case AskCut(points=points):
                note = _lost(board.cut([self._inside(point) for point in points]), "cut off")
            case AskShift(at=at, to=to):
                lost = board.shift(self._inside(at), self._inside(to))
                note = _lost(lost, "no longer legal there, and taken out") if lost else "all of it still folds"
        self._tell_board(note)

    def _adopted(self, note: str | None) -> None:
        """A proposal was taken, or the design was saved."""
        if note is None and self.board is not None:
            self._saved = self.board.actions
        self._tell_board(note)

    def _learn(self, actions: tuple[int, ...], score: Score | None, error: str) -> None:
        """A user's objective has said what a design is worth, or why it does not."""
        if self.board is not None:
            self.board.scores.learn(actions, score)
            if actions == self.board.actions:
                self._tell_board(f"no return: {error}" if error else None)

    def _inside(self, at: tuple[int, int]) -> tuple[int, int]:
        assert self.board is not None
        half_x, half_y = self.board.game.rules.half
        if abs(at[0]) > half_x or abs(at[1]) > half_y:
            raise Refused("outside the board")
        return at

    def _tell_board(self, note: str | None = None) -> None:
        board = self.board
        assert board is not None
        assert self.partnership is not None
        sheet = None
        if board.actions != self._told_sheet:
            if self._told_sheet is not None:
                self.revision += 1
                self.partnership.note(board.steps[board.at].what, board.actions)
            self._told_sheet = board.actions
            sheet = sheet_data(board.game, board.actions)
            if sheet is not None:
                self._later(self._tell_motion(self.revision, board, board.actions))
        unsaved = board.has_design and board.actions != self._saved
        self.send(board_view(board, self.revision, sheet, unsaved=unsaved, note=note))
        if not board.is_scored:
            assert self.scoring is not None
            self.scoring.want(board.actions)

    async def _tell_motion(self, revision: int, board: DesignBoard, actions: tuple[int, ...]) -> None:
        await asyncio.sleep(0.15)  # steps in quick succession ask once
        if revision == self.revision:
            told = await asyncio.to_thread(motion_told, revision, board.game, actions)
            if revision == self.revision:
                self.send(told)

    def _later(self, work: Any) -> None:
        task = asyncio.get_running_loop().create_task(work)
        self._tasks.add(task)
        task.add_done_callback(self._tasks.discard)


def _lost(moves: int, what: str) -> str:
    return f"{moves} move{'' if moves == 1 else 's'} {what}"


def _told_of(opened: Opened, board: DesignBoard) -> TellOpened:
    settings, game, target = opened.settings, opened.game, opened.target
    searchers = set(read_options("search", opened.own)) - NO_SEARCHERS
    surface = None if target is None else TargetSurface(target.vertices, target.faces)
    shown = surface is not None and len(surface.faces) <= LARGEST_TARGET
    rules = {
        "board": f"{game.board[0]} × {game.board[1]}",
        "symmetry": game.symmetry.name,
        "longest crease": settings.game.max_crease_length,
        "shortest crease": settings.game.min_crease_length,
        "sharpest angle": settings.game.min_sector_angle,
        "narrowest panel": settings.game.min_panel_width,
    }
    return TellOpened(
        task=settings.task,
        title=opened.title or settings.task,
        half=game.rules.half,
        symmetry=game.symmetry.name,
        matrices=[matrix.ravel().tolist() for matrix in game.symmetry.matrices],
        angles=[math.degrees(angle) for angle in game.angles],
        first_angle=game.first_angle,
        rules=[*settings.part_lines, *(f"{name} {value}" for name, value in rules.items() if value is not None)],
        searchers=sorted(searchers, key=lambda name: (name != "lns", name)),
        formats=[name for name in FORMATS if name not in SLOW_FORMATS],
        distance=is_distance(opened.objective),
        cell_mm=millimetres_per_cell(settings, target),
        target=Packed(**packed_surface(surface)) if surface is not None and shown else None,
        polishes=can_be_polished(opened.objective),
    )
