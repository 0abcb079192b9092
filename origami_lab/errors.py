"""The one exception that means "what you asked for cannot be done as written"."""

from __future__ import annotations

from origami_lab.text import one_line, shorten

EXIT_OK, EXIT_FAILED, EXIT_INPUT, EXIT_INTERRUPTED = 0, 1, 2, 130
"""Exit codes of the command: done; a trial failed, or it broke; wrong input, in one line; interrupted."""


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
        super().__init__(one_line(f"{shorten(field)}={shorten(value)}: {expected}"))

    def __reduce__(self) -> tuple[type[InputError], tuple[str, object, str]]:
        return type(self), (self.field, self.value, self.expected)
