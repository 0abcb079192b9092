"""The studio as a person meets it: its command in a process of its own, and its page in Chromium."""

from __future__ import annotations

import json
import os
import re
import shutil
import signal
import subprocess
import sys
import time
from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager
from pathlib import Path
from typing import Any

from origami_lab.game.moves import Extend, Move, Place, Point, Source

ROOT = Path(__file__).parents[2]
CHROMIUM = next(filter(None, map(shutil.which, ("chromium", "chromium-browser", "google-chrome"))), None)
FLAGS = ["--no-sandbox", "--use-gl=angle", "--use-angle=swiftshader", "--enable-unsafe-swiftshader", "--disable-quic"]
SECONDS = 60.0
"""How long anything may take on a busy machine."""
FIRST_SECONDS = 300.0
"""The same for a design that is opened, and the first order to a partner: on a new installation they compile."""
HARMLESS = ("GL Driver Message", "GPU stall")
"""Remarks of the software renderer."""


class Server:
    """A studio that runs."""

    def __init__(self, process: subprocess.Popen[str], address: str, log: Path) -> None:
        self.process, self.address, self._log = process, address, log
        self.folder = log.parent
        self.port = int(re.findall(r":(\d+)/", address)[0])
        self.token = address.rstrip("/").rpartition("/")[2]

    @property
    def log(self) -> str:
        """What it has printed, but for the line with its address."""
        lines = self._log.read_text(encoding="utf-8").splitlines()
        return "\n".join(line for line in lines if not line.startswith("the studio: "))


@contextmanager
def studio(folder: Path, *words: str, name: str = "studio") -> Iterator[Server]:
    """The command, until the block ends; designs are saved below ``folder``/out unless the words say otherwise."""
    log = folder / f"{name}.log"
    output = [] if any(word.startswith("output=") for word in words) else [f"output={folder / 'out'}"]
    command = [sys.executable, "-m", "origami_lab", "studio", "--no-open", "--port", "0", *words, *output]
    environment = {**os.environ, "PYTHONPATH": str(ROOT), "PYTHONUNBUFFERED": "1"}
    with log.open("w", encoding="utf-8") as stream:
        process = subprocess.Popen(
            command, cwd=folder, env=environment, stdout=stream, stderr=subprocess.STDOUT, text=True
        )
        try:
            address = wait_for(lambda: _address(log, process))
            yield Server(process, address, log)
        finally:
            if process.poll() is None:
                process.send_signal(signal.SIGINT)
                try:
                    process.wait(20)
                except subprocess.TimeoutExpired:
                    process.kill()
                    process.wait()


def _address(log: Path, process: subprocess.Popen[str]) -> str | None:
    text = log.read_text(encoding="utf-8")
    assert process.poll() is None, text
    found = re.findall(r"the studio: (\S+)", text)
    return found[0] if found else None


def wait_for(what: Callable[[], Any], seconds: float = SECONDS) -> Any:
    """What comes of a call, once it is something."""
    end = time.monotonic() + seconds
    while time.monotonic() < end:
        if found := what():
            return found
        time.sleep(0.02)
    raise AssertionError("it did not come to be")


class Page:
    """A tab with the studio's page, driven by its buttons, keys and points of the board.

    Parameters
    ----------
    tab
        Playwright's page.
    """

    def __init__(self, tab: Any, address: str) -> None:
        self.tab, self.errors = tab, list[str]()
        tab.on("console", self._heard)
        tab.on("pageerror", lambda error: self.errors.append(str(error)))
        tab.goto(address)

    def _heard(self, message: Any) -> None:
        if message.type in ("error", "warning") and not any(words in message.text for words in HARMLESS):
            self.errors.append(message.text)

    def begin(self, task: str) -> None:
        """Choose a task of the gallery."""
        self.tab.click(f"[data-open={task}]")
        self.is_open()

    def is_open(self) -> None:
        self.tab.wait_for_selector("#studio:not([hidden]) #board svg.over", timeout=1000 * FIRST_SECONDS)

    def where(self, at: Point) -> tuple[float, float]:
        """The place of a board point on the page."""
        x, y = self.tab.evaluate(f"studioWhere({list(at)})")
        return x, y

    def point(self, at: Point) -> None:
        self.tab.mouse.move(*self.where(at))

    def click(self, at: Point) -> None:
        """Choose a board point, and wait for the answer."""
        with self.answered():
            self.tab.mouse.click(*self.where(at))

    @contextmanager
    def answered(self) -> Iterator[None]:
        """Wait until the page was told something new of the board, or refused."""
        before = self.tab.evaluate("studioTold()")
        yield
        wait_for(lambda: self.tab.evaluate("studioTold()") > before)

    def says(self, element: str, words: str) -> str:
        """The text of an element, once it has these words in it."""
        wait_for(lambda: words in self.text(element))
        return self.text(element)

    def press(self, button: str) -> None:
        """Press a button, by its id, and wait for the answer."""
        with self.answered():
            self.tab.click(f"#{button}")

    def turn(self, sign: int) -> None:
        self.tab.click(f"[data-sign='{sign}']")

    def use(self, tool: str) -> None:
        self.tab.click(f"[data-tool={tool}]")

    def text(self, element: str) -> str:
        return str(self.tab.inner_text(f"#{element}"))

    def value(self) -> float:
        """The return that is shown."""
        return float(self.text("fact-return").partition(" ")[0].replace("−", "-"))

    def play(self, moves: Sequence[Move]) -> None:
        """Play moves by clicks, in a game whose start pattern is a square of a size to be chosen or given."""
        for move in moves:
            if isinstance(move, Place):
                if self.state()["phase"] == "start":
                    self.turn(move.sign)
                    self.click((move.value, move.value))
            elif isinstance(move, Source):
                self.turn(move.sign)
                self.use("source")
                self.click(move.leaf)
                self.use("play")
            elif isinstance(move, Extend):
                self.turn(move.mode)
                self.click(move.leaf)
                self.click(move.a)
                if self.state()["phase"] == "second":
                    self.click(move.b)
                self.click(move.c)

    def state(self) -> dict[str, Any]:
        """What the page was told of the board last."""
        found: dict[str, Any] = self.tab.evaluate("studioState()")
        return found


def browser_page(browser: Any, **settings: Any) -> Any:
    """A tab without anything of other tabs."""
    return browser.new_context(**settings).new_page()


def read(path: Path) -> Any:
    return json.loads(path.read_text(encoding="utf-8"))
