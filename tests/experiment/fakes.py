"""Parts that a user might bring: named by ``_target_`` in the tests' configurations."""

from __future__ import annotations

import math
import os
from pathlib import Path


class Height:
    """The height of the highest folded point."""

    def score(self, sheet: object) -> float:
        points = sheet.points[sheet.reach - 1]  # type: ignore[attr-defined]
        return float(points[:, 2].max())


class Beacon(Height):
    """Creates a file when it is first asked, so that a test knows that a trial is under way."""

    def __init__(self, file: str) -> None:
        self.file = Path(file)

    def score(self, sheet: object) -> float:
        self.file.touch()
        return super().score(sheet)


class Broken:
    """Fails in one way or another."""

    def __init__(self, how: str) -> None:
        self.how = how

    def score(self, sheet: object) -> float:
        if self.how == "raises":
            raise RuntimeError("the kettle is empty\nsecond line")
        if self.how == "not a number":
            return math.nan
        os._exit(3)


class NoObjective:
    """Has no score."""


class NoSearcher:
    """Has no search."""
