"""MLflow stores: what a URI means, whether it can work at all, how it is opened, and its errors in plain words.

The checks do not import mlflow, which costs seconds.
"""

from __future__ import annotations

import logging
import os
import re
import shlex
import sqlite3
import warnings
from collections.abc import Iterator
from contextlib import closing, contextmanager
from importlib.metadata import entry_points
from pathlib import Path
from typing import TYPE_CHECKING
from urllib.error import HTTPError
from urllib.parse import urlsplit
from urllib.request import Request, urlopen

from origami_lab.addresses import hidden, whole, without_secrets
from origami_lab.caches import homeless
from origami_lab.errors import InputError
from origami_lab.files import replacing
from origami_lab.runs.run_folder import RESULTS
from origami_lab.tracking.mlflow_limits import artifact_folder
from origami_lab.tracking.moved_store import ARTIFACTS, take_along
from origami_lab.tracking.sqlite_address import why_not_shared

if TYPE_CHECKING:
    from mlflow import MlflowClient
    from mlflow.entities import Run

DEFAULT_STORE = RESULTS / "mlflow.db"
SERVERS = ("http", "https")
SCHEMES = (*SERVERS, "sqlite", "postgresql", "mysql", "mssql", "databricks", "databricks-uc", "uc")
ANSWER_SECONDS = 10
"""How long a server may take to answer one request."""
LOCK_SECONDS = 15.0
"""How long a database may be locked by somebody else."""
EXPECTED = "must be an MLflow store like http://HOST:5000 or sqlite:///FILE.db"

QUIET = {
    "MLFLOW_DISABLE_TELEMETRY": "true",
    "MLFLOW_SUPPRESS_PRINTING_URL_TO_STDOUT": "true",
    "MLFLOW_LOGGING_LEVEL": "ERROR",
    # no retries inside MLflow, which would create a run twice if an answer is lost: we look first, then try again
    "MLFLOW_HTTP_REQUEST_MAX_RETRIES": "0",
    "MLFLOW_HTTP_REQUEST_TIMEOUT": str(ANSWER_SECONDS),
    "GIT_PYTHON_REFRESH": "quiet",
}
"""Environment for MLflow: few words, and a dead server noticed in seconds, not after its default of minutes."""

CAUSES = (
    (r"connection refused", "does not answer (connection refused)"),
    (r"timed? ?out|timeout", "does not answer in time"),
    (r"name or service|name resolution|getaddrinfo|nodename nor", "cannot be found (unknown host name)"),
    (r"unreachable|no route to host", "cannot be reached"),
    (r"remotedisconnected|connection reset|connection aborted|closed connection|broken pipe", "broke the connection"),
    (r"error code 40[13]|HTTP Error 40[13]", "refuses access"),
    (r"error code 5\d\d|HTTP Error 5\d\d|too many 5\d\d", "answers with an internal error (HTTP 5xx)"),
    (r"<html|<!doctype|error code \d+|jsondecode|expecting value|parse response", "does not answer as MLflow does"),
    (r"database (table )?is locked", "is locked by another process"),
    (r"readonly database|read-only", "cannot be written (read-only)"),
    (r"not a database|image is malformed", "is damaged, or no SQLite database"),
    (r"out-of-date database schema|can't locate revision", "was made by another version of MLflow"),
    (r"unable to open|not a directory|permission denied|file exists", "cannot be opened or made (check its folder)"),
    (r"no space left|disk is full|disk i/o", "is on a disk that is full or fails"),
)
"""Patterns in the text of an error, and what they mean for the store."""


class StoreError(Exception):
    """A store cannot be used now. The message is a sentence about it, in plain words."""


class RefusedError(StoreError):
    """A store works, but does not take what it was given."""


def default_uri() -> str:
    """The store of the working directory."""
    return f"sqlite:///{DEFAULT_STORE.absolute()}"


def sqlite_file(uri: str) -> Path | None:
    """The file of an SQLite store; None for other stores."""
    return Path(uri.removeprefix("sqlite:///").partition("?")[0]) if uri.startswith("sqlite:///") else None


