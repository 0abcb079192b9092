"""The tables of a report, against means and deviations that were worked out by hand."""

from __future__ import annotations

import csv
import io
import math
import re
from dataclasses import replace
from pathlib import Path
from typing import Any

import pytest

from origami_lab.errors import InputError
from origami_lab.report.known_values import COLUMNS, Known, read_beside
from origami_lab.report.table_formats import csv_text, latex, markdown, number, tex
from origami_lab.report.tables import Table, interactions_table, return_tables
from origami_lab.runs.trial_row import Spread
from tests.report.runs import failed, gather, labels, trial, write_run

HALF = math.sqrt(0.5)  # the sample standard deviation of two numbers that are 1 apart


@pytest.fixture
def four(tmp_path: Path) -> Path:
    """Two searchers, two tasks, one cell missing."""
    write_run(tmp_path / "a", "cube", "rdm", [trial(-1.0, 1000), trial(-2.0, 2000), trial(-3.0, 6000)])
    write_run(tmp_path / "b", "cube", "evo", [trial(-0.5, 500), trial(-1.5, 1500), failed()])
    write_run(tmp_path / "c", "pyramid", "rdm", [trial(-0.25)], budget=5000)
    return tmp_path


def by_label(table: Table, row: str, column: str) -> Spread | None:
    [found] = [cell for (r, c), cell in table.cells.items() if (r.label, c.label) == (row, column)]
    return found.spread


def close(spread: Spread | None, mean: float, std: float | None, n: int) -> bool:
    assert spread is not None
    same = spread.std == pytest.approx(std) if std is not None else spread.std is None
    return spread.mean == pytest.approx(mean) and same and spread.n == n


def test_means_and_deviations(four: Path) -> None:
    _, groups, _ = gather(four)
    tables = return_tables(groups)
    assert [table.name for table in tables] == ["returns"]  # the distances say nothing else
    [table] = tables
    assert [column.label for column in table.columns] == ["pyramid", "cube"]
    assert [row.label for row in table.rows] == ["rdm", "evo"]
    assert close(by_label(table, "rdm", "cube"), -2.0, 1.0, 3)
    assert close(by_label(table, "evo", "cube"), -1.0, HALF, 2)
    assert close(by_label(table, "rdm", "pyramid"), -0.25, None, 1)
    assert by_label(table, "evo", "pyramid") is None
    best = {(r.label, c.label) for (r, c), cell in table.cells.items() if cell.best}
    assert best == {("evo", "cube")}
    interactions = interactions_table(groups)
    assert close(by_label(interactions, "rdm", "cube"), 3.0, math.sqrt(7), 3)
    assert close(by_label(interactions, "evo", "cube"), 1.0, HALF, 2)


def test_what_a_reader_must_know_is_said(four: Path) -> None:
    write_run(
        four / "d", "pyramid", "evo", [trial(-8.0, status="no design"), trial(-1.0), trial(-5.0, status="stopped")]
    )
    _, groups, notes = gather(four)
    [table] = return_tables(groups)
    said = "\n".join(table.notes)
    assert "cube, evo: 1 failed, not counted." in said
    assert "pyramid, evo: 1 stopped, not counted." in said
    assert "pyramid, evo: 1 of 2 trials found no design that folds; their return is the penalty." in said
    assert "Budget, in interactions a trial: 1,000; 5,000 for pyramid rdm." in said
    assert "Trials: 2; 1 for pyramid rdm; 3 for cube rdm." in said
    assert close(by_label(table, "evo", "pyramid"), -4.5, 7 * HALF, 2)
    assert close(by_label(interactions_table(groups), "evo", "pyramid"), 0.1, None, 1)
    assert any(note.endswith("not finished, 2 of 3 trials") for note in notes)


