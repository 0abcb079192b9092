"""`origami-lab dashboard`: the MLflow user interface, on the right store and light enough for a laptop."""

from __future__ import annotations

import json
import os
import signal
import socket
import sqlite3
import subprocess
import sys
import tempfile
import time
from collections.abc import Callable, Mapping
from contextlib import suppress
from pathlib import Path
from typing import Any
from urllib.request import Request, urlopen

from origami_lab.addresses import hidden, whole
from origami_lab.caches import homeless
from origami_lab.errors import InputError
from origami_lab.tracking.moved_store import ARTIFACTS, take_along
from origami_lab.tracking.shown_view import TAG, address
from origami_lab.tracking.store import (
    DEFAULT_STORE,
    LOCK_SECONDS,
    QUIET,
    StoreError,
    cause_of,
    check_store,
    probe,
    shown,
    sqlite_file,
)

ANSWER_SECONDS = 10
MOST_EXPERIMENTS = 1000
"""Experiments among which the newest run is looked for."""
ENDING = (signal.SIGINT, signal.SIGTERM)

LIGHT = {**QUIET, "MLFLOW_SERVER_ENABLE_JOB_EXECUTION": "false", "PYTHONWARNINGS": "ignore", "PYTHONSAFEPATH": "1"}
"""Environment of the server."""


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
        check_store(uri, "--uri")
        database = sqlite_file(uri)
        if database is not None and not database.is_file():
            raise InputError("--uri", uri, "there is no such file")
        return uri
    directory = directory.absolute()
    for place in (directory, *directory.parents):
        for database in (place / DEFAULT_STORE, place / DEFAULT_STORE.name):
            if database.is_file():
                found = f"sqlite:///{database}"
                check_store(found, "directory")
                return found
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


def newest_page(base: str) -> str:
    """Where a server shows the experiment of the newest run; its first page if that cannot be found out."""
    try:
        experiments = _asked(base, "experiments/search", {"max_results": MOST_EXPERIMENTS})["experiments"]
        ids = [str(experiment["experiment_id"]) for experiment in experiments]
        found = _asked(
            base, "runs/search", {"experiment_ids": ids, "max_results": 1, "order_by": ["attributes.start_time DESC"]}
        )
        experiment = str(found["runs"][0]["info"]["experiment_id"])
        tags = next(e.get("tags", []) for e in experiments if str(e["experiment_id"]) == experiment)
    except (OSError, ValueError, KeyError, IndexError, TypeError, StopIteration):
        return ""
    known = any(tag.get("key") == TAG for tag in tags)
    return address(experiment) if known else f"/#/experiments/{experiment}/runs"


def _asked(base: str, what: str, question: Mapping[str, object]) -> Any:
    """The answer of a server's interface; raises OSError or ValueError if there is none."""
    request = Request(
        f"{base}/api/2.0/mlflow/{what}", json.dumps(question).encode(), {"Content-Type": "application/json"}
    )
    with urlopen(request, timeout=ANSWER_SECONDS) as answer:
        return json.load(answer)


def serve_dashboard(
    store: str,
    host: str,
    port: int,
    say: Callable[[str], None],
    opens: Callable[[str], None] | None = None,
) -> tuple[int, str | None]:
    """Run the server until Ctrl-C and say when it answers, and where it shows the newest run.

    Parameters
    ----------
    opens
        Is given the address, too.

    Returns
    -------
    The exit code, and in one line why the server ended if it did so by itself.
    """
    try:
        probe(store)
    except StoreError as error:
        return 1, str(error)
    command = [sys.executable, "-m", "mlflow", "server"]
    environment = {**os.environ, **homeless(), **LIGHT}
    environment["MLFLOW_BACKEND_STORE_URI"] = whole(store)  # not in the command, which all can see
    command += ["--host", host, "--port", str(port), "--workers", "1", "--uvicorn-opts", "--log-level warning"]
    if (file := sqlite_file(store)) is not None:
        with suppress(sqlite3.Error):  # one that can only be read is shown as it is
            take_along(file, LOCK_SECONDS)
        command += ["--default-artifact-root", (file.absolute().parent / ARTIFACTS).as_uri()]
    with tempfile.TemporaryFile("w+", encoding="utf-8", errors="replace") as output:
        # a session of its own: Ctrl-C reaches us only, and we end all of it
        server = subprocess.Popen(
            command,
            env=environment,
            stdout=output,
            stderr=output,
            start_new_session=True,
        )
        before = {number: signal.signal(number, signal.default_int_handler) for number in ENDING}
        try:
            while server.poll() is None and not _answers(host, port):
                time.sleep(0.2)
            if server.poll() is None:
                base = f"http://{host}:{port}"
                page = newest_page(base)
                say(f"{base}{page}  (Ctrl-C ends it)")
                if opens:
                    opens(f"{base}{page}")
            code = server.wait()
            output.seek(0)
            return code or 1, _reason(output.read(), store)
        except KeyboardInterrupt:
            return 0, None
        finally:
            _end(server)
            for number, handler in before.items():
                signal.signal(number, handler)


def _reason(output: str, store: str) -> str:
    """Why the server ended, from what it printed."""
    if cause := cause_of(output, store):
        return f"{shown(store)} {cause}"
    lines = [line.strip() for line in output.splitlines() if line.strip()]
    return hidden(f"MLflow's server ended{': ' + lines[-1] if lines else ''}")[:300]


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
