"""`origami-lab report`: tables, curves and pictures of many runs, from what is on disk."""

from __future__ import annotations

import math
import sys
from collections.abc import Sequence
from pathlib import Path

from origami_lab.commands import number
from origami_lab.commands.parser import Parser
from origami_lab.errors import InputError


def main(arguments: Sequence[str]) -> int:
    """Write the report and say where it is; returns the exit code."""
    parser = Parser(
        "origami-lab report",
        description="Compare runs: tables of returns and interactions, learning curves, a gallery, on one page.",
    )
    parser.add_argument(
        "directories", nargs="+", metavar="DIR", help="a run's folder, or one that holds some at any depth"
    )
    parser.add_argument("--output", metavar="DIR", help="where to write (default: report in the first DIR)")
    parser.add_argument(
        "--beside",
        metavar="FILE",
        help="a CSV file of values to print beside ours (columns task,method,table,mean,std,source), or: paper",
    )
    parser.add_argument(
        "--solved",
        metavar="RETURN",
        help="the return at which a trial counts as solved (default: within 1 %% or 0.001 of the task's best)",
    )
    options = parser.parse_args(arguments)
    solved = number("--solved", options.solved)
    if solved is not None and not math.isfinite(solved):
        raise InputError("--solved", options.solved, "must be a return, a number")
    from origami_lab.report.known_values import read_beside
    from origami_lab.report.report_builder import build_report

    report = build_report(
        [Path(name) for name in options.directories],
        None if options.output is None else Path(options.output),
        None if options.beside is None else read_beside(options.beside),
        solved,
        lambda line: print(line, flush=True),
    )
    for note in report.notes:
        print(f"note: {note.shown()}", file=sys.stderr)
    print(report)
    return 0
