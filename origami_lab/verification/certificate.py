"""What a verification says: a verdict, a reason in one line, and each check with its numbers."""

from __future__ import annotations

import json
import math
from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Any

CERTIFIED, REFUTED, UNDECIDED = "certified", "refuted", "not certifiable"
OK, WRONG, OPEN, FACT = "ok", "refuted", "not decidable", "fact"
_CODES = {CERTIFIED: 0, REFUTED: 1, UNDECIDED: 3}


@dataclass(frozen=True)
class Check:
    """One thing that was checked."""

    name: str
    status: str
    """``ok``, ``refuted``, ``not decidable``, or ``fact`` for what decides nothing."""
    text: str
    numbers: Mapping[str, Any] = field(default_factory=dict)
    """Plain JSON values; angles in degrees, lengths in the file's units."""
    panels: tuple[int, int] | None = None
    """The two panels that are the reason, numbered as in ``faces_vertices``."""
    angle: float | None = None
    """The driving angle at which, degrees."""


@dataclass(frozen=True)
class Certificate:
    """The outcome of a verification."""

    name: str
    """The file, or what the design is called."""
    checks: tuple[Check, ...]
    remarks: tuple[str, ...] = ()
    """What was assumed, turned or passed over when the file was read, a line each."""

    @property
    def _deciding(self) -> Check | None:
        for status in (WRONG, OPEN):
            for check in self.checks:
                if check.status == status:
                    return check
        return None

    @property
    def verdict(self) -> str:
        """``certified``, ``refuted`` or ``not certifiable``."""
        check = self._deciding
        return CERTIFIED if check is None else REFUTED if check.status == WRONG else UNDECIDED

    @property
    def reason(self) -> str:
        """Why, in one line."""
        check = self._deciding
        if check is not None:
            return f"{check.name}: {check.text}"
        return self["crossing"].text if self.has("crossing") else ""

    @property
    def panels(self) -> tuple[int, int] | None:
        """The two panels that refute the design, if it is two panels."""
        return self._deciding.panels if self._deciding else None

    @property
    def angle(self) -> float | None:
        """The driving angle at which they do, degrees."""
        return self._deciding.angle if self._deciding else None

    @property
    def exit_code(self) -> int:
        """0 certified, 1 refuted, 3 not certifiable."""
        return _CODES[self.verdict]

    def has(self, name: str) -> bool:
        """Whether a check of that name was made."""
        return any(check.name == name for check in self.checks)

    def __getitem__(self, name: str) -> Check:
        """The check of that name."""
        return next(check for check in self.checks if check.name == name)

    def to_json(self) -> dict[str, Any]:
        """The certificate as a JSON object."""
        return {
            "file": self.name,
            "verdict": self.verdict,
            "reason": self.reason,
            "panels": None if self.panels is None else list(self.panels),
            "angle": self.angle,
            "remarks": list(self.remarks),
            "checks": [
                {"name": check.name, "status": check.status, "text": check.text, **_plain(check.numbers)}
                | ({} if check.panels is None else {"panels": list(check.panels)})
                | ({} if check.angle is None else {"angle": check.angle})
                for check in self.checks
            ],
        }

    def json_text(self) -> str:
        """:meth:`to_json` as text."""
        return json.dumps(self.to_json(), indent=1, allow_nan=False, ensure_ascii=False) + "\n"

    def words(self) -> str:
        """The certificate for people: the reason on top, then a line a check."""
        width = max(len(check.name) for check in self.checks)
        wide = max(len(check.status) for check in self.checks)
        lines = [f"{check.status:<{wide}}  {check.name:<{width}}  {check.text}" for check in self.checks]
        return "\n".join([f"{self.verdict}: {self.reason}", "", *lines]) + "\n"


def degrees(angle: float) -> str:
    """Radians as degrees for a text."""
    return f"{math.degrees(angle):.4f}".rstrip("0").rstrip(".") + "°"


def _plain(value: Any) -> Any:
    """``value`` as JSON has it; numbers that are not finite become null."""
    if isinstance(value, Mapping):
        return {str(key): _plain(item) for key, item in value.items()}
    if isinstance(value, list | tuple):
        return [_plain(item) for item in value]
    if isinstance(value, float):
        return value if math.isfinite(value) else None
    return value
