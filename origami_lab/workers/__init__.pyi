"""Public names, and the modules that they live in; each is imported when it is first used."""

from .call_limit import CallLimit, Calls
from .interrupts import Interrupts

__all__ = [
    "CallLimit",
    "Calls",
    "Interrupts",
]
