"""The table that a sweep prints at its end: what its best is worth on held-out seeds, and the command to copy."""

from __future__ import annotations

from collections.abc import Mapping
from typing import TYPE_CHECKING, Any

from origami_lab.runs.trial_row import Spread, spread_of
from origami_lab.sweep.held_out_test import FEW_SEEDS

if TYPE_CHECKING:
    from rich.console import Console
    from rich.table import Table


def show_findings(console: Console, summary: Mapping[str, Any]) -> None:
    """Print the contents of a sweep's summary.json for people: counts, the comparison, and the best's command."""
    counts = ", ".join(f"{number} {name}" for name, number in summary["trials"].items() if number)
    title = f"{summary['study']}: {counts or 'no'} trials, {summary['seeds_played']} seeds played"
    console.print(title, highlight=False, markup=False, soft_wrap=True)
    held_out, best = summary["held_out"], summary["best"]
    if held_out:
        console.print(comparison_table(held_out))
        for line in comparison_notes(held_out):
            console.print(line, highlight=False, markup=False, soft_wrap=True)
    if best is not None:
        played = list(best["returns"].values())
        on_own = f"{best['value']:.{_digits(played)}f} on the sweep's own seeds, on which it was chosen"
        console.print(f"best: trial {best['trial']}, {on_own}", highlight=False, markup=False, soft_wrap=True)
        console.print(f"  {best['command']}", highlight=False, markup=False, soft_wrap=True)


def comparison_table(held_out: Mapping[str, Any]) -> Table:
    """A row for each of the settings compared, each figure to the digit that it is worth."""
    from rich import box
    from rich.table import Table
    from rich.text import Text

    seeds = str(held_out["seeds"]).replace(" ", "")
    title = f"on held-out seeds {seeds}, {held_out['budget']:,} interactions each"
    table = Table(title=title, title_justify="left", header_style="bold", box=box.SIMPLE_HEAD, padding=(0, 1, 0, 0))
    for name in ("settings", "mean ± std", "median", "best is better by", "95 % interval", "p"):
        table.add_column(name, justify="left" if name == "settings" else "right")
    for name, found in held_out["settings"].items():
        spread = Spread(found["mean"], found["std"], len(found["returns"]))
        cells = [spread.rounded, f"{found['median']:.{spread.digits}f}"]
        result = held_out["differences"].get(name)
        if result is not None:
            digits = min(spread.digits, _digits(held_out["settings"]["best"]["returns"]))
            cells += [f"{result['mean']:+.{digits}f}", f"{result['low']:+.{digits}f} to {result['high']:+.{digits}f}"]
            cells += [_probability(result["p"])]
        else:
            cells += ["", "", ""]
        table.add_row(Text(name), *cells, style="bold" if name == "best" else None)
    for name, reason in held_out["failed"].items():
        table.add_row(Text(name), Text(f"failed: {reason}"), "", "", "", "")
    return table


def comparison_notes(held_out: Mapping[str, Any]) -> list[str]:
    """Lines on how far the comparison can be trusted."""
    notes = [
        f"against {name}: {result['verdict']}" for name, result in held_out["differences"].items() if result is not None
    ]
    played = min((len(found["returns"]) for found in held_out["settings"].values()), default=0)
    if 0 < played < FEW_SEEDS:
        notes.append(f"{played} seeds are few: intervals from so few are too narrow, and little is significant")
    return notes


def _digits(returns: list[float]) -> int:
    """Decimals that the mean of some returns is worth."""
    spread = spread_of(returns)
    return 4 if spread is None else spread.digits


def _probability(p: float) -> str:
    return "< 0.001" if p < 0.001 else f"{p:.2g}" if p < 0.1 else f"{p:.2f}"
