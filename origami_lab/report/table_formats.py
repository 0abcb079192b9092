"""Tables as text: Markdown, CSV, LaTeX."""

from __future__ import annotations

import csv
import io
from collections.abc import Iterable, Sequence

from origami_lab.report.known_values import Known
from origami_lab.report.run_groups import Groups
from origami_lab.report.tables import HIGHER, MISSING, Cell, Table
from origami_lab.runs.trial_row import FAILED, NO_DESIGN, STOPPED

CSV_COLUMNS = (
    *("table", "row", "column", "method", "task", "budget", "mean", "std", "trials", "best"),
    *("no_design", "stopped", "failed", "beside_mean", "beside_std", "beside_source", "differs"),
)
_TEX = {"\\": r"\textbackslash{}", "~": r"\textasciitilde{}", "^": r"\textasciicircum{}"}
_TEX |= {character: f"\\{character}" for character in "&%$#_{}"}
_TEX |= {"–": "--", "−": "$-$", "±": r"$\pm$", "↑": r"$\uparrow$", "↓": r"$\downarrow$", "→": r"$\to$", "…": r"\dots{}"}


def number(value: float, digits: int) -> str:
    """With a true minus sign; nothing is minus zero."""
    return f"{value:z,.{digits}f}".replace("-", "−")


def many(count: int, word: str) -> str:
    """A number of things, with its plural."""
    return f"{count:,} {word}{'' if count == 1 else 's'}"


def value_text(cell: Cell, digits: int) -> str:
    """Mean ± std, or a dash."""
    if cell.spread is None:
        return MISSING
    std = "" if cell.spread.std is None else f" ± {number(cell.spread.std, digits)}"
    return number(cell.spread.mean, digits) + std


def known_text(known: Known) -> str:
    std = "" if known.std is None else f" ± {number(known.std, known.digits)}"
    return number(known.mean, known.digits) + std


def markdown(tables: Iterable[Table]) -> str:
    """Tables one below the other, each with its notes."""
    parts = []
    for table in tables:
        lines = [_row(["", *(_plain(column.label) for column in table.columns)])]
        lines.append(_row(["---", *("---:" for _ in table.columns)]))
        for row in table.rows:
            cells = (_markdown_cell(table.cell(row, column), table.digits) for column in table.columns)
            lines.append(_row([_plain(row.label), *cells]))
        notes = [f"- {_plain(note)}" for note in table.notes]
        parts.append("\n".join([f"## {table.title}", "", *lines, "", *notes]))
    return "\n\n".join(parts) + "\n"


def _row(cells: Sequence[str]) -> str:
    return f"| {' | '.join(cells)} |"


def _plain(text: str) -> str:
    """A name as plain text: nothing in it is markup."""
    for character in "\\|*_<`":
        text = text.replace(character, f"\\{character}")
    return text


def _markdown_cell(cell: Cell, digits: int) -> str:
    text = value_text(cell, digits)
    if cell.best:
        text = f"**{text}**"
    if cell.spread is not None:
        text += f" ({cell.spread.n})"
    if cell.known is not None:
        text += f" [{known_text(cell.known)}]{cell.mark}"
    return text


def latex(tables: Iterable[Table]) -> str:
    """One ``table`` environment each; they need no package."""
    parts = []
    for table in tables:
        lines = [
            r"\begin{table}[t]",
            r"  \centering",
            rf"  \begin{{tabular}}{{l{'r' * len(table.columns)}}}",
            r"    \hline",
            "    " + " & ".join(["", *(tex(column.label) for column in table.columns)]) + r" \\",
            r"    \hline",
        ]
        for row in table.rows:
            cells = [_latex_cell(table.cell(row, column), table.digits) for column in table.columns]
            lines.append("    " + " & ".join([tex(row.label), *cells]) + r" \\")
        caption = " ".join([f"{table.title}.", *table.notes])
        lines += [r"    \hline", r"  \end{tabular}", rf"  \caption{{{tex(caption)}}}"]
        lines += [rf"  \label{{tab:{table.name}}}", r"\end{table}"]
        parts.append("\n".join(lines))
    return "\n\n".join(parts) + "\n"


def tex(text: str) -> str:
    """Text that LaTeX prints as it is."""
    return "".join(_TEX.get(character, character) for character in text)


def _latex_cell(cell: Cell, digits: int) -> str:
    if cell.spread is None:
        text = "--"
    else:
        value = _math(value_text(cell, digits))
        text = (rf"$\mathbf{{{value}}}$" if cell.best else f"${value}$") + f" ({cell.spread.n})"
    if cell.known is not None:
        arrow = {"": "", HIGHER: r"$^{\uparrow}$"}.get(cell.mark, r"$^{\downarrow}$")
        text += f" [${_math(known_text(cell.known))}$]{arrow}"
    return text


def _math(text: str) -> str:
    return text.replace("−", "-").replace(" ± ", r"\pm ").replace(",", "{,}")


def csv_text(tables: Iterable[Table], groups: Groups) -> str:
    """One line a cell, missing ones with empty numbers; numbers in full."""
    text = io.StringIO()
    writer = csv.DictWriter(text, CSV_COLUMNS, lineterminator="\n", restval="")
    writer.writeheader()
    for table in tables:
        for row in table.rows:
            for column in table.columns:
                cell, group = table.cell(row, column), groups.cells.get((row, column))
                line: dict[str, object] = {"table": table.name, "row": row.label, "column": column.label}
                line |= {"method": row.name, "task": column.name, "trials": 0}
                if group is not None:
                    statuses = zip(("no_design", "stopped", "failed"), (NO_DESIGN, STOPPED, FAILED), strict=True)
                    line |= {"budget": group.budget, **{name: group.number(status) for name, status in statuses}}
                if cell.spread is not None:
                    line |= {"mean": cell.spread.mean, "std": cell.spread.std, "trials": cell.spread.n}
                    line["best"] = "yes" if cell.best else ""
                if cell.known is not None:
                    line |= {"beside_mean": cell.known.mean, "beside_std": cell.known.std}
                    line |= {"beside_source": cell.known.source}
                    line["differs"] = {"": "", HIGHER: "higher"}.get(cell.mark, "lower")
                writer.writerow({name: "" if value is None else value for name, value in line.items()})
    return text.getvalue()
