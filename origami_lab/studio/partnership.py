"""What a session's partner is asked for, what it offers, and what is kept of it."""

from __future__ import annotations

import base64
import math
import os
import shlex
import time
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from origami_lab.config.option_files import read_options
from origami_lab.game.moves import Move, move_to_dict
from origami_lab.studio.board_telling import proposal_of, sheet_data, spoken
from origami_lab.studio.design_board import DesignBoard, Refused
from origami_lab.studio.design_figures import Furthest, Measured
from origami_lab.studio.design_saving import ToSave
from origami_lab.studio.messages import AskExport, AskPartner, AskProposal, Message
from origami_lab.studio.opening import Opened
from origami_lab.studio.partner_process import PartnerProcess
from origami_lab.studio.partner_search import FoundDesign, SearchProgress, without_end
from origami_lab.studio.partner_worker import Certified, Done, Order, Suggested
from origami_lab.studio.replies import (
    Mark,
    TellCertified,
    TellExported,
    TellLook,
    TellMeasured,
    TellPartner,
    TellProposals,
    TellSaved,
    Worth,
)

SEARCHES = ("suggest", "finish", "improve", "repair")
BEGINS = {
    "suggest": "looking for the next moves",
    "finish": "going on from here",
    "improve": "looking for something better",
    "repair": "growing the selected region anew",
    "measure": "measuring",
    "certify": "verifying",
    "save": "saving",
    "polish": "polishing the saved design",
    "simplify": "simplifying the saved design",
    "export": "writing the file",
}


@dataclass(frozen=True)
class Offer:
    """What can be taken: a whole design, or the next move."""

    moves: tuple[Move, ...]
    worth: Worth | None
    next_move: Move | None = None


