"""A worker process of the studio: searches, measures, certifies, saves and polishes while the page stays fluent."""

from __future__ import annotations

import traceback
from collections.abc import Mapping, Sequence
from contextlib import suppress
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

from origami_lab.config.instantiate import build_objective, build_searcher
from origami_lab.config.settings import Settings
from origami_lab.errors import InputError
from origami_lab.game.folded_sheet import FoldedSheet
from origami_lab.game.game import Game
from origami_lab.game.moves import Move, Point
from origami_lab.objectives.objective import bind
from origami_lab.runs.run_folder import FolderError
from origami_lab.studio.design_figures import measure_design
from origami_lab.studio.design_saving import SEED, ToSave, save_design
from origami_lab.studio.design_scores import score_of
from origami_lab.studio.partner_search import FoundDesign, Partner, SearchProgress
from origami_lab.workers.call_limit import Calls
from origami_lab.workers.guarded_objective import is_ours, watched
from origami_lab.workers.worker_process import Orders, reason_of


@dataclass(frozen=True)
class Order:
    """What a partner is to do, on the design that a log of actions leads to."""

    number: int
    """Answers bear it."""
    task: str
    actions: tuple[int, ...]
    worth: tuple[float, int] | None
    """Its return and its driving angle's index; None where it has none."""
    search: Mapping[str, Any] | None = None
    """The searcher, as a configuration has it."""
    budget: int = 0
    seed: int = 0
    region: tuple[Point, ...] = ()
    save: ToSave | None = None
    path: Path | None = None
    """The run folder of a saved design."""
    format: str = ""


READY = -2
"""Number of the answer that says that orders are carried out at once now."""


@dataclass(frozen=True)
class Heard:
    """An answer to an order: :class:`SearchProgress`, :class:`FoundDesign`, or what it has come to, the last."""

    number: int
    what: Any


@dataclass(frozen=True)
class Done:
    """The last answer: the task has ended by itself or was stopped."""

    result: Any = None
    error: str = ""
    interactions: int = 0


@dataclass(frozen=True)
class Suggested:
    """Next moves, the best first, each with the return of the design that it comes from."""

    moves: tuple[tuple[Move, float, FoundDesign], ...]


@dataclass(frozen=True)
class Certified:
    """What the verification says."""

    verdict: str
    reason: str
    panels: tuple[int, ...]


def serve(orders: Orders, calls: Calls, settings: Settings, game: Game, searches: bool) -> None:
    """Take orders until the parent has no more or goes away; ``searches`` has the searchers ready before."""
    target, objective = build_objective(settings)
    objective = watched(objective, calls)
    if searches:
        with suppress(Exception):
            _warm_up(settings, game, objective)
    orders.say(Heard(READY, None))
    while (order := orders.next()) is not None:
        if not isinstance(order, Order):  # to stop what has ended meanwhile
            continue
        orders.begin()
        number = order.number

        def say(what: Any, number: int = number) -> None:
            orders.say(Heard(number, what))

        partner = Partner(settings, game, objective, say, orders.stop)
        try:
            result = _carry_out(order, settings, game, objective, target, partner, orders)
            say(Done(result, interactions=partner.interactions))
        except InputError as error:
            say(Done(error=str(error)))
        except (OSError, FolderError) as error:
            say(Done(error=f"cannot be written: {FolderError(error).why if isinstance(error, OSError) else error.why}"))
        except Exception as error:  # what is wrong with a part of the user's ends a task and nothing else
            traceback.print_exc()
            say(Done(error=reason_of(error)))


