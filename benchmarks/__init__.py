"""Measurements, run by hand; see README.md here."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path


def write_report(lines: Sequence[str], file: Path | None) -> None:
    """Write a report as text that ends with one newline; without a file, nowhere."""
    if file is not None:
        file.write_text("\n".join(lines).rstrip() + "\n", encoding="utf-8")
