"""The subcommands, one module each with ``main(arguments) -> exit code``; imported when called, to start fast."""

from __future__ import annotations

from origami_lab.errors import InputError

COMMANDS = {
    "check": ("check part.stl", "what a part is, how it will lie, and the command to run"),
    "dashboard": ("dashboard", "compare the runs in MLflow"),
    "report": ("report DIR ...", "pictures, tables and curves of all runs below, on one page"),
    "sweep": ("sweep sweeps/evo_bowl.yaml", "tune a searcher: an Optuna study in one YAML file"),
    "polish": ("polish DIR", "move the best designs of a run off the grid, nearer to their target"),
    "simplify": ("simplify DIR", "take out the creases that a design does not need"),
    "verify": ("verify FILE.fold", "a certificate for a design, or what is wrong with it"),
    "export": ("export FILE.fold --to FORMAT", "svg, dxf, cp, stl, glb, html, a sheet to cut ..."),
    "studio": ("studio", "design by hand in the browser, with searchers as partners"),
    "doctor": ("doctor", "what may keep experiments from running here"),
}
"""What is typed, and what it does, by the name of the module."""


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