def absolute_uri(uri: str) -> str:
    """The same store, named from anywhere."""
    file = sqlite_file(uri)
    return uri if file is None or file.is_absolute() else uri.replace(str(file), str(file.absolute()), 1)


def from_here(uri: str) -> str:
    """The same store, named from the working directory if it is inside it."""
    file = sqlite_file(uri)
    inside = file is not None and file.is_absolute() and file.is_relative_to(Path.cwd())
    return uri.replace(str(file), str(file.relative_to(Path.cwd())), 1) if file is not None and inside else uri


def shown(uri: str) -> str:
    """The name of a store in messages, without passwords."""
    if (file := sqlite_file(uri)) is not None:
        inside = file.is_relative_to(Path.cwd())
        return f"the store {file.relative_to(Path.cwd()) if inside else file}"
    return ("the server " if uri.startswith(SERVERS) else "the store ") + hidden(without_secrets(uri))


def how_to_look(uri: str) -> str:
    """The way to look at a store: a command, or the address of a server."""
    if uri.startswith(SERVERS):
        return hidden(without_secrets(uri))
    uri = without_secrets(uri)
    return "origami-lab dashboard" if uri == default_uri() else f"origami-lab dashboard --uri {shlex.quote(uri)}"


def check_store(uri: object, field: str = "tracking.uri") -> None:
    """Raise InputError if a URI can never work: found out in milliseconds, and without the store's help."""
    try:
        parts = urlsplit(str(uri))
        port_is_wrong = parts.port == 0
    except ValueError as error:
        raise InputError(field, uri, f"{EXPECTED} ({str(error).lower()})") from error
    scheme = parts.scheme.partition("+")[0]
    if scheme not in ("", "file") and "://" not in str(uri):  # nothing would know its secrets from its host
        raise InputError(field, uri, EXPECTED)
    if not isinstance(uri, str) or scheme not in SCHEMES:
        plugins = {entry.name for entry in entry_points(group="mlflow.tracking_store")}
        files = scheme in ("", "file") and os.environ.get("MLFLOW_ALLOW_FILE_STORE") == "true"
        if not files and scheme not in plugins:
            raise InputError(field, uri, EXPECTED)
    elif scheme in SERVERS and (not parts.hostname or port_is_wrong):
        raise InputError(field, uri, EXPECTED)
    elif scheme == "sqlite":
        file = sqlite_file(uri)
        if file is None or not file.name:
            raise InputError(field, uri, "must name a file, sqlite:///FILE.db with three slashes")
        if file.is_dir():
            raise InputError(field, uri, "must name a file, and this is a folder")
        if why := why_not_shared(uri):
            raise InputError(field, uri, why)
        if file.is_file() and not file.name.startswith("file:"):
            _check_file(field, uri, file)


def _check_file(field: str, uri: str, file: Path) -> None:
    try:
        with file.open("rb") as stream:
            head = stream.read(16)
    except OSError:  # a store may be out of reach now and there later
        return
    if head != b"SQLite format 3\0":
        what = "an empty file" if not head else "no SQLite database"
        raise InputError(field, uri, f"must be a new file or an MLflow database, and this is {what}")


def probe(uri: str) -> None:
    """See whether a store answers now, without the help of mlflow.

    Raises
    ------
    StoreError
        If it does not: within ANSWER_SECONDS for a server, LOCK_SECONDS for a database file.
    """
    try:
        file = sqlite_file(uri)
        if uri.startswith(SERVERS):
            try:
                request = Request(without_secrets(uri).rstrip("/") + "/health")
                urlopen(request, timeout=ANSWER_SECONDS).close()
            except HTTPError as error:  # 404 and the like: it lives, and mlflow will say more
                if error.code >= 500:
                    raise
        elif file is not None and file.is_file():
            with closing(sqlite3.connect(file, timeout=LOCK_SECONDS)) as connection:
                connection.execute("BEGIN IMMEDIATE")
                connection.rollback()
    except (OSError, sqlite3.Error) as error:
        # certificates are checked by mlflow, which has settings for them
        if "CERTIFICATE" not in str(error):
            raise StoreError(explain(error, uri)) from error


