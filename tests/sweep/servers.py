"""Servers on loopback, as several machines share them: PostgreSQL for the study, MLflow for its runs."""

from __future__ import annotations

import os
import shutil
import signal
import socket
import subprocess
import sys
import tempfile
import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from dataclasses import dataclass
from pathlib import Path
from urllib.request import urlopen

import pytest

from tests.sweep.conftest import wait_for

POSTGRES = Path("/usr/lib/postgresql")


@dataclass(frozen=True)
class Database:
    """A database server."""

    url: str
    restart: Callable[[], None]
    """Ends its connections, stops it, and starts it again after some seconds."""


@contextmanager
def postgres() -> Iterator[Database]:
    """A PostgreSQL server on loopback that is gone afterwards."""
    programs = sorted(POSTGRES.glob("*/bin"))
    pytest.importorskip("psycopg")
    if not programs or (os.getuid() == 0 and shutil.which("setpriv") is None):
        pytest.skip("PostgreSQL is not installed")
    # it refuses to run as root
    other = ["setpriv", "--reuid=nobody", "--regid=nogroup", "--clear-groups"] if os.getuid() == 0 else []
    folder = Path(tempfile.mkdtemp(prefix="postgres"))
    if other:
        shutil.chown(folder, "nobody", "nogroup")
    data, port = folder / "data", free_port()

    def run(program: str, *arguments: str) -> None:
        subprocess.run([*other, str(programs[-1] / program), *arguments], cwd=folder, check=True, capture_output=True)

    run("initdb", "-D", str(data), "-U", "sweeper", "--auth=trust", "--no-sync")
    options = f"-c listen_addresses=127.0.0.1 -c port={port} -c unix_socket_directories={folder} -c fsync=off"

    def start() -> None:
        run("pg_ctl", "-D", str(data), "-w", "-l", str(folder / "log"), "-o", options, "start")

    def restart() -> None:
        run("pg_ctl", "-D", str(data), "-m", "fast", "stop")
        time.sleep(3.0)
        start()

    start()
    try:
        yield Database(f"postgresql://sweeper@127.0.0.1:{port}/postgres", restart)
    finally:
        run("pg_ctl", "-D", str(data), "-m", "immediate", "stop")
        shutil.rmtree(folder)


@contextmanager
def mlflow_server(folder: Path) -> Iterator[str]:
    """The address of an MLflow server on loopback with its files in a folder."""
    port = free_port()
    store = ["--backend-store-uri", f"sqlite:///{folder}/server.db", "--artifacts-destination", str(folder / "art")]
    command = [sys.executable, "-m", "mlflow", "server", *store, "--host", "127.0.0.1", "--port", str(port)]
    process = subprocess.Popen(
        [*command, "--workers", "1"],
        stdout=subprocess.DEVNULL,
        stderr=subprocess.DEVNULL,
        start_new_session=True,
        env={**os.environ, "MLFLOW_DISABLE_TELEMETRY": "true", "MLFLOW_SERVER_ENABLE_JOB_EXECUTION": "false"},
    )
    address = f"http://127.0.0.1:{port}"
    try:
        wait_for(lambda: answers(address))
        yield address
    finally:
        os.killpg(process.pid, signal.SIGKILL)
        process.wait()


def free_port() -> int:
    with socket.socket() as found:
        found.bind(("127.0.0.1", 0))
        return int(found.getsockname()[1])


def answers(address: str) -> bool:
    try:
        urlopen(f"{address}/health", timeout=2).close()
    except OSError:
        return False
    return True
