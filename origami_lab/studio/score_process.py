"""A user's objective at work on the designs of a board, in a process of its own that a call cannot hold up for ever."""

from __future__ import annotations

from collections.abc import Callable

from origami_lab.objectives.objective import Score
from origami_lab.studio.opening import Opened
from origami_lab.studio.partner_process import PartnerProcess
from origami_lab.studio.partner_worker import Done, Order

Learn = Callable[[tuple[int, ...], Score | None, str], None]
"""Takes a design, what it is worth, and why that is not known."""


class ScoreProcess:
    """Scores one design at a time, then the one that was wanted last.

    A call that takes longer than ``objective_seconds`` ends with its process, as in a run.
    """

    def __init__(self, opened: Opened, learn: Learn) -> None:
        self._process = PartnerProcess(opened.settings, opened.game, self._hear, searches=False)
        self._learn = learn
        self._wanted: tuple[int, ...] | None = None

    def want(self, actions: tuple[int, ...]) -> None:
        """Have a design scored, once the present one is."""
        present = self._process.order
        if present is None:
            self._process.give(Order(0, "score", actions, None))
        self._wanted = None if present is None or present.actions == actions else actions

    def close(self) -> None:
        """End the process, whatever it is doing."""
        self._process.close()

    def _hear(self, order: Order, what: object) -> None:
        if not isinstance(what, Done):
            return
        wanted, self._wanted = self._wanted, None
        if wanted is not None:
            self.want(wanted)
        self._learn(order.actions, what.result, what.error)
