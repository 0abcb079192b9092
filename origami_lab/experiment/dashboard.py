"""`origami-lab dashboard`: the MLflow user interface, on the right store and light enough for a laptop."""

from __future__ import annotations

import os
import signal
import socket
import subprocess
import sys
import time
from collections.abc import Callable
from pathlib import Path

from origami_lab.errors import InputError
from origami_lab.experiment.tracking import DEFAULT_STORE

LIGHT = {
    "MLFLOW_DISABLE_TELEMETRY": "true",
    "MLFLOW_SERVER_ENABLE_JOB_EXECUTION": "false",
    "PYTHONWARNINGS": "ignore",
}


def find_store(uri: str | None, directory: Path) -> str:
    """The URI of the store to show.

    Parameters
    ----------
    uri
        As given; None for the SQLite store of ``directory``.
    directory
        A working directory, or a folder below one: the store is looked for there and upwards.

    Raises
    ------
    InputError
        If the store does not exist.
    """
    if uri is not None:
        database = Path(uri.removeprefix("sqlite:///"))
        if uri.startswith("sqlite:///") and not database.is_file():
            raise InputError("--uri", uri, "there is no such file")
        return uri
    directory = directory.absolute()
    for place in (directory, *directory.parents):
        for database in (place / DEFAULT_STORE, place / DEFAULT_STORE.name):
            if database.is_file():
                return f"sqlite:///{database}"
    raise InputError(
        "directory", directory, f"there is no {DEFAULT_STORE} in it; run an experiment first, or give --uri"
    )


def check_port(host: str, port: int) -> None:
    """Raise InputError if the port cannot be bound."""
    if not 1 <= port <= 65535:
        raise InputError("--port", port, "must be a port from 1 to 65535")
    try:
        with socket.socket() as probe:
            probe.setsockopt(socket.SOL_SOCKET, socket.SO_REUSEADDR, 1)
            probe.bind((host, port))
    except OSError as error:
        raise InputError("--port", port, f"cannot be used on {host} ({error.strerror or error})") from error


def serve_dashboard(store: str, host: str, port: int, say: Callable[[str], None]) -> int:
    """Run the server until Ctrl-C and say when it answers; returns the exit code."""
    command = [sys.executable, "-m", "mlflow", "server", "--backend-store-uri", store]
    command += [
        "--host",
        host,
        "--port",
        str(port),
        "--workers",
        "1",
        "--uvicorn-opts",
        "--log-level warning",
    ]
    if store.startswith("sqlite:///"):
        root = Path(store.removeprefix("sqlite:///")).parent / "mlartifacts"
        command += ["--default-artifact-root", root.as_uri()]
    # a session of its own: Ctrl-C reaches us only, and we end all of it
    server = subprocess.Popen(command, env={**os.environ, **LIGHT}, start_new_session=True)
    before = signal.signal(signal.SIGTERM, signal.default_int_handler)
    try:
        while server.poll() is None and not _answers(host, port):
            time.sleep(0.2)
        if server.poll() is None:
            say(f"http://{host}:{port}  (Ctrl-C ends it)")
        return server.wait()
    except KeyboardInterrupt:
        _end(server)
        return 0
    finally:
        signal.signal(signal.SIGTERM, before)


def _answers(host: str, port: int) -> bool:
    try:
        with socket.create_connection((host, port), timeout=1.0):
            return True
    except OSError:
        return False


def _end(server: subprocess.Popen[bytes]) -> None:
    for number, patience in ((signal.SIGTERM, 5.0), (signal.SIGKILL, 5.0)):
        try:
            os.killpg(server.pid, number)
            server.wait(patience)
            return
        except ProcessLookupError:
            return
        except subprocess.TimeoutExpired:
            continue
