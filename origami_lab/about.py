"""Version and folder of the package."""

from __future__ import annotations

from pathlib import Path

__version__ = "0.2.0"

PACKAGE = Path(__file__).resolve().parent
"""The folder of the installed package, or of the checkout's."""
