"""What a sweep prints at its end."""

from __future__ import annotations

import io
from typing import Any

from rich.console import Console

from origami_lab.sweep.findings_table import show_findings
from origami_lab.sweep.held_out_test import compare


def shown(held_out: dict[str, Any], best: dict[str, Any] | None) -> str:
    out = io.StringIO()
    trials = {"complete": 3, "pruned": 1, "failed": 0}
    summary = {"study": "[red]", "trials": trials, "seeds_played": 10, "held_out": held_out, "best": best}
    show_findings(Console(file=out, width=120), summary)
    return out.getvalue()


def test_the_findings_of_a_sweep_are_a_table_and_a_command() -> None:
    returns = {"best": [-1.0, -1.1, -1.2, -1.3], "defaults": [-2.0, -2.4, -2.8, -3.2]}
    held_out = compare(returns) | {"failed": {"other": "the kettle is empty"}, "seeds": [100, 101], "budget": 5000}
    best = {"trial": 2, "value": -1.05, "returns": {"0": -1.0, "1": -1.1}, "command": "origami-lab target=bowl"}
    text = shown(held_out, best)
    lines = text.splitlines()
    assert lines[0] == "[red]: 3 complete, 1 pruned trials, 10 seeds played"
    assert "on held-out seeds [100,101], 5,000 interactions each" in text
    row = next(line for line in lines if line.strip().startswith("defaults"))
    # the mean of -2.6 ± 0.52 over four seeds is known to 0.26, that of the best to 0.06
    assert "-2.6 ± 0.5" in row
    assert "+1.5" in row
    assert "-1.15 ± 0.13" in text
    assert "failed: the kettle is empty" in text
    assert "4 seeds are few" in text
    assert lines[-2] == "best: trial 2, -1.05 on the sweep's own seeds, on which it was chosen"
    assert lines[-1] == "  origami-lab target=bowl"


def test_a_sweep_of_failures_has_no_best() -> None:
    assert shown({}, None) == "[red]: 3 complete, 1 pruned trials, 10 seeds played\n"
