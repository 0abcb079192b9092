"""`origami-lab dashboard`: the MLflow user interface on the right store."""

from __future__ import annotations

import argparse
from collections.abc import Sequence
from pathlib import Path


def main(arguments: Sequence[str]) -> int:
    """Serve the store until Ctrl-C; returns the exit code."""
    parser = argparse.ArgumentParser("origami-lab dashboard", description="Open the results in MLflow's pages.")
    parser.add_argument("directory", nargs="?", default=".", help="where results/mlflow.db is (default: here)")
    parser.add_argument("--uri", help="any MLflow store instead, e.g. sqlite:///other.db")
    parser.add_argument("--host", default="127.0.0.1", help="address to listen on (default: this machine only)")
    parser.add_argument("--port", type=int, default=5000, help="port to listen on (default: 5000)")
    try:
        options = parser.parse_args(arguments)
    except SystemExit as ended:
        return int(ended.code or 0)
    from origami_lab.experiment.dashboard import check_port, find_store, serve_dashboard

    store = find_store(options.uri, Path(options.directory))
    check_port(options.host, options.port)
    if store.startswith(("http:", "https:")):
        print(f"the store is a server: {store}")
        return 0
    print(f"starting MLflow on {store} ...", flush=True)
    return serve_dashboard(store, options.host, options.port, lambda line: print(line, flush=True))