def test_cells_of_another_budget_are_named_by_their_row_and_not_too_many(tmp_path: Path) -> None:
    for task in ("cube", "bowl"):
        for method in ("rdm", "evo", "mcts"):
            write_run(tmp_path / task / method, task, method, [trial(-1.0)], budget=5000 if method == "evo" else 1000)
    [table] = return_tables(gather(tmp_path)[1])
    assert "Budget, in interactions a trial: 1,000; 5,000 for evo." in table.notes
    for index in range(30):
        budget = 7000 if index < 14 else 1000
        write_run(tmp_path / str(index), f"task{index:02}", "rdm", [trial(-1.0)], budget=budget)
    [table] = return_tables(gather(tmp_path)[1])
    [note] = [note for note in table.notes if note.startswith("Budget")]
    assert note.endswith("task11 rdm and 2 more.")


def test_each_distance_has_its_table(four: Path) -> None:
    rows = [
        trial(-1.0, return_surface=-1.5, return_sampled=-1.0),
        trial(-2.0, return_surface=-2.5, return_sampled=-2.0),
    ]
    write_run(four / "d", "bowl", "rdm", rows)
    none = dict.fromkeys(("return_vertex", "return_surface", "return_sampled"))
    write_run(four / "e", "table", "rdm", [trial(-3.0, **none)], objective={"_target_": "x.Table"})
    _, groups, _ = gather(four)
    first, surface = return_tables(groups)
    assert first.title == "Best return (vertex distance, the search's own)"
    assert surface.name == "returns_surface"
    assert close(by_label(first, "rdm", "bowl"), -1.5, HALF, 2)
    assert close(by_label(surface, "rdm", "bowl"), -2.0, HALF, 2)
    assert [column.label for column in first.columns][-1] == "table"
    assert "table" not in [column.label for column in surface.columns]


def test_csv_parses_back(four: Path) -> None:
    _, groups, _ = gather(four)
    lines = list(csv.DictReader(io.StringIO(csv_text(return_tables(groups), groups))))
    cells = {(line["row"], line["column"]): line for line in lines}
    assert len(lines) == 4
    assert float(cells["rdm", "cube"]["mean"]) == -2.0
    assert float(cells["rdm", "cube"]["std"]) == 1.0
    evo = cells["evo", "cube"]
    assert (evo["trials"], evo["failed"], evo["best"], evo["budget"]) == ("2", "1", "yes", "1000")
    missing = cells["evo", "pyramid"]
    assert (missing["mean"], missing["std"], missing["trials"], missing["budget"]) == ("", "", "0", "")


def test_latex_parses_back(four: Path) -> None:
    _, groups, _ = gather(four)
    text = latex(return_tables(groups))
    body = text.split(r"\hline")[2]
    rows = {cells[0].strip(): cells[1:] for line in body.strip().split(r"\\") if (cells := line.split("&"))[1:]}
    assert rows.keys() == {"rdm", "evo"}
    value = re.compile(r"\$(?:\\mathbf\{)?(-?[\d.]+)(?:\\pm ([\d.]+))?\}?\$ \((\d+)\)")
    assert [value.search(cell).groups() for cell in rows["rdm"]] == [  # type: ignore[union-attr]
        ("-0.2500", None, "1"),
        ("-2.0000", "1.0000", "3"),
    ]
    assert rows["evo"][0].strip() == "--"
    assert r"\mathbf{-1.0000\pm 0.7071}" in rows["evo"][1]
    assert text.count("{") == text.count("}")
    assert not re.search(r"[−±–↑↓]", text)
    assert tex("a_b & 50% #1 {x}") == r"a\_b \& 50\% \#1 \{x\}"


def test_markdown_has_a_cell_for_everything(four: Path) -> None:
    _, groups, _ = gather(four)
    lines = markdown(return_tables(groups)).splitlines()
    table = [[cell.strip() for cell in line.strip("|").split("|")] for line in lines if line.startswith("|")]
    assert table[0] == ["", "pyramid", "cube"]
    assert table[2] == ["rdm", "−0.2500 (1)", "−2.0000 ± 1.0000 (3)"]
    assert table[3] == ["evo", "–", "**−1.0000 ± 0.7071** (2)"]


