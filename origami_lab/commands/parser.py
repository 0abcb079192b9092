"""The parser of all subcommands' arguments."""

from __future__ import annotations

import argparse
from typing import NoReturn

from origami_lab.addresses import hidden
from origami_lab.text import one_line


class Parser(argparse.ArgumentParser):
    """argparse's own, which quotes what it does not know: without secrets and without control characters."""

    def error(self, message: str) -> NoReturn:
        super().error(one_line(hidden(message)))
