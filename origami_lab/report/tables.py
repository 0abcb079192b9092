"""The tables: mean ± std of returns and of interactions to the best design; a row a searcher, a column a task."""

from __future__ import annotations

from collections import Counter
from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import dataclass, replace

from origami_lab.report.known_values import Known, KnownValues
from origami_lab.report.run_groups import Group, Groups, Heading
from origami_lab.runs.trial_row import FAILED, NO_DESIGN, OK, STOPPED, Spread, spread_of, spreads

MISSING = "–"
HIGHER, LOWER = "↑", "↓"
"""Ours against the value beside it."""
DISTANCES = ("vertex", "surface", "sampled")
PLACES = "places evaluated"
MOST_LISTED = 12
"""Cells that a note names; the CSV file has the numbers of all."""


@dataclass(frozen=True)
class Cell:
    """One searcher on one task."""

    spread: Spread | None
    """None where nothing was run, or nothing of it counts."""
    known: Known | None = None
    best: bool = False
    """Whether it is the best of its column, as printed."""

    @property
    def mark(self) -> str:
        """An arrow where the value beside ours differs by more than a standard deviation."""
        if self.spread is None or self.known is None or not self.known.differs(self.spread):
            return ""
        return HIGHER if self.spread.mean > self.known.mean else LOWER


@dataclass(frozen=True)
class Table:
    """One table, before it is written by :mod:`origami_lab.report.table_formats`."""

    name: str
    """``returns``, ``returns_surface`` …, ``interactions``"""
    title: str
    rows: tuple[Heading, ...]
    columns: tuple[Heading, ...]
    cells: Mapping[tuple[Heading, Heading], Cell]
    notes: tuple[str, ...]
    digits: int

    def cell(self, row: Heading, column: Heading) -> Cell:
        return self.cells.get((row, column), Cell(None))


def return_tables(groups: Groups, beside: KnownValues | None = None) -> list[Table]:
    """The returns that the searches went by, then, for targets, those under the distances that say something else."""
    beside = beside or {}
    used = sorted({group.distance for group in groups.cells.values() if group.distance is not None})
    title = "Best return" + (f" ({' or '.join(used)} distance, the search's own)" if used else "")
    first = _values(groups, "return")
    tables = [_table(groups, "returns", title, first, beside, 4)]
    for distance in DISTANCES:
        values = _values(groups, f"return_{distance}")
        # what the search used is the return: said once
        if any(_differ(first.get(place), spread) for place, spread in values.items()):
            name = f"returns_{distance}"
            tables.append(_table(groups, name, f"Best return, measured by {distance} distance", values, beside, 4))
    # what others publish are distances from the farthest place, or returns: they say nothing of what follows
    if means := _values(groups, "chamfer"):
        values = {place: replace(spread, mean=-spread.mean) for place, spread in means.items()}
        title = "Best return, measured by the mean distance both ways (chamfer)"
        tables.append(_table(groups, "returns_mean", title, values, {}, 4))
    if likeness := _values(groups, "likeness"):
        title = "Likeness: share of the target's area with a panel within 5 % of its size, turned by 20° at most"
        tables.append(_table(groups, "returns_likeness", title, likeness, {}, 4))
    if polished := _values(groups, "polished_return"):
        title = "Return of the best designs once polished off the grid"
        tables.append(_table(groups, "returns_polished", title, polished, {}, 4))
    return tables


def interactions_table(groups: Groups, beside: KnownValues | None = None) -> Table:
    """Interactions until the best design was found, in thousands, of the trials that found one.

    Where places were evaluated without being played, how many of them a trial has a row of its own.
    """
    values = {}
    for place, group in groups.cells.items():
        found = ((t.row.interactions_to_best or 0) / 1000 for t in group.counted if t.row.outcome == OK)
        spread = spread_of(found)
        if spread is not None:
            values[place] = spread
    title = "Interactions to the best design, in thousands"
    return _with_places(groups, _table(groups, "interactions", title, values, beside or {}, 1))