def test_equal_as_printed_is_equally_good(tmp_path: Path) -> None:
    for method, value in (("rdm", -0.5), ("evo", -0.5 - 1e-12), ("dfts", -0.6)):
        write_run(tmp_path / method, "cube", method, [trial(value), trial(value)])
    _, groups, _ = gather(tmp_path)
    [table] = return_tables(groups)
    assert {row.label for (row, _), cell in table.cells.items() if cell.best} == {"rdm", "evo"}


def of_any_budget(name: str = "paper") -> dict[tuple[str, str, str], Known]:
    """Known values that say nothing of budgets and trials."""
    return {key: replace(known, budget=None, trials=None) for key, known in read_beside(name).items()}


def test_the_paper_s_values_stand_only_beside_cells_of_its_budget_and_ten_seeds(tmp_path: Path) -> None:
    paper = read_beside("paper")
    assert {(known.budget, known.trials) for known in paper.values()} == {(500_000, 10)}
    ten, nine = [trial(-1.0)] * 10, [trial(-1.0)] * 9
    write_run(tmp_path / "a", "cube", "rdm", ten, budget=500_000)
    write_run(tmp_path / "b", "cube", "evo", nine, budget=500_000)
    write_run(tmp_path / "c", "bowl", "rdm", ten, budget=400_000)
    write_run(tmp_path / "d", "face", "mcts", [*ten[:9], failed()], budget=500_000)
    groups = gather(tmp_path)[1]
    table = return_tables(groups, paper)[0]
    own = {place: value for place, value in beside(table).items() if place[0] in ("rdm", "evo", "mcts")}
    assert own == {("rdm", "cube"): -0.76, ("mcts", "cube"): paper["returns", "mcts", "cube"].mean}
    assert {place[1] for place in beside(table)} == {"cube"}
    assert {"dfts", "bfts", "ppo"} < {row.label for row in table.rows}
    other = gather(tmp_path / "c")[1]
    table = return_tables(other, paper)[0]
    assert beside(table) == {}
    assert [row.label for row in table.rows] == ["rdm"]
    assert "are of 10 trials of 500,000 interactions, and stand only beside such cells" in "".join(table.notes)
    assert len(beside(return_tables(groups, of_any_budget())[0])) > 10


def test_distances_stand_beside_distances_only(tmp_path: Path) -> None:
    """A likeness, or a mean distance, is compared with nobody's distance from the farthest place."""
    other = {"chamfer": 0.25, "likeness": 0.75, "return_surface": -1.5}
    write_run(tmp_path / "a", "cube", "rdm", [trial(-1.0, **other)])
    tables = {table.name: table for table in return_tables(gather(tmp_path)[1], of_any_budget())}
    assert set(tables) >= {"returns", "returns_surface", "returns_mean", "returns_likeness"}
    named = {name for name, table in tables.items() if beside(table)}
    assert {"returns", "returns_surface"} <= named
    assert not named & {"returns_mean", "returns_likeness"}


def test_numbers() -> None:
    assert [number(value, 2) for value in (-1.005, 0.0, -0.001, 12345.678)] == ["−1.00", "0.00", "0.00", "12,345.68"]


def test_the_paper_s_values_beside_ours(four: Path) -> None:
    _, groups, _ = gather(four)
    paper = of_any_budget()
    assert len(paper) == 2 * 6 * (4 + 2)
    [table] = return_tables(groups, paper)
    assert [row.label for row in table.rows] == ["rdm", "dfts", "bfts", "mcts", "ppo", "evo"]
    cells = {(row.label, column.label): cell for (row, column), cell in table.cells.items()}
    # the paper: rdm on the cube -0.76 ± 0.13, ours -2 ± 1, so more than either; evo -0.44 ± 0.30, ours -1 ± 0.71
    assert cells["rdm", "cube"].known == Known(-0.76, 0.13, "the paper (distances between sampled points)", 2)
    assert cells["rdm", "cube"].mark == "↓"
    assert cells["evo", "cube"].mark == ""
    assert cells["ppo", "cube"].spread is None
    text = markdown([table])
    assert "| rdm | −0.2500 (1) [−0.09 ± 0.00]↓ | −2.0000 ± 1.0000 (3) [−0.76 ± 0.13]↓ |" in text
    assert "| ppo | – [−0.09 ± 0.01] | – [−0.68 ± 0.28] |" in text
    assert r"[$-0.76\pm 0.13$]$^{\downarrow}$" in latex([table])
    assert "In brackets: the paper (distances between sampled points). ↑" in text
    assert "In brackets: the paper. ↑" in markdown([interactions_table(groups, paper)])
    assert interactions_table(groups, paper).cell(table.rows[0], table.columns[1]).known == Known(
        73, 89, "the paper", 0
    )


