"""`origami-lab dashboard`: the MLflow user interface on the right store, and pushing run folders to it."""

from __future__ import annotations

import sys
import webbrowser
from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING

from origami_lab.commands.parser import Parser

if TYPE_CHECKING:
    from origami_lab.tracking.mlflow_log import MlflowLog


def main(arguments: Sequence[str]) -> int:
    """Serve the store until Ctrl-C, or push run folders to theirs; returns the exit code."""
    parser = Parser("origami-lab dashboard", description="Open the results in MLflow's pages.")
    parser.add_argument("directory", nargs="?", default=".", help="where results/mlflow.db is (default: here)")
    parser.add_argument("--uri", help="any MLflow store instead, e.g. sqlite:///other.db")
    parser.add_argument("--host", default="127.0.0.1", help="address to listen on (default: this machine only)")
    parser.add_argument("--port", type=int, default=5000, help="port to listen on (default: 5000)")
    parser.add_argument("--open", action="store_true", help="open the newest run's experiment in a browser")
    parser.add_argument(
        "--sync",
        nargs="+",
        metavar="DIR",
        help="push what the store does not have yet of all runs at or below DIR, and serve nothing",
    )
    options = parser.parse_args(arguments)
    if options.sync:
        return on_disk([Path(name) for name in options.sync], options.uri)
    from origami_lab.tracking.mlflow_server import check_port, find_store, serve_dashboard
    from origami_lab.tracking.store import SERVERS, how_to_look, shown, sqlite_file

    directory = Path(options.directory)
    store = find_store(options.uri, directory)
    check_port(options.host, options.port)
    if store.startswith(SERVERS):
        print(f"the store is a server: {how_to_look(store)}")
        return 0
    file = sqlite_file(store)
    above = options.uri is None and file is not None and not file.is_relative_to(directory.absolute())
    where = f"; there is none in {directory.absolute()}" if above else ""
    print(f"starting MLflow on {shown(store)}{where} ...", flush=True)

    def opens(address: str) -> None:
        webbrowser.open(address)

    code, reason = serve_dashboard(
        store, options.host, options.port, lambda line: print(line, flush=True), opens if options.open else None
    )
    if reason:
        print(f"error: {reason}", file=sys.stderr)
    return code


def on_disk(directories: Sequence[Path], uri: str | None) -> int:
    from origami_lab.sweep.study_runs import StudyRuns
    from origami_lab.sweep.tracking import find_studies
    from origami_lab.tracking.experiment_runs import ExperimentRuns
    from origami_lab.tracking.store import how_to_look
    from origami_lab.tracking.sync import run_folders, sync_folders

    def say(line: str) -> None:
        print(line, flush=True)

    def complain(line: str) -> None:
        print(f"error: {line}", file=sys.stderr, flush=True)

    studies = [study for directory in directories for study in find_studies(directory)]
    folders: list[tuple[Path, type[MlflowLog]]] = [
        *((folder, ExperimentRuns) for folder in run_folders(directories, skip=studies)),
        *((study, StudyRuns) for study in studies),
    ]
    failed, stores = sync_folders(folders, uri, say, complain)
    for store in sorted(stores):
        print(f"to look at it: {how_to_look(store)}")
    return 1 if failed else 0