def _with_places(groups: Groups, table: Table) -> Table:
    """The table with a row below each searcher that evaluates places without playing them: how many, in thousands."""
    rows, cells = [], dict(table.cells)
    for row in table.rows:
        rows.append(row)
        own = Heading(row.name, f"{row.label} ({PLACES})")
        for column in table.columns:
            group = groups.cells.get((row, column))
            spread = spread_of((t.row.places_evaluated or 0) / 1000 for t in group.counted) if group else None
            if spread is not None and spread.mean > 0:
                cells[own, column] = Cell(spread)
                rows += [own] if own not in rows else []
    notes = table.notes
    if len(rows) > len(table.rows):
        notes = (*notes, f"{PLACES.capitalize()} of all a trial, in thousands: looked at without being played.")
    return replace(table, rows=tuple(rows), cells=cells, notes=notes)


Place = tuple[Heading, Heading]


def _values(groups: Groups, column: str) -> dict[Place, Spread]:
    found = {place: spreads(t.row for t in group.counted).get(column) for place, group in groups.cells.items()}
    return {place: spread for place, spread in found.items() if spread is not None}


def _differ(one: Spread | None, other: Spread) -> bool:
    return one is None or abs(one.mean - other.mean) > 1e-9 or abs((one.std or 0) - (other.std or 0)) > 1e-9


def _table(
    groups: Groups, name: str, title: str, values: Mapping[Place, Spread], beside: KnownValues, digits: int
) -> Table:
    of_all = name in ("returns", "interactions")
    columns = tuple(c for c in groups.columns if of_all or any(c == place[1] for place in values))
    kind = name.partition("_")[0]
    known = {key[1:]: value for key, value in beside.items() if key[0] == kind}
    every = _with_known_rows(groups, columns, known)
    placed = _comparable(groups, _places_beside(groups, every, columns), known)
    filled = {place[0] for place in (groups.cells if of_all else values)}
    filled |= {row for row, column in placed if (row.name, column.name) in known}
    rows = tuple(row for row in every if row in filled)
    cells = {}
    for column in columns:
        means = [values[row, column].mean for row in rows if (row, column) in values]
        # as printed: trials that end at the same optimum differ in the last bits
        top = f"{max(means):.{digits}f}" if kind == "returns" and len(means) > 1 else None
        for row in rows:
            spread = values.get((row, column))
            best = spread is not None and f"{spread.mean:.{digits}f}" == top
            beside_it = known.get((row.name, column.name)) if (row, column) in placed else None
            cells[row, column] = Cell(spread, beside_it, best)
    at_hand = {(row.name, column.name) for row, column in groups.cells}
    notes = _notes(groups, columns, kind) + _known_notes(
        cells.values(), (value for key, value in known.items() if key in at_hand)
    )
    return Table(name, title, rows, columns, cells, tuple(notes), digits)


def _with_known_rows(
    groups: Groups, columns: Iterable[Heading], known: Mapping[tuple[str, str], Known]
) -> tuple[Heading, ...]:
    """Our rows, and the searchers that only the values beside ours have."""
    tasks, ours = {column.name for column in columns}, {row.name for row in groups.rows}
    others = sorted({method for method, task in known if task in tasks and method not in ours})
    every = [*groups.rows, *(Heading(method, method) for method in others)]
    place = {method: index for index, method in enumerate(groups.order.methods({row.name for row in every}))}
    return tuple(sorted(every, key=lambda row: place[row.name]))


def _places_beside(groups: Groups, rows: Iterable[Heading], columns: Iterable[Heading]) -> set[Place]:
    """The cells beside which known values stand: tasks of the usual settings, in each searcher's usual row.

    On a task that this row has not run, and one other row of the same searcher and budget has, that one is the usual.
    """
    places = set()
    for usual in (row for row in rows if row.is_usual):
        budgets = {group.budget for (row, _), group in groups.cells.items() if row == usual}
        for column in (column for column in columns if column.is_usual):
            own = {row: group.budget for row, group in groups.column(column) if row.name == usual.name}
            if usual in own or not own:
                places.add((usual, column))
            elif len(own) == 1 and budgets.issuperset(own.values()):
                places.add((next(iter(own)), column))
    return places


