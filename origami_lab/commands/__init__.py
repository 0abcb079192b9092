"""The subcommands, one module each with ``main(arguments) -> exit code``; imported when called, to start fast."""

from __future__ import annotations

from origami_lab.errors import InputError

COMMANDS = ("check", "dashboard", "doctor", "export", "polish", "report", "simplify", "studio", "sweep", "verify")


def number(option: str, text: str | None) -> float | None:
    """An option's text as a number; whether it is a sane one is not asked here.

    Raises
    ------
    InputError
        If it is none. argparse would say so in three lines.
    """
    if text is None:
        return None
    try:
        return float(text)
    except ValueError:
        raise InputError(option, text, "must be a number") from None


def whole(option: str, text: str | None) -> int | None:
    """What was given for an option as a whole number from 0. Raises :class:`InputError` if it is none."""
    if text is None:
        return None
    if not text.isascii() or not text.isdigit() or len(text) > 9:
        raise InputError(option, text, "must be a whole number from 0")
    return int(text)