def explain(error: Exception, uri: str) -> str:
    """Say in one line what is wrong, most often with the store; then it starts with its name."""
    if isinstance(error, StoreError | InputError):
        return str(error)
    return f"{shown(uri)} {cause_of(str(error), uri) or f'failed: {hidden(_first_line(error))}'}"


def cause_of(text: str, uri: str) -> str | None:
    """The common cause that a text of MLflow's, SQLAlchemy's or the system's stands for; None if there is none."""
    for pattern, meaning in CAUSES:
        if re.search(pattern, text, re.IGNORECASE):
            if "another version" in meaning:
                meaning += f" (after a backup: mlflow db upgrade {without_secrets(uri)})"
            return meaning
    return None


def _first_line(error: Exception) -> str:
    lines = [line.strip() for line in str(error).splitlines() if line.strip()]
    return f"{type(error).__name__}: {lines[0] if lines else ''}"[:300].rstrip(": ")


def open_client(uri: str) -> MlflowClient:
    """Connect to a store; a fresh SQLite one is made first, as a whole."""
    for name, value in QUIET.items():
        os.environ.setdefault(name, value)
    os.environ.update(homeless())
    for name in ("alembic", "mlflow", "urllib3"):
        logging.getLogger(name).setLevel(logging.ERROR)
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")
        from mlflow import MlflowClient

        file = sqlite_file(uri)
        if file is not None and not file.name.startswith("file:"):
            create_database(file)
            take_along(file, LOCK_SECONDS)
        return MlflowClient(tracking_uri=whole(uri))


def experiment_id(client: MlflowClient, uri: str, name: str) -> str:
    """The MLflow experiment of that name; it is made if there is none.

    Raises
    ------
    RefusedError
        If it was deleted.
    """
    found = client.get_experiment_by_name(name)
    if found is None:
        file = sqlite_file(uri)
        # beside the database, wherever the command runs
        location = None if file is None else (file.absolute().parent / ARTIFACTS / artifact_folder(name)).as_uri()
        tags = {"mlflow.experimentKind": "custom_model_development"}  # the dashboard opens on the runs
        try:
            return str(client.create_experiment(name, artifact_location=location, tags=tags))
        except Exception:  # another run made it in the meantime
            found = client.get_experiment_by_name(name)
            if found is None:
                raise
    if found.lifecycle_stage != "active":
        raise RefusedError(f"the experiment {name} was deleted there; restore it, or give tracking.experiment=NAME")
    return str(found.experiment_id)


def runs_with_tag(client: MlflowClient, experiment: str, tag: str, value: str) -> list[Run]:
    """All runs of an experiment that bear a tag with this value, however many pages they fill."""
    found: list[Run] = []
    token = None
    while token is None or token:
        page = client.search_runs([experiment], f"tags.{tag} = '{value}'", page_token=token)
        found += list(page)
        token = page.token or ""
    return found


@contextmanager
def in_plain_words(uri: str) -> Iterator[None]:
    """A context in which the store's own trouble becomes a StoreError; that of the things written does not."""
    try:
        yield
    except StoreError:
        raise
    except Exception as error:
        if cause_of(str(error), uri) is None:
            raise
        raise StoreError(explain(error, uri)) from error


def create_database(path: Path) -> None:
    """Create an MLflow SQLite store, unless there is one.

    The tables are made in a temporary file, because MLflow's own first use is not safe when several processes do it at
    once: they run the migrations against each other. The database of the quickest process stays: it is in use already.
    """
    if path.exists():
        return
    from mlflow.store.tracking.sqlalchemy_store import SqlAlchemyStore
    from sqlalchemy import event
    from sqlalchemy.engine import Engine

    def do_not_sync(connection: sqlite3.Connection, _: object) -> None:
        connection.execute("PRAGMA synchronous = OFF")

    path = path.absolute()
    path.parent.mkdir(parents=True, exist_ok=True)
    # hundreds of small commits to a file that nobody uses before it is complete
    event.listen(Engine, "connect", do_not_sync)
    try:
        with replacing(path, sync=True, keep=True) as temporary:
            store = SqlAlchemyStore(f"sqlite:///{temporary}", (path.parent / ARTIFACTS).as_uri())
            store.engine.dispose()
    finally:
        event.remove(Engine, "connect", do_not_sync)