def _comparable(groups: Groups, places: Iterable[Place], known: Mapping[tuple[str, str], Known]) -> set[Place]:
    """Those of the places where the known value is of the cell's budget and number of trials.

    A searcher that only the known values have stands on the tasks on which one of ours can be compared.
    """
    places = list(places)
    kept = set()
    for row, column in places:
        value, group = known.get((row.name, column.name)), groups.cells.get((row, column))
        if value is not None and group is not None and value.is_comparable(group.budget, len(group.counted)):
            kept.add((row, column))
    tasks = {column for _, column in kept}
    alone = {place for place in places if place not in groups.cells and place[1] in tasks}
    anywhere = {
        (row, column)
        for row, column in places
        if (value := known.get((row.name, column.name))) is not None
        and (row, column) not in groups.cells
        and value.budget is None
        and value.trials is None
    }
    return kept | alone | anywhere


def _notes(groups: Groups, columns: Iterable[Heading], kind: str) -> list[str]:
    """Notes that a reader needs to compare the cells."""
    counted = "in parentheses the number of trials"
    bold = "; the best of each column is bold" if kind == "returns" else ""
    notes = [f"Mean ± sample standard deviation, {counted}{bold}; {MISSING} was not run or has no trial that counts."]
    notes += [f"{note.text}." for note in groups.notes if not note.folders]  # what rows and columns stand for
    cells = {(row, column): group for column in columns for row, group in groups.column(column)}
    notes += _unequal(cells, "Budget, in interactions a trial", lambda group: group.budget)
    notes += _unequal(cells, "Trials", lambda group: len(group.counted), only_if_unequal=True)
    for (row, column), group in cells.items():
        words = [f"{group.number(s)} {s}" for s in (FAILED, STOPPED) if group.number(s)]
        if words:
            notes.append(f"{column.label}, {row.label}: {' and '.join(words)}, not counted.")
        empty = group.number(NO_DESIGN)
        if empty:
            means = "their return is the penalty" if kind == "returns" else "which do not count here"
            trials = f"{empty} of {len(group.counted)} trials"
            notes.append(f"{column.label}, {row.label}: {trials} found no design that folds; {means}.")
    return notes


def _unequal(
    cells: Mapping[Place, Group], what: str, number: Callable[[Group], int], only_if_unequal: bool = False
) -> list[str]:
    """One line that names a number, and the cells that have another one than most."""
    numbers = {place: number(group) for place, group in cells.items()}
    counts = Counter(numbers.values())
    if not counts or (only_if_unequal and len(counts) == 1):
        return []
    usual = max(counts, key=lambda value: (counts[value], value))
    others: dict[int, list[Place]] = {}
    for place, value in numbers.items():
        if value != usual:
            others.setdefault(value, []).append(place)
    listed = "".join(f"; {value:,} for {_named(places, numbers)}" for value, places in sorted(others.items()))
    return [f"{what}: {usual:,}{listed}."]


def _named(places: Sequence[Place], every: Iterable[Place]) -> str:
    """The names of cells: of a whole row, where there are several in it, that of the searcher; not too many."""
    rows = Counter(row for row, _ in every)
    here = Counter(row for row, _ in places)
    whole = {row for row, count in here.items() if count == rows[row] and count > 1}
    names = list(dict.fromkeys(row.label if row in whole else f"{column.label} {row.label}" for row, column in places))
    more = f" and {len(names) - MOST_LISTED} more" if len(names) > MOST_LISTED else ""
    return ", ".join(names[:MOST_LISTED]) + more


def _known_notes(cells: Iterable[Cell], asked: Iterable[Known]) -> list[str]:
    known = [cell for cell in cells if cell.known is not None]
    sources = sorted({cell.known.source for cell in known if cell.known is not None})
    conditions = sorted({(value.budget, value.trials) for value in asked if value.budget and value.trials})
    of = " or ".join(f"{trials} trials of {budget:,} interactions" for budget, trials in conditions)
    if not known:
        return [f"The values to be set beside these are of {of}, and stand only beside such cells."] if of else []
    return [
        f"In brackets: {', '.join(sources)}. {HIGHER} {LOWER} ours is higher or lower by more than one standard"
        " deviation (the larger of the two)."
    ]
