"""Where a study lives: a journal file, or any database that Optuna can use; and its errors in plain words."""

from __future__ import annotations

import json
import os
import re
import time
import uuid
from collections.abc import Callable, Iterator, Mapping
from contextlib import contextmanager
from functools import wraps
from pathlib import Path
from typing import TYPE_CHECKING, Any

import optuna
from optuna.exceptions import DuplicatedStudyError, StorageInternalError
from optuna.storages import BaseStorage, JournalStorage, RDBStorage
from optuna.storages.journal import JournalFileBackend
from optuna.storages.journal._file import get_lock_file
from sqlalchemy.exc import DBAPIError, InterfaceError, OperationalError, PendingRollbackError, SQLAlchemyError

from origami_lab.addresses import hidden, whole, without_secrets
from origami_lab.errors import InputError
from origami_lab.files import expanded, require_no_link
from origami_lab.runs.run_folder import FolderError
from origami_lab.sweep.sweep_config import GONE_PRUNER, Declaration
from origami_lab.tracking.sqlite_address import why_no_file, why_not_shared
from origami_lab.tracking.store import cause_of

if TYPE_CHECKING:
    from optuna.pruners import BasePruner

JOURNAL = "study.journal"
DATABASES = ("postgresql", "mysql", "mariadb", "sqlite", "oracle", "mssql")
EXPECTED = "must be a journal file like FILE.journal, or a database like postgresql://USER@HOST/NAME"
FIXED, KEY = "fixed", "key"
"""Attributes of a study: the part of its declaration that cannot change, and what its MLflow runs bear."""
ATTEMPTS = 5
"""Times that a storage with trouble is asked before the trouble is told."""
"""Times that opening a storage is tried before its trouble is told."""
TROUBLE = (StorageInternalError, SQLAlchemyError, OSError)
"""Errors of a storage that cannot be used now."""


class StorageError(Exception):
    """The storage of a study cannot be used; the message is a sentence about it."""


class JournalFile(JournalFileBackend):
    """Optuna's journal, whose writers may be killed: a line that one left half written is taken away by the next."""

    def check(self) -> None:
        """Raise ValueError, KeyError or TypeError if another kind of file is there; Optuna finds out too late."""
        with Path(self._file_path).open("rb") as stream:
            first = stream.readline()
        if first.endswith(b"\n"):
            json.loads(first)["op_code"]

    def append_logs(self, logs: list[dict[str, Any]]) -> None:
        """As Optuna's own, which cannot be called with the lock held."""
        file = Path(self._file_path)
        lines = [json.dumps(log, separators=(",", ":")) + "\n" for log in logs]
        with get_lock_file(self._lock), file.open("rb+") as stream:
            size = stream.seek(0, os.SEEK_END)
            if size:
                stream.seek(size - 1)
                if stream.read(1) != b"\n":
                    stream.truncate(file.read_bytes().rfind(b"\n") + 1)
            stream.seek(0, os.SEEK_END)
            stream.write("".join(lines).encode())
            stream.flush()
            os.fsync(stream.fileno())


def storage_name(declaration: Declaration) -> str:
    """The storage for people: a file or an address, without its password."""
    name = without_secrets(declaration.storage or str(declaration.folder / JOURNAL))
    return hidden(re.sub(r"(?<=://)[^/@]*@", "", name))  # nor its user


def open_storage(declaration: Declaration, patience: float = 0.0) -> BaseStorage:
    """Open the storage of a sweep; a new one is made.

    Parameters
    ----------
    patience
        Seconds for which a database that does not answer is waited for, now and later.

    Raises
    ------
    InputError
        If it can never work: an unknown kind of database, a missing driver, a folder that cannot be written.
    StorageError
        If it does not answer.
    """
    optuna.logging.set_verbosity(optuna.logging.ERROR)
    text = None if declaration.storage is None else whole(declaration.storage)
    scheme, separator, rest = (text or "").partition("://")
    shown = storage_name(declaration)
    if not separator:
        if text is not None and not text.endswith(".journal"):
            raise InputError("storage", shown, EXPECTED)
        file = expanded(text) if text is not None else declaration.folder / JOURNAL
        if why := why_no_file(file):
            raise InputError("storage", shown, why)
        try:
            if text is None:
                file.parent.mkdir(parents=True, exist_ok=True)
                require_no_link(file.parent, file.name)
            journal = JournalFile(str(file.absolute()))
            journal.check()
            return JournalStorage(journal)
        except OSError as error:
            raise InputError("storage", shown, f"must be a file that can be written ({error.strerror})") from error
        except (ValueError, KeyError, TypeError) as error:
            raise InputError("storage", shown, f"is no journal of Optuna's ({error})") from error
    if scheme.partition("+")[0] not in DATABASES:
        raise InputError("storage", shown, EXPECTED)
    if why := why_not_shared(str(text)):
        raise InputError("storage", shown, why)
    # the driver that comes with our extra; SQLAlchemy 2.0 takes another one by default
    url = f"postgresql+psycopg://{rest}" if scheme == "postgresql" else str(text)
    for attempt in range(ATTEMPTS):
        try:
            return optuna.storages.get_storage(Database(url, patience))
        except ImportError:
            hint = "pip install 'origami-lab[postgres]'" if "postgresql" in scheme else "install SQLAlchemy's for it"
            raise InputError("storage", shown, f"needs a database driver: {hint}") from None
        except Exception as error:
            # two that make the tables at the same moment disturb each other: the second look finds them
            if attempt == ATTEMPTS - 1 or is_away(error):
                raise StorageError(explain(error, shown)) from error
            time.sleep(0.2 * (attempt + 1))
    raise AssertionError