class Partnership:
    """The worker process of a session, its orders, and the history of the design.

    Parameters
    ----------
    adopted
        Called when the board has changed, with a line for the page; with None when the design was saved.
    """

    def __init__(
        self,
        opened: Opened,
        board: DesignBoard,
        folder: Callable[[str], Path],
        send: Callable[[Message], None],
        adopted: Callable[[str | None], None],
    ) -> None:
        self.opened, self.board, self.send, self.adopted = opened, board, send, adopted
        self._folder = folder
        self.path: Path | None = None
        """Where it was saved."""
        self.process = PartnerProcess(opened.settings, opened.game, self._hear)
        self.offers: list[Offer] = []
        self.history: list[dict[str, Any]] = []
        self.interactions = 0
        self._began, self._orders, self._revision = time.monotonic(), 0, 0
        self._next: tuple[str, str] | None = None
        """What follows once the design is saved: a task, and a format."""
        self._saved_actions: tuple[int, ...] | None = None
        self._present: tuple[int, ...] = ()
        """The design that a partner began with."""

    def ready(self) -> None:
        """Have the process load what it needs while the design begins."""
        self.process.start()

    def close(self) -> None:
        """End its process."""
        self.process.close()

    def note(self, what: str, actions: tuple[int, ...]) -> None:
        """A step of the design, for its history."""
        moves = [move_to_dict(move) for move in self.opened.game.moves(actions)]
        self.history.append({"step": what, "seconds": self._seconds(), "moves": moves})

    def _seconds(self) -> float:
        return round(time.monotonic() - self._began, 1)

    # --- what is asked for -------------------------------------------------------------------------------------------

    def take(self, request: Any, revision: int) -> None:
        """Carry out a request that is a partner's; raises Refused."""
        if isinstance(request, AskProposal):
            self._about_offers(request)
            return
        if self.process.order is not None:
            raise Refused("a partner is at work: stop it first")
        self._revision = revision
        if isinstance(request, AskPartner):
            self._ask(request)
        elif isinstance(request, AskExport):
            self._after_saving("export", request.format)
        else:
            self._save()

    def _ask(self, request: AskPartner) -> None:
        task = request.task
        if task in ("polish", "simplify"):
            self._after_saving(task, "")
            return
        if not self.board.is_placed:
            raise Refused("lay the start pattern first")
        if task != "certify":
            self._require_score()
        if task == "measure" and self._worth() is None:
            raise Refused("there is nothing to measure yet: the design has no return")
        node = None
        if task in SEARCHES:
            node = read_options("search", self.opened.own).get(request.searcher, {}).get("search")
            if node is None:
                raise Refused("there is no such searcher")
            self.offers = []
            self.send(TellProposals(task=task, proposals=[]))
        region = tuple(request.region)
        if task == "repair" and not region:
            raise Refused("select a region of the board first")
        self._present = self.board.actions
        self._give(task, search=node, budget=request.budget, seed=self._orders, region=region)
        if task in SEARCHES:
            asked = {"searcher": request.searcher, "budget": request.budget, "seed": self._orders - 1}
            self.history.append(
                {"partner": task, "seconds": self._seconds(), **asked, "region": [list(p) for p in region]}
            )

    def _give(self, task: str, **rest: Any) -> None:
        order = Order(self._orders, task, self.board.actions, self._worth(), **rest)
        self._orders += 1
        self.process.give(order)
        loads = (
            "" if self.process.is_ready else " (once it has loaded; on a new installation kernels are compiled first)"
        )
        self.send(TellPartner(task=task, running=True, says=BEGINS[task] + loads))

    def _require_score(self) -> None:
        if not self.board.is_scored:
            raise Refused("the objective is still at work on this design: wait for its return")

    def _worth(self) -> tuple[float, int] | None:
        score = self.board.score()
        return None if score is None else (score.value, score.angle)

    def _after_saving(self, task: str, name: str) -> None:
        """Save, if that is due, then work on the files."""
        if self._saved_actions == self.board.actions and self.path is not None:
            self._give(task, path=self.path, format=name)
        else:
            self._next = (task, name)
            self._save()

    def _save(self) -> None:
        worth = self._worth()
        try:
            self._require_score()
            if not self.board.has_design:
                raise Refused("there is nothing to save yet: extend a leaf first")
            if worth is None:
                raise Refused("it has no return, and cannot be saved")
        except Refused:
            self._next = None
            raise
        path = self.path or self._folder(self.opened.settings.task)
        played = self.interactions + len(self.board.actions)
        made = ToSave(path, self.board.actions, *worth, played, self._seconds(), tuple(self.history))
        self._give("save", save=made)

    # --- what it answers ---------------------------------------------------------------------------------------------

    def _hear(self, order: Order, what: Any) -> None:
        match what:
            case SearchProgress(interactions=interactions, best=best):
                says = BEGINS[order.task]
                told = TellPartner(task=order.task, running=True, says=says, interactions=interactions, best=best)
                self.send(told)
            case FoundDesign():
                self._offer(order.task, [Offer(what.moves, self._worth_of(what.value, what.angle))])
            case Done():
                self._done(order, what)

    def _done(self, order: Order, done: Done) -> None:
        task, result = order.task, done.result
        self.interactions += done.interactions
        says = done.error or self._said(task, result)
        self.send(TellPartner(task=task, running=False, says=says, interactions=done.interactions))
        then, self._next = self._next, None
        if done.error:
            return
        if task == "save":
            assert order.save is not None
            self._saved(order.save, result)
            if then is not None:
                self._give(then[0], path=self.path, format=then[1])
        elif task == "export":
            name, content = result
            self.send(TellExported(name=name, content=base64.b64encode(content).decode()))
        elif isinstance(result, Measured):
            self._measured(result)
        elif isinstance(result, Certified):
            found = TellCertified(
                revision=self._revision, verdict=result.verdict, says=result.reason, panels=list(result.panels)
            )
            self.send(found)

    def _said(self, task: str, result: Any) -> str:
        """What a task has come to, in a line."""
        if isinstance(result, Suggested):
            offers = [
                Offer(found.moves, self._worth_of(value, found.angle), move) for move, value, found in result.moves
            ]
            self._offer(task, offers)
            return f"{len(offers)} next moves" if offers else "no next move was found: the sheet may be finished"
        if task in SEARCHES:
            return "here is a better one: take it or leave it" if self.offers else "nothing better was found"
        if task in ("polish", "simplify"):
            says, file = result
            return f"{says}: {file}"
        return "done"

    def _saved(self, made: ToSave, notes: list[str]) -> None:
        self.path, self._saved_actions = made.path, made.actions
        command = f"origami-lab studio {shlex.quote(os.path.relpath(made.path))}"
        self.send(TellSaved(path=os.path.relpath(made.path), command=command, notes=notes))
        if made.actions == self.board.actions:
            self.adopted(None)

    def _measured(self, found: Measured) -> None:
        told = TellMeasured(
            revision=self._revision,
            figures=found.figures,
            sharpest=found.sharpest,
            narrowest=found.narrowest,
            sheet=_mark(found.sheet),
            target=_mark(found.target),
        )
        self.send(told)

    # --- offers ------------------------------------------------------------------------------------------------------

    def _worth_of(self, value: float, angle: int) -> Worth:
        return Worth(value=value, angle=math.degrees(self.opened.game.angles[angle]))

    def _offer(self, task: str, offers: list[Offer]) -> None:
        self.offers, game, proposals = offers, self.opened.game, []
        present = without_end(game.moves(self._present))
        for number, offer in enumerate(offers):
            one = offer.next_move
            moves = offer.moves if one is None else (*present, one)
            says = f"{len(offer.moves)} moves" if one is None else spoken(one)
            offered = game.finished_actions(game.replay_moves(moves))
            proposals.append(proposal_of(game, number, self._present, offered, offer.worth, says))
        self.send(TellProposals(task=task, proposals=proposals))

    def _about_offers(self, request: AskProposal) -> None:
        if request.kind == "stop":
            self.process.stop()
            return
        if request.kind == "leave":
            self.history.append({"left": len(self.offers), "seconds": self._seconds()})
            self.offers = []
            self.send(TellProposals(task="", proposals=[]))
            return
        if request.number >= len(self.offers):
            raise Refused("this is no longer offered")
        offer = self.offers[request.number]
        if request.kind == "look":
            actions = self._actions_of(offer)
            sheet = sheet_data(self.opened.game, actions)
            assert sheet is not None
            self.send(TellLook(number=request.number, sheet=sheet, worth=offer.worth))
            return
        if offer.next_move is not None:
            self.board.play_move(offer.next_move)
            self.offers = []
            self.send(TellProposals(task="", proposals=[]))
            self.adopted("taken: one move")
        else:
            self.board.adopt(self._actions_of(offer), "partner's design")
            if self.process.order is None:
                self.offers = []
                self.send(TellProposals(task="", proposals=[]))
            self.adopted("taken")

    def _actions_of(self, offer: Offer) -> tuple[int, ...]:
        """The log of an offer in the session's game; of a next move, of the design that it was found in."""
        game = self.opened.game
        try:
            return game.finished_actions(game.replay_moves(offer.moves))
        except ValueError as error:
            raise Refused(f"this cannot be played here: {error}") from error


def _mark(found: Furthest | None) -> Mark | None:
    if found is None:
        return None
    return Mark(at=list(found.at), board=None if found.board is None else list(found.board), distance=found.distance)
