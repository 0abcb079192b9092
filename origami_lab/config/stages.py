"""The stages of a run that went on: what each of its trials was given, one stage after the other."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass
from typing import Annotated, Any

from origami_lab.checks import Number, Whole
from origami_lab.config.amounts import Amount, Reach
from origami_lab.config.node import OF_STAGES, Node
from origami_lab.errors import InputError

GOES_ON = tuple(key for key in OF_STAGES if key != "stages")
"""Settings that another stage may change."""
Minutes = Annotated[float | None, Number(0, math.inf, "must be minutes above 0, or null", between=True)]
Budget = Annotated[int, Whole(1, 10**12)]


@dataclass(frozen=True)
class Stage:
    """What ends a stage of a trial's search; all of it counts from the trial's beginning."""

    budget: Budget
    """Interactions."""
    target_return: Annotated[Amount | None, Reach()] = None
    minutes: Minutes = None

    def to_node(self) -> dict[str, Any]:
        """As a configuration has it."""
        said = None if self.target_return is None else self.target_return.said
        return {"budget": self.budget, "target_return": said, "minutes": self.minutes}


def is_other_stage(before: Node, now: Node) -> bool:
    """Whether a configuration asks for another stage than one before."""
    return any(before.get(key) != now.get(key) for key in GOES_ON)


def stage_node(config: Node) -> dict[str, Any]:
    """The stage that a configuration asks for."""
    return {key: config.get(key) for key in GOES_ON}


def check_larger(before: Node, now: Node) -> None:
    """Raise InputError where a run that goes on would be given less than it had."""
    old, new = (config.get("budget") for config in (before, now))
    if isinstance(old, int | float) and isinstance(new, int | float) and new < old:
        expected = f"was {int(old):,} when the run in this folder was started: it goes on with that, or with more"
        raise InputError("budget", int(new), expected)


def known_stages(config: Mapping[str, Any]) -> list[Any]:
    """The stages before the present one, as a configuration has them."""
    found = config.get("stages")
    return list(found) if isinstance(found, list | tuple) else []
