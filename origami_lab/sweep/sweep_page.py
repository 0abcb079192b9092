"""The page of a sweep: how far it is, its best settings, its trials, and at the end what the best is worth."""

from __future__ import annotations

import time
from collections.abc import Mapping, Sequence
from contextlib import suppress
from dataclasses import asdict
from pathlib import Path
from typing import TYPE_CHECKING, Any

from origami_lab.config.checked_values import shown
from origami_lab.runs.trial_row import spread_of
from origami_lab.sweep.studies import best_slot
from origami_lab.sweep.study_record import ended_trial
from origami_lab.sweep.summary import BEST, SUMMARY, SUMMARY_TEXT
from origami_lab.sweep.sweep_config import Declaration
from origami_lab.sweep.trial_queue import Slot
from origami_lab.text import command_text
from origami_lab.tracking.tracker import commands_to_look

if TYPE_CHECKING:
    from origami_lab.pages import PageFolder

EVERY_SECONDS = 2.0
FIGURES = ("history", "importance", "slices", "held_out")
FILES = (SUMMARY_TEXT, SUMMARY, BEST, "trials.csv", "study.json")


class SweepPage:
    """The page of one sweep. Nothing that goes wrong with it costs the sweep anything.

    Several machines may write the same one: each adds the trials in the order in which it hears of them, and the last
    one to end writes all anew.
    """

    def __init__(self, declaration: Declaration, command: Sequence[str]) -> None:
        self.declaration, self.command = declaration, command
        self._known: dict[int, Mapping[str, Any]] = {}
        self._page: PageFolder | None = None
        self._written = time.monotonic()

    def update(self, slots: Sequence[Slot]) -> None:
        """Take in how the study stands, and write the page if it is time to."""
        if time.monotonic() - self._written >= EVERY_SECONDS:
            self.write(slots, "running")

    def write(self, slots: Sequence[Slot], state: str, summary: Mapping[str, Any] | None = None) -> None:
        """Write the page as things stand; with a summary all of it anew."""
        self._written = time.monotonic()
        with suppress(OSError):
            if self._page is None or summary is not None:
                self._page, self._known = self._begun(), {}
            new = {slot.number: self._entry(slot) for slot in slots if slot.done and slot.number not in self._known}
            self._known |= new
            self._page.add([entry for _, entry in sorted(new.items())])
            self._page.say(self._live(slots, state, summary or {}))

    def _begun(self) -> PageFolder:
        from origami_lab.pages import PageFolder

        page = PageFolder(self.declaration.folder)
        page.begin(self._text())
        return page

    def _entry(self, slot: Slot) -> dict[str, Any]:
        trial = ended_trial(self.declaration, slot)
        spread = spread_of(trial["returns"].values())
        return {
            **{name: trial[name] for name in ("trial", "state", "reason")},
            "returns": None if spread is None else asdict(spread),
            "point": {name: shown(value) for name, value in trial["point"].items()},
            "seconds": round(trial["ended"] - trial["began"], 1),
        }

    def _live(self, slots: Sequence[Slot], state: str, summary: Mapping[str, Any]) -> dict[str, Any]:
        best, held_out = best_slot(slots), summary.get("held_out") or {}
        folder = self.declaration.folder
        return {
            "state": state,
            "at": round(1000 * time.time()),
            "trials": len(slots),
            "running": sum(slot.state == "running" for slot in slots),
            "best": None if best is None else self._known.get(best.number),
            "command": (summary.get("best") or {}).get("command"),
            "held_out": {
                "seeds": str(held_out.get("seeds", "")).replace(" ", ""),
                "budget": held_out.get("budget"),
                "settings": {
                    name: {"returns": {key: found[key] for key in ("mean", "std")} | {"n": len(found["returns"])}}
                    | {"difference": held_out["differences"].get(name)}
                    for name, found in held_out.get("settings", {}).items()
                },
            },
            "figures": [name for name in FIGURES if (folder / f"{name}.png").is_file()] if summary else [],
            "files": [name for name in FILES if (folder / name).is_file()],
        }

    def _text(self) -> str:
        from origami_lab.pages import page_text

        declared = self.declaration
        values = {
            "kind": "sweep",
            "study": declared.study,
            "task": " ".join(declared.base),
            "sampler": declared.sampler.name,
            "pruner": declared.pruner.name,
            "seeds": len(declared.seeds),
            "command": command_text(self.command),
            "look": commands_to_look(vars(declared.tracking), declared.folder),
            "space": [parameter.name for parameter in declared.space],
        }
        return page_text(
            __package__,
            "sweep_page.html.jinja",
            values,
            scripts=[Path(__file__).with_name("sweep_page.js")],
        )