def _carry_out(
    order: Order, settings: Settings, game: Game, objective: Any, target: Any, partner: Partner, orders: Orders
) -> Any:
    actions, worth = order.actions, order.worth

    def make() -> Any:
        assert order.search is not None
        return build_searcher(replace(settings, search=dict(order.search)))

    match order.task:
        case "suggest":
            return Suggested(tuple(partner.suggest(actions, make, order.budget, order.seed)))
        case "finish":
            partner.finish(actions, worth, make, order.budget, order.seed)
        case "improve":
            partner.improve(actions, worth, make, order.budget, order.seed)
        case "repair":
            partner.repair(actions, worth, make, order.budget, order.seed, order.region)
        case "score":
            return score_of(bind(objective, game), game.replay(actions))
        case "measure":
            assert worth is not None
            return measure_design(game, objective, actions, worth[1])
        case "certify":
            return _certified(settings, game, target, actions, worth)
        case "save":
            assert order.save is not None
            return save_design(settings, game, objective, target, order.save)
        case "polish" | "simplify":
            assert order.path is not None
            return _rework(order.task, order.path, game, objective, target, partner, orders)
        case "export":
            assert order.path is not None
            return _export(order.path, order.format)
    return None


def _certified(
    settings: Settings, game: Game, target: Any, actions: tuple[int, ...], worth: tuple[float, int] | None
) -> Certified:
    from origami_lab.config.physical_size import thickness_in_cells
    from origami_lab.verification.verify_design import verify

    design = game.design(actions, None if worth is None else worth[1])
    found = verify(design, thickness_in_cells(settings, target))
    return Certified(found.verdict, found.reason, tuple(found.panels or ()))


def _rework(
    task: str, run: Path, game: Game, objective: Any, target: Any, partner: Partner, orders: Orders
) -> Sequence[str]:
    """Polish or simplify a saved design; returns what came of it, a line each."""
    from origami_lab.experiment.reworked_designs import PolishOptions, polish_trial, simplify_saved
    from origami_lab.experiment.run_summary import refresh_tables
    from origami_lab.experiment.saved_design import saved_in
    from origami_lab.runs.locks import locked
    from origami_lab.runs.run_folder import RunFolder

    folder = RunFolder(run)
    if task == "simplify":
        made = simplify_saved(folder.trial(SEED) / "best.fold").made
        before, after = made.figures_before, made.figures
        says = f"return {made.value_before:.4f} → {made.value:.4f}, panels {before.panels} → {after.panels}"
        return [f"{says}, {made.certificate.verdict}", str(folder.trial(SEED) / "simplified.fold")]
    saved = saved_in(folder.trial(SEED), game, objective, target)
    with locked(run):
        done, _ = polish_trial(
            saved,
            folder,
            PolishOptions(),
            on_progress=lambda laid, best: partner.report(SearchProgress(laid, best)),
            should_stop=orders.stop,
        )
        refresh_tables(folder)
    made_of, result = done.made.returns_before["return"], done.made.returns["return"]
    says = f"return {made_of:.4f} → {result:.4f}, driving angle {done.made.driving_angle:.2f}°"
    return [f"{says}, {done.made.certificate.verdict}", str(folder.trial(SEED) / "polished.fold")]


def _export(run: Path, name: str) -> tuple[str, bytes]:
    """Write a saved design in a format; returns the file's name and its content."""
    from origami_lab.export.formats import export_design
    from origami_lab.runs.run_folder import RunFolder

    [file, *_] = export_design(RunFolder(run).trial(SEED), name).files
    return file.name, file.read_bytes()


class Indifferent:
    """An objective that likes all designs alike: stands in for one of the user's, whose calls may take long."""

    def score(self, sheet: FoldedSheet) -> float:
        """Nothing."""
        return 0.0


def _warm_up(settings: Settings, game: Game, objective: Any) -> None:
    """Load, and on a new installation compile, what the partners need, before anybody waits for it."""
    from origami_lab.search.neighbourhood.search import NeighbourhoodSearch

    stand_in = objective if is_ours(objective) else Indifferent()
    quiet = Partner(settings, game, stand_in, lambda what: None, lambda: False)
    quiet.improve(game.bare_start(), None, NeighbourhoodSearch, 400, 0)