def known_study(declaration: Declaration) -> str | None:
    """The key of the declared study if its storage has it; nothing is made.

    Raises
    ------
    InputError, StorageError
        As :func:`open_storage`.
    """
    if declaration.storage is None and not (declaration.folder / JOURNAL).is_file():
        return None
    for study in open_storage(declaration).get_all_studies():
        if study.study_name == declaration.study:
            return str(study.user_attrs.get(KEY, ""))
    return None


def explain(error: Exception, shown: str) -> str:
    """The trouble of a storage, in one line."""
    cause = error.__cause__ or error
    lines = [line for line in str(cause).splitlines() if line.strip()] or [type(cause).__name__]
    return f"the storage {shown} {cause_of(str(cause), shown) or 'failed: ' + hidden(lines[0])[:300]}"


@contextmanager
def in_plain_words(declaration: Declaration) -> Iterator[None]:
    """Errors of the storage or the disk inside become a StorageError."""
    try:
        yield
    except OSError as error:
        raise StorageError(f"{declaration.folder} could not be written: {FolderError(error).why}") from error
    except TROUBLE as error:
        raise StorageError(explain(error, storage_name(declaration))) from error


def open_study(
    storage: BaseStorage, name: str, fixed: Mapping[str, Any], pruner: BasePruner | None = None
) -> optuna.Study:
    """Create a study, or join the one of that name.

    Raises
    ------
    InputError
        If it was declared otherwise; the message names the first difference.
    """
    # whoever comes second to create it joins
    for attempt in range(ATTEMPTS):
        try:
            study = optuna.create_study(
                storage=storage,
                study_name=name,
                direction="maximize",
                load_if_exists=True,
                sampler=optuna.samplers.RandomSampler(0),
                pruner=pruner or optuna.pruners.NopPruner(),
            )
            break
        except (DuplicatedStudyError, *TROUBLE):
            if attempt == ATTEMPTS - 1:
                raise
            time.sleep(0.2)
    known = study.user_attrs
    if FIXED not in known:
        study.set_user_attr(KEY, uuid.uuid4().hex)
        study.set_user_attr(FIXED, dict(fixed))
        known = study.user_attrs  # another one may have declared it at the same moment
    check_same(name, known[FIXED], fixed)
    return study


def check_same(name: str, before: Mapping[str, Any], now: Mapping[str, Any]) -> None:
    """Raise InputError if a study was declared otherwise than it is now; names what differs first."""
    from origami_lab.config.node import flatten

    if _goes_on_without_its_pruner(before, now):
        before = {**before, "pruner": now["pruner"]}
    left, right = flatten(before), flatten(now)
    for key in [*right, *(key for key in left if key not in right)]:
        if left.get(key, "not there") != right.get(key, "not there"):
            was, value = left.get(key, "not there"), right.get(key, "not there")
            expected = f"was {was} when the study {name} was started; give it another name (study: ...) and folder"
            raise InputError(key, value, expected)
    for key in now:
        if isinstance(now[key], Mapping) and list(now[key]) != list(before[key]):
            expected = f"was in the order {', '.join(before[key])} when the study {name} was started, and it matters"
            raise InputError(key, ", ".join(now[key]), expected)


def _goes_on_without_its_pruner(before: Mapping[str, Any], now: Mapping[str, Any]) -> bool:
    """Whether a study of version 0.1.0 had the pruner that is not there any more, and now asks for none."""
    names = [(fixed.get("pruner") or {}).get("name") for fixed in (before, now)]
    return names == [GONE_PRUNER, "none"]


PATIENCE = 600.0
"""Seconds for which a worker waits for a database that does not answer."""


FIRST_WAIT, LONGEST_WAIT = 0.2, 10.0


ASKED = (
    *("_create_new_trial", "_get_trials", "_set_trial_param", "create_new_study"),
    *("get_all_studies", "get_study_directions"),
    *("get_study_id_from_name", "get_study_name_from_id", "get_study_system_attrs", "get_study_user_attrs"),
    *("get_trial", "get_trial_id_from_study_id_trial_number", "set_study_user_attr", "set_trial_intermediate_value"),
    *("set_trial_state_values", "set_trial_system_attr", "set_trial_user_attr"),
)
"""The methods that joining a study and playing it call."""


class Database(RDBStorage):
    """Optuna's storage in a database.

    Asking twice does no harm where the first answer was lost on its way: a trial that was created twice is surplus, one
    that was taken up without knowing it is lost after its lease, and the other values are what they were.

    Parameters
    ----------
    url
        SQLAlchemy's.
    patience
        Seconds for which it waits for a database that does not answer.
    """

    def __init__(self, url: str, patience: float = 0.0) -> None:
        self.patience = patience
        _patient(RDBStorage.__init__)(self, url, engine_kwargs={"pool_pre_ping": True})


def is_away(error: BaseException) -> bool:
    """Whether an error says that the database cannot be reached now, rather than that a request was wrong."""
    while error.__cause__ is not None and not isinstance(error, DBAPIError):
        error = error.__cause__
    gone = isinstance(error, DBAPIError) and error.connection_invalidated
    # the last one: a request that follows a lost connection in the same transaction
    return gone or isinstance(error, OperationalError | InterfaceError | PendingRollbackError)


def _patient(method: Callable[..., Any]) -> Callable[..., Any]:
    @wraps(method)
    def ask(self: Database, *arguments: Any, **named: Any) -> Any:
        deadline, wait = time.monotonic() + self.patience, FIRST_WAIT
        while True:
            try:
                return method(self, *arguments, **named)
            except Exception as error:
                if not is_away(error) or time.monotonic() + wait > deadline:
                    raise
            time.sleep(wait)
            wait = min(2 * wait, LONGEST_WAIT)

    return ask


for _name in ASKED:
    setattr(Database, _name, _patient(getattr(RDBStorage, _name)))
