"""The one exception that means "what you asked for cannot be done as written", exit codes, and errors of ours."""

from __future__ import annotations

import os
import tempfile

from origami_lab.addresses import hidden
from origami_lab.text import first_line, one_line, shorten

EXIT_OK, EXIT_FAILED, EXIT_INPUT, EXIT_INTERNAL, EXIT_INTERRUPTED = 0, 1, 2, 70, 130
"""Exit codes of the command: done; a trial failed; wrong input, in one line; an error of ours; interrupted."""


class InputError(ValueError):
    """A setting or a file is wrong; the message says which, what it was, and what would be right.

    The command line prints the message on one line and exits with code 2.

    Parameters
    ----------
    field
        The name of the setting as the user writes it, e.g. ``board.size``.
    value
        What was given.
    expected
        What would be right, as the end of the sentence "... must be".
    """

    def __init__(self, field: str, value: object, expected: str) -> None:
        self.field, self.value, self.expected = field, value, expected
        key, given = shorten(field), hidden(str(value))
        if key.endswith(("uri", "storage")):
            given = given.partition("?")[0]
        short = shorten(given)
        said = expected if short == given else expected.replace(given, short)  # hints repeat what was typed
        super().__init__(one_line(hidden(f"{key}={short}: {said}")))

    def __reduce__(self) -> tuple[type[InputError], tuple[str, object, str]]:
        return type(self), (self.field, self.value, self.expected)


def internal_error(name: str, message: str, traceback: str) -> str:
    """One line about an error that nobody foresaw; its traceback is kept in a temporary file, which the line names.

    Parameters
    ----------
    name, message
        The error's class, and what it says.
    """
    try:
        descriptor, file = tempfile.mkstemp(prefix="origami-lab-error-", suffix=".txt")
        with os.fdopen(descriptor, "w", encoding="utf-8", errors="backslashreplace") as stream:
            stream.write(traceback)
        where = f"traceback in {file}"
    except OSError:  # no temporary files here
        where = "HYDRA_FULL_ERROR=1 in the environment shows its traceback"
    said = first_line(message) if message.strip() else ""
    return f"internal error: {one_line(shorten(f'{name}: {said}'.rstrip(': '), 500))}; {where}"
