"""`origami-lab doctor`: what may keep experiments from running here."""

from __future__ import annotations

import argparse
from collections.abc import Sequence
from pathlib import Path

from origami_lab.errors import EXIT_FAILED, EXIT_OK


def main(arguments: Sequence[str]) -> int:
    """Print one line a check; returns 1 if there is a problem, else 0."""
    description = "Check the installation, the machine, and the folder that experiments run in. Changes nothing."
    parser = argparse.ArgumentParser("origami-lab doctor", description=description)
    parser.add_argument("directory", nargs="?", default=".", help="where experiments are to run (default: here)")
    parser.add_argument("--uri", help="the MLflow store of tracking.uri (default: results/mlflow.db)")
    parser.add_argument("--json", action="store_true", help="for machines")
    options = parser.parse_args(arguments)
    from origami_lab.experiment.doctor import PROBLEM, as_json, examine

    checks = examine(Path(options.directory), options.uri)
    if options.json:
        print(as_json(checks))
    else:
        width = max(len(check.name) for check in checks)
        for check in checks:
            print(f"{check.status:<7}  {check.name:<{width}}  {check.text}")
    return EXIT_FAILED if any(check.status == PROBLEM for check in checks) else EXIT_OK
