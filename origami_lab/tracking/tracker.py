"""Tracking: a process of its own brings an MLflow store up to date with the run folder.

Everything is read from the run folder, where results are complete before the tracker hears of them, and nothing
here can hurt them: whatever MLflow does – hang, print, crash, use memory – happens in another process
(:mod:`.push_process`), and what goes wrong there is one warning. A later push adds what is missing.
"""

from __future__ import annotations

import json
import os
import subprocess
import sys
import threading
import time
from collections.abc import Callable, Sequence
from contextlib import suppress
from pathlib import Path
from typing import Protocol

from origami_lab.about import PACKAGE
from origami_lab.config.node import Node, flatten
from origami_lab.config.settings import Settings
from origami_lab.errors import InputError
from origami_lab.streams import open_descriptors
from origami_lab.text import command_text
from origami_lab.tracking.mlflow_limits import check_names
from origami_lab.tracking.moved_store import noted_store
from origami_lab.tracking.store import QUIET, absolute_uri, check_store, default_uri, how_to_look, shown

PATIENCE_SECONDS = 60.0
"""How long the end of an experiment waits for a slow store."""
SHORT_PATIENCE_SECONDS = 20.0
"""How long it waits for one that failed before: it gets one more chance."""
QUIET_SECONDS = 3.0
"""How long it waits without a word."""

PUSHER = "origami_lab.tracking.push_process"
"""The module that is run for an experiment."""

Say = Callable[[str], None]


class Tracker(Protocol):
    """Hears of results that are complete on disk. Never raises, never blocks for long."""

    def trial(self, number: int) -> None:
        """A trial ended, an experiment's of this seed or a sweep's of this number; its folder is complete."""
        ...

    def finish(self, *, patience: float = PATIENCE_SECONDS) -> None:
        """The experiment ended; all its files are complete. Waits ``patience`` seconds at most, or until Ctrl-C."""
        ...


class NullTracker:
    """Tracks nothing."""

    def trial(self, number: int) -> None: ...
    def finish(self, *, patience: float = PATIENCE_SECONDS) -> None: ...


def make_tracker(settings: Settings, folder: Path, say: Say) -> Tracker:
    """The tracker that the configuration asks for."""
    if settings.tracking.kind == "none":
        return NullTracker()
    return MlflowTracker(folder, store_of(settings, folder), say)


def check_tracking(settings: Settings) -> None:
    """Raise InputError if the store can never work, or take the configuration, before any work is done for it."""
    if settings.tracking.kind != "none":
        check_names(flatten(settings.config))
        check_store(store_of(settings, settings.output if settings.resume else None))


def store_of(settings: Settings, folder: Path | None) -> str:
    """The URI of the store: as configured, else where the run folder was tracked before, else the default one."""
    noted = None if folder is None else noted_store(folder)
    return str(settings.tracking.uri or noted or default_uri())


def commands_to_look(tracking: Node, folder: Path) -> list[str]:
    """What is typed to see in MLflow what a folder holds; what was not tracked is pushed there first.

    Parameters
    ----------
    tracking
        The configuration's section of that name.
    """
    if tracking.get("kind") == "none":
        return [command_text(["origami-lab", "dashboard", "--sync", str(folder)]), "origami-lab dashboard"]
    noted = None
    with suppress(InputError, OSError):  # a note that cannot be read is told of where the store is used
        noted = noted_store(folder)
    return [how_to_look(str(tracking.get("uri") or noted or default_uri()))]


class MlflowTracker:
    """Tells a process of its own that there is something to push, so that no store can hold up a trial.

    Parameters
    ----------
    pusher
        The module that is run as that process.
    later
        The command that pushes what was missed; None for ``dashboard --sync``.
    """

    def __init__(
        self, folder: Path, uri: str, say: Say, *, pusher: str = PUSHER, later: Sequence[str] | None = None
    ) -> None:
        self._folder, self._uri, self._say = folder, uri, say
        self._later = ["origami-lab", "dashboard", "--sync", str(folder)] if later is None else later
        self._ended, self._pushed = set[int](), set[int]()
        self._trouble = self._warned = self._done = False
        self._process: subprocess.Popen[str] | None = None
        open_descriptors()
        package = str(PACKAGE.parent)
        path = os.pathsep.join(filter(None, (package, os.environ.get("PYTHONPATH"))))
        # -P: nothing in the working directory is imported; a session of its own: Ctrl-C reaches us only
        command = [sys.executable, "-P", "-m", pusher, str(folder), absolute_uri(uri)]
        try:
            self._process = subprocess.Popen(
                command,
                stdin=subprocess.PIPE,
                stdout=subprocess.PIPE,
                stderr=subprocess.DEVNULL,
                text=True,
                env={**QUIET, **os.environ, "PYTHONPATH": path, "PYTHONWARNINGS": "ignore"},
                start_new_session=True,
            )
            self._listener = threading.Thread(target=self._listen, args=(self._process,), daemon=True, name="tracking")
            self._listener.start()
        except (OSError, RuntimeError) as error:  # no more processes, or no more threads
            if self._process is not None:
                self._process.kill()
                self._process = None
            self._warn(f"the process for MLflow could not be started ({error})")

    def trial(self, number: int) -> None:
        self._ended.add(number)
        self._tell(f"trial {number}")

    def finish(self, *, patience: float = PATIENCE_SECONDS) -> None:
        if self._process is None:
            return
        self._tell("end")
        if self._trouble:
            patience = min(patience, SHORT_PATIENCE_SECONDS)
        deadline = time.monotonic() + patience
        interrupted = False
        try:
            self._listener.join(min(QUIET_SECONDS, patience))
            if self._listener.is_alive() and patience > QUIET_SECONDS:
                self._say(f"writing to {shown(self._uri)} ... (Ctrl-C leaves it)")
                self._listener.join(max(deadline - time.monotonic(), 0.0))
        except KeyboardInterrupt:
            interrupted = True
        late = self._listener.is_alive()
        self._process.kill()
        code = self._process.wait()
        if late:
            why = "was left" if interrupted else f"did not take everything within {patience:.0f} s"
            self._warn(
                f"{shown(self._uri)} {why}, {len(self._ended & self._pushed)} of {len(self._ended)} trials are there"
            )
        elif not self._done:
            self._warn(f"the process for MLflow ended by itself (exit code {code})")
        elif self._warned and not self._trouble:
            self._say(f"tracking: {shown(self._uri)} has everything now")

    def _tell(self, word: str) -> None:
        if self._process is not None and self._process.stdin is not None:
            try:
                self._process.stdin.write(word + "\n")
                self._process.stdin.flush()
            except OSError:  # it died: finish says so
                pass

    def _listen(self, process: subprocess.Popen[str]) -> None:
        """Take in what the process says, until it ends."""
        assert process.stdout is not None
        for line in process.stdout:
            match json.loads(line):
                case {"pushed": int(number)}:
                    self._pushed.add(number)
                case {"trouble": str(reason)}:
                    self._trouble = True
                    self._warn(reason)
                case {"trouble": None}:
                    self._trouble = False
                case {"done": _}:
                    self._done = True

    def _warn(self, reason: str) -> None:
        if not self._warned:
            self._warned = True
            later = command_text(self._later)
            self._say(f"warning: tracking: {reason}; results are on disk; push them later with: {later}")
