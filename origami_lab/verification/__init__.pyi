"""Public names, and the modules that they live in; each is imported when it is first used."""

from .certificate import Certificate, Check
from .verify_design import verify

__all__ = [
    "Certificate",
    "Check",
    "verify",
]