def beside(table: Table) -> dict[tuple[str, str], float]:
    """The means beside ours, by label."""
    return {(r.label, c.label): cell.known.mean for (r, c), cell in table.cells.items() if cell.known is not None}


def test_known_values_stand_only_beside_the_usual_settings(tmp_path: Path) -> None:
    variants: list[dict[str, Any]] = [{}, {}, {"certify": "none"}, {"max_crease_length": 4}, {"budget": 9000}]
    for seed, settings in enumerate(variants):  # most runs have the usual settings
        write_run(tmp_path / str(seed), "cube", "rdm", {seed: trial(-1.0)}, **settings)
    write_run(tmp_path / "bowl", "bowl", "rdm", [trial(-1.0)], budget=9000)
    _, groups, _ = gather(tmp_path)
    paper = of_any_budget()
    for table, value in ((return_tables(groups, paper)[0], -0.76), (interactions_table(groups, paper), 73)):
        assert {row.label for row in table.rows} > {"rdm", "rdm (budget=9000)"}
        assert [column.label for column in table.columns[1:]] == [
            "cube (max_crease_length=4)",
            "cube (certify=none)",
            "bowl",
        ]
        ours = {place: known for place, known in beside(table).items() if place[0].startswith("rdm")}
        assert ours == {("rdm", "cube"): value}
        assert len(beside(table)) == 1 + 5 * 2  # the searchers that only the paper has


def test_the_paper_s_values_stand_beside_what_was_run_as_published(tmp_path: Path) -> None:
    published: dict[str, Any] = {"objective__distance": "sampled", "certify": "none", "stuck": "penalise"}
    for task in ("cube", "bowl"):
        write_run(tmp_path / task, task, "evo", [trial(-1.0)], search__rescale=True)
        write_run(tmp_path / f"{task}-plain", task, "evo", [trial(-1.0)], search__rescale=False)
        write_run(tmp_path / f"{task}-dfts", task, "dfts", [trial(-1.0)], search__restarts=200)
    write_run(tmp_path / "bucket", "bucket", "evo", [trial(1.0)], search__rescale=True)
    write_run(tmp_path / "evo", "bowl_as_published", "evo", [trial(-1.0)], search__rescale=False, **published)
    write_run(tmp_path / "dfts", "bowl_as_published", "dfts", [trial(-1.0)], search__restarts=10, **published)
    # the usual settings are those of most runs
    write_run(tmp_path / "table", "table", "evo", [trial(1.0)], search__rescale=True)
    _, groups, _ = gather(tmp_path)
    plain = "evo (search.rescale=false)"
    columns = ["cube", "bowl", "bowl_as_published", "bucket", "table"]
    assert labels(groups) == (["dfts", "evo", plain], columns)
    table = return_tables(groups, of_any_budget())[0]
    both = "dfts: cube, bowl with search.restarts=200; bowl_as_published with search.restarts=10."
    assert {both, "evo, where nothing else is said: search.rescale=true."} < set(table.notes)
    known = beside(table)
    ours = {place: value for place, value in known.items() if place[0] in ("dfts", "evo", plain)}
    assert ours == {
        ("dfts", "cube"): -0.07,
        ("dfts", "bowl"): -0.85,
        ("dfts", "bowl_as_published"): -0.85,
        ("evo", "cube"): -0.44,
        ("evo", "bowl"): -1.09,
        (plain, "bowl_as_published"): -1.09,
    }


