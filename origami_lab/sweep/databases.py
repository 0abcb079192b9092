"""A study's database that may be away for a while: whoever asks it something waits, and asks again."""

from __future__ import annotations

import time
from collections.abc import Callable
from functools import wraps
from typing import Any

from optuna.storages import RDBStorage
from sqlalchemy.exc import DBAPIError, InterfaceError, OperationalError

PATIENCE = 600.0
"""Seconds for which a worker waits for a database that does not answer."""
FIRST_WAIT, LONGEST_WAIT = 0.2, 10.0
ASKED = (
    *("_create_new_trial", "_get_trials", "_set_trial_param", "get_all_studies", "get_study_directions"),
    *("get_study_id_from_name", "get_study_name_from_id", "get_study_system_attrs", "get_study_user_attrs"),
    *("get_trial", "get_trial_id_from_study_id_trial_number", "set_study_user_attr", "set_trial_intermediate_value"),
    *("set_trial_state_values", "set_trial_system_attr", "set_trial_user_attr"),
)
"""The methods that a running study calls."""


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
    return gone or isinstance(error, OperationalError | InterfaceError)


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
