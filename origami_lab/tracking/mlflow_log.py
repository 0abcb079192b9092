"""What every push does: look, create, log in batches, end."""

from __future__ import annotations

import hashlib
import json
from collections.abc import Mapping
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from mlflow.entities import Run


BATCH = 900
"""Metrics a call: MLflow's limit is 1000 items."""


PARAMS = 100


KEY, CONTENT, PARENT = "run_key", "content", "mlflow.parentRunId"
"""Tags: which run folder a run belongs to, a digest of what was logged, and MLflow's own for a child's parent."""


@dataclass(frozen=True)
class _Logged:
    """A run in the store."""

    run: str
    content: str | None
    """The digest of what was logged; None while the run has not ended."""


def digest(content: Mapping[Any, Any]) -> str:
    return hashlib.sha256(json.dumps(content, sort_keys=True).encode()).hexdigest()[:16]


def _logged(run: Run) -> _Logged:
    return _Logged(str(run.info.run_id), None if run.info.status == "RUNNING" else run.data.tags.get(CONTENT))