def test_as_published_the_paper_s_values_are_those_of_its_tasks() -> None:
    paper = read_beside("paper")
    copies = {key: known for key, known in paper.items() if key[2].endswith("_as_published")}
    assert {key[2] for key in copies} == {"bowl_as_published", "face_as_published"}
    for (table, method, task), known in copies.items():
        assert known == paper[table, method, task.removesuffix("_as_published")]


HEAD = ",".join(COLUMNS) + "\n"


@pytest.mark.parametrize(
    ("text", "why"),
    [
        (HEAD + "a,b,returns,-1,-2,\n", "line 2: std must be 0 or more"),
        (HEAD + "a,b,returns,-1,,,more\n", "line 2: must have 6 cells"),
        (HEAD + "a,b,returns,-1,,x\na,b,returns,-1\n", "line 3: must have 6 cells"),
        (HEAD.strip() + ",more\na,b,returns,-1,,x,1\n", "line 1: must have the columns .* and no others"),
        (HEAD + "a,b,returns,-1,,\nc,b,returns,-1,,\na,b,returns,-2,,\n", "line 4: must not say again what line 2"),
        (HEAD.strip() + ",trials\na,b,returns,-1,,x,ten\n", "line 2: trials must be a whole number"),
        (HEAD.strip() + ",budget,budget\n", "line 1: must have the columns"),
        (None, "must be paper or a CSV file"),
        ("task,method\n", "there is no table, mean, std, source"),
        ("task,method,table,mean,std,source\na,b,returns,x,,\n", "line 2: mean and std must be numbers"),
        ("task,method,table,mean,std,source\na,b,other,1,,\n", "line 2: table must be returns or interactions"),
    ],
)
def test_files_beside_that_are_none(tmp_path: Path, text: str | None, why: str) -> None:
    file = tmp_path / "beside.csv"
    if text is not None:
        file.write_text(text, encoding="utf-8")
    with pytest.raises(InputError, match=why):
        read_beside(str(file))


def test_polished_designs_have_a_table_of_their_own(tmp_path: Path) -> None:
    """By hand: −0.5 and −0.7 make −0.6; the trial without one does not count, nor does it change the other tables."""
    polished = [trial(-1.0, polish="ok", polished_return=value) for value in (-0.5, -0.7)]
    write_run(tmp_path / "a", "bowl", "lns", [*polished, trial(-1.0)])
    write_run(tmp_path / "b", "bowl", "rdm", [trial(-2.0)])
    first, *others = return_tables(gather(tmp_path / "a", tmp_path / "b")[1])
    assert [table.name for table in others] == ["returns_polished"]
    row = {row.label: row for row in first.rows}
    [column] = first.columns
    spread = others[0].cell(row["lns"], column).spread
    assert spread is not None
    assert (spread.mean, spread.n) == (pytest.approx(-0.6), 2)
    assert others[0].cell(row["rdm"], column).spread is None
    own = first.cell(row["lns"], column).spread
    assert own is not None
    assert (own.mean, own.n) == (-1.0, 3)


def test_places_evaluated_have_a_row_of_their_own_below_their_searcher_s(tmp_path: Path) -> None:
    write_run(tmp_path / "a", "bowl", "lns", [trial(-1.0, places_evaluated=places) for places in (1000, 3000)])
    write_run(tmp_path / "b", "bowl", "rdm", [trial(-2.0, places_evaluated=0)])
    groups = gather(tmp_path / "a", tmp_path / "b")[1]
    table = interactions_table(groups)
    assert [row.label for row in table.rows] == ["lns", "lns (places evaluated)", "rdm"] or [
        row.label for row in table.rows
    ] == ["rdm", "lns", "lns (places evaluated)"]
    own = next(row for row in table.rows if "places" in row.label)
    spread = table.cell(own, table.columns[0]).spread
    assert spread is not None
    assert (spread.mean, spread.n) == (2.0, 2)  # thousands
    assert any("without being played" in note for note in table.notes)
    assert "places evaluated" not in csv_text([return_tables(groups)[0]], groups)
    assert "lns (places evaluated)" in csv_text([table], groups)
