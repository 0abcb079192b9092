"""How MLflow's pages show an experiment of ours: which columns, and which charts.

MLflow keeps a view that is shared in a tag of the experiment, and shows it at an address that names its key. The form
of that tag is MLflow's own (read in the pages of version 3.17): one that another version does not understand is passed
over, and the plain list of runs is shown.
"""

from __future__ import annotations

import json
import uuid
from collections.abc import Sequence
from typing import Any

KEY = "origami-lab"
TAG = f"mlflow.sharedViewState.{KEY}"
NOTE = "mlflow.note.content"
LONGEST_NOTE = 8000
"""Characters of a description: MLflow's page shows so much without scrolling for long."""
CURVE = "mean_return_so_far"
"""The metric of an experiment's run with its learning curve: the mean of the trials' best returns so far."""
RUN_COLUMNS = (
    *("metrics.return_mean", "metrics.return_std", "metrics.best_return", "metrics.best_seed"),
    *("tags.certificate", "metrics.interactions", "tags.seeds", "tags.search"),
)
RUN_CHARTS = (
    ("Learning curves", (CURVE,)),
    ("Returns", ("return_mean", "best_return", "chamfer_mean", "likeness_mean", "seconds")),
)
STUDY_CHARTS = (("Study", ("best_mean_return", "mean_return")),)


def address(experiment: str, charts: bool = False) -> str:
    """Where a server shows an experiment as a table, or as charts; to be put after the server's own address."""
    mode = "&compareRunsMode=CHART" if charts else ""
    # else its pages begin with what is for language models
    return f"/#/experiments/{experiment}/runs?viewStateShareKey={KEY}{mode}&workflowType=machine_learning"


def experiment_view() -> str:
    """The view of an experiment's runs, as the tag's text."""
    return _view(RUN_COLUMNS, RUN_CHARTS)


def study_view(parameters: Sequence[str]) -> str:
    """The view of a study's trials."""
    columns = ("metrics.mean_return", "tags.state", *(f"params.{name}" for name in parameters))
    return _view(columns, STUDY_CHARTS)


def _view(columns: Sequence[str], charts: Sequence[tuple[str, Sequence[str]]]) -> str:
    sections = [_section(name) for name, _ in charts]
    cards = [
        _card(metric, section["uuid"])
        for section, (_, metrics) in zip(sections, charts, strict=True)
        for metric in metrics
    ]
    state = {
        "selectedColumns": [_column(name) for name in columns],
        "columnOrder": [_column(name) for name in columns],
        "runsHiddenMode": "FIRST_20_RUNS",
        "hideEmptyCharts": True,
        "compareRunCharts": cards,
        "compareRunSections": sections,
        "isAccordionReordered": True,
    }
    return json.dumps(state, separators=(",", ":"))


def _column(name: str) -> str:
    kind, _, key = name.partition(".")
    return f"{kind}.`{key}`"


def _section(name: str) -> dict[str, Any]:
    identity = _identity(name)
    return {
        "uuid": identity,
        "name": name,
        "display": True,
        "isReordered": True,
        "deleted": False,
        "isGenerated": False,
    }


def _card(metric: str, section: str) -> dict[str, Any]:
    """One chart: a line over interactions for what has steps, bars for a single figure."""
    card: dict[str, Any] = {
        "uuid": _identity(f"{section} {metric}"),
        "runsCountToCompare": 20,
        "metricSectionId": section,
        "deleted": False,
        "isGenerated": False,
        "metricKey": metric,
        "displayName": metric,
    }
    if metric in (CURVE, "best_mean_return"):
        over = "linear" if metric == "best_mean_return" else "log"
        line = {"type": "LINE", "selectedMetricKeys": [metric], "lineSmoothness": 0, "xAxisScaleType": over}
        line |= {"scaleType": "linear", "range": {}, "xAxisKey": "step", "selectedXAxisMetricKey": ""}
        line |= {"yAxisKey": "metric", "yAxisExpressions": [], "ignoreOutliers": False}
        return {**card, **line, "useGlobalXaxisKey": False, "useGlobalLineSmoothing": False}
    return {**card, "type": "BAR"}


def _identity(text: str) -> str:
    """An id that is the same each time, so that the view is written once."""
    return str(uuid.uuid5(uuid.NAMESPACE_URL, f"origami-lab {text}"))
