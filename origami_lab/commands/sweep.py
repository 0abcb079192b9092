"""`origami-lab sweep`: tune a searcher by an Optuna study that one YAML file declares."""

from __future__ import annotations

import argparse
import sys
from collections.abc import Sequence
from pathlib import Path

from origami_lab.commands.parser import Parser
from origami_lab.errors import EXIT_FAILED
from origami_lab.file_names import PAGE
from origami_lab.files import expanded

EPILOG = """\
The same command goes on where a sweep was interrupted; given on several machines with one storage=URL, all play the
same study. Keys of the file may be set after it: trials=100 workers=2 sampler.seed=1 output=DIR tracking=none
storage=postgresql://USER@HOST/NAME. See docs/sweeps.md."""


def main(arguments: Sequence[str]) -> int:
    """Run a sweep to its end, or go on with it; returns the exit code."""
    parser = Parser(
        "origami-lab sweep",
        description="Tune a searcher: one Optuna study, declared in a YAML file.",
        epilog=EPILOG,
        formatter_class=argparse.RawDescriptionHelpFormatter,
    )
    parser.add_argument("file", metavar="FILE", help="the sweep's YAML file, e.g. sweeps/evo_bowl.yaml")
    parser.add_argument("changes", nargs="*", default=[], metavar="KEY=VALUE", help="what is other than in the file")
    parser.add_argument("--quiet", action="store_true", help="say nothing but warnings and errors")
    options = parser.parse_intermixed_args(arguments)
    from rich.console import Console

    from origami_lab.config.compose import working_directory_importable
    from origami_lab.sweep.findings_table import show_findings
    from origami_lab.sweep.storage import StorageError
    from origami_lab.sweep.sweep_config import read_declaration
    from origami_lab.sweep.sweep_runner import run_sweep
    from origami_lab.sweep.tracking import store_of_study
    from origami_lab.tracking.store import how_to_look

    declaration = read_declaration(find_file(options.file), options.changes)
    try:
        with working_directory_importable():
            console = Console(stderr=True)
            sweep = run_sweep(declaration, console, ["origami-lab", "sweep", *arguments], options.quiet)
    except StorageError as error:
        print(f"error: {error}", file=sys.stderr)
        return EXIT_FAILED
    if sweep.summary and not options.quiet:
        show_findings(Console(), sweep.summary)
        if declaration.tracking.kind == "mlflow":
            print(f"to compare its trials: {how_to_look(store_of_study(declaration))}")
        if (sweep.folder / PAGE).is_file():
            print(f"all of it: {sweep.folder / PAGE}")
    print(sweep.folder)
    return sweep.exit_code


def find_file(word: str) -> Path:
    """The file; one of those that come with the package, where there is none of that name here."""
    from origami_lab.config.option_files import config_dir

    file = expanded(word)
    if file.exists() or file.is_absolute() or file.parts[0] != "sweeps":
        return file
    shipped = config_dir().parent / file
    return shipped if shipped.is_file() else file
