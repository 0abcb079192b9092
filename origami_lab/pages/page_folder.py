"""A page that is rewritten while something runs: ``index.html``, and beside it a folder of data in small pieces.

Pages that are opened from disk may not fetch JSON, but they may load scripts: each piece of data is one that calls a
function of the page. What has ended is in pieces of a fixed number of entries of which only the last one is written
again, so that an update costs the same however much has gone before.
"""

from __future__ import annotations

import re
from collections.abc import Mapping, Sequence
from contextlib import suppress
from pathlib import Path
from typing import Any

from origami_lab.file_names import PAGE, PAGE_DATA
from origami_lab.files import require_no_link, write_whole
from origami_lab.pages.templates import script_json

PIECE = 32
"""Entries in a piece."""
LIVE = "live.js"
_OURS = re.compile(r"live\.js|ended-\d+\.js|\.(live|ended-\d+)\.js\.\d+\.tmp")


class PageFolder:
    """The page in a folder, and its data. All methods raise ``OSError`` where they cannot write."""

    def __init__(self, folder: Path) -> None:
        self.folder = folder
        self.data = folder / PAGE_DATA
        self.ended = 0
        """Entries that were added."""
        self._piece: list[Any] = []

    def begin(self, page: str) -> None:
        """Write the page, and remove the data of an earlier one."""
        require_no_link(self.folder, PAGE_DATA).mkdir(exist_ok=True)
        for file in self.data.iterdir():
            if _OURS.fullmatch(file.name):
                with suppress(OSError):
                    file.unlink()
        self.ended, self._piece = 0, []
        write_whole(self.folder / PAGE, page)

    def add(self, entries: Sequence[Mapping[str, Any]]) -> None:
        """Add entries of what has ended, and write the pieces that they are in."""
        for entry in entries:
            if len(self._piece) == PIECE:
                self._piece = []
            self._piece.append(entry)
            self.ended += 1
            if len(self._piece) == PIECE or entry is entries[-1]:
                number = (self.ended - 1) // PIECE
                write_whole(self.data / f"ended-{number}.js", f"ended({number},{script_json(self._piece)});\n")

    def say(self, live: Mapping[str, Any]) -> None:
        """Write how things stand."""
        write_whole(self.data / LIVE, f"live({script_json({**live, 'ended': self.ended, 'piece': PIECE})});\n")
