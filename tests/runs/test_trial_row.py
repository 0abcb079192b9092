"""The table of trials."""

from __future__ import annotations

import io
import json
import math
from pathlib import Path
from typing import Any

import pytest
from hypothesis import given
from hypothesis import strategies as st
from rich.console import Console

from origami_lab.experiment.terminal_table import (
    certificate_lines,
    end_lines,
    figure_lines,
    hint,
    places_line,
    polish_lines,
    summary_table,
    surface_line,
    where_lines,
)
from origami_lab.lengths import smallest_sheet
from origami_lab.runs.trial_row import (
    COLUMNS,
    KINDS,
    VERDICTS,
    Spread,
    TrialRow,
    best_row,
    format_trials,
    read_trials,
    spreads,
)
from origami_lab.verification.certificate import CERTIFIED, REFUTED, UNDECIDED
from tests.small_runs import trial_row as row

finite = st.floats(allow_nan=False, allow_infinity=False)
values = {
    int: st.none() | st.integers(0, 10**9),
    float: st.none() | finite,
    str: st.sampled_from([None, "certified", "refuted", "not certifiable"]),
}
needed = {"seed": st.integers(0, 10**9), "return": finite, "interactions_to_best": st.integers(0, 10**9)}
rows = st.lists(
    st.fixed_dictionaries(
        {column: values[kind] for column, kind in KINDS.items()}
        | needed
        | {"status": st.sampled_from(["ok", "stopped", "no design", 'failed: it said "no", twice'])}
        | {"polish": st.sampled_from([None, "ok", "time limit", "stopped", "failed: not certified"])}
    ).map(TrialRow.from_values),
    max_size=5,
    unique_by=lambda row: row.seed,
)


def test_columns_begin_with_the_documented_ones() -> None:
    assert ", ".join(COLUMNS).startswith(
        "seed, return, return_vertex, return_surface, return_sampled, driving_angle, interactions, "
        "interactions_to_best, seconds, interactions_per_second, vertices, creases, panels, reach, status"
    )


@given(rows)
def test_the_file_keeps_every_bit(tmp_path_factory: Any, trials: list[TrialRow]) -> None:
    path = Path(tmp_path_factory.mktemp("table")) / "trials.csv"
    path.write_text(format_trials(trials), encoding="utf-8")
    assert read_trials(path) == sorted(trials, key=lambda trial: trial.seed)
    assert [TrialRow.from_values(json.loads(json.dumps(trial.values()))) for trial in trials] == trials


@pytest.mark.parametrize(
    "damage",
    [
        {"return": math.nan},
        {"return": "-1.0"},
        {"return": None},
        {"seed": 1.5},
        {"seed": True},
        {"seed": None},
        {"status": None},
        {"status": "fine"},
        {"status": 3},
        {"interactions": 2.0},
        {"vertices": "many"},
        {"certificate": 1},
        {"polish": "nearly"},
        {"polished_return": math.inf},
        {"interactions_to_best": None},
    ],
)
def test_a_damaged_row_is_no_row(damage: dict[str, Any]) -> None:
    whole = row(0, -1.0).values()
    assert TrialRow.from_values(whole | {"a column of later versions": [1]}) == row(0, -1.0)
    with pytest.raises(ValueError, match=next(iter(damage))):
        TrialRow.from_values(whole | damage)


def test_a_failed_row_needs_no_more_than_a_reason() -> None:
    failed = TrialRow.failed(3, "ValueError: x: y")
    assert failed.values() == {"seed": 3, "status": "failed: ValueError: x: y"}
    assert (failed.outcome, failed.reason, failed.has_failed) == ("failed", "ValueError: x: y", True)
    assert not failed.spent_budget


def test_mean_and_sample_deviation_of_the_trials_that_spent_their_budget() -> None:
    # 1, 2, 3: mean 2, sample standard deviation 1 by hand
    found = spreads(
        [row(0, 1.0), row(1, 2.0, "no design"), row(2, 3.0), row(3, 99.0, "stopped"), row(4, None, "failed: x")]
    )
    assert (found["return"].mean, found["return"].std, found["return"].n) == (2.0, 1.0, 3)
    assert "return_vertex" not in found
    assert spreads([row(0, -1.0)])["return"].std is None


def test_best_is_the_highest_return_and_the_lowest_seed() -> None:
    best = best_row([row(0, -2.0), row(7, -1.0), row(3, -1.0), row(4, None, "failed: x")])
    assert best is not None
    assert best.seed == 3
    assert best_row([row(0, None, "failed: x")]) is None


def test_fits_a_terminal_of_80_columns() -> None:
    kinds = {int: 1, float: -1.2345}
    numbers: dict[str, Any] = {
        "return_" if name == "return" else name: kinds[kind] for name, kind in KINDS.items() if kind is not str
    }
    long = {"status": "failed: a long story", "interactions_to_best": 499_999}
    trials = [TrialRow(**(numbers | {"seed": seed, "return_surface": -1.3} | long)) for seed in range(10)]
    out = io.StringIO()
    Console(file=out, width=80).print(summary_table(trials, "a title"))
    lines = out.getvalue().splitlines()
    assert all(len(line) <= 80 for line in lines)
    assert "…" not in out.getvalue()
    assert sum("failed" in line for line in lines) == 10


def test_a_number_that_is_missing_is_a_dash() -> None:
    out = io.StringIO()
    Console(file=out, width=80).print(summary_table([row(0, -1.0), row(1, None, "failed: x")]))
    assert "nan" not in out.getvalue()


def test_a_narrow_terminal_gets_what_matters_most() -> None:
    trials = [row(0, -1.25, return_surface=-2.5, driving_angle=90.0, vertices=16)]
    out = io.StringIO()
    Console(file=out, width=40).print(summary_table(trials, width=40))
    assert "-1.2500" in out.getvalue()
    assert "90.0" in out.getvalue()
    assert "…" not in out.getvalue()


def test_certificates_are_counted_and_a_refuted_one_is_a_warning() -> None:
    assert VERDICTS == (CERTIFIED, REFUTED, UNDECIDED)
    assert certificate_lines([row(0, -1.0)]) == []  # a run from before there were any
    rows = [row(seed, -1.0, certificate=CERTIFIED) for seed in (2, 1)]
    assert certificate_lines([row(0, -1.0), *rows]) == ["certificates: 2 certified"]
    rows += [row(seed, -1.0, certificate=REFUTED) for seed in (7, 4)]
    counted, warning = certificate_lines(rows)
    assert counted == "certificates: 2 certified, 2 refuted"
    assert warning.startswith("warning: seed 4, 7: the best design is refuted")


def test_polished_designs_are_averaged_and_the_best_of_them_is_named() -> None:
    """Gains do not follow ranks: the best polished one is of another seed."""
    rows = [
        row(0, -1.0, polish="ok", polished_return=-0.9, polished_driving_angle=30.0),
        row(1, -2.0, polish="time limit", polished_return=-0.5, polished_driving_angle=20.0),
        row(2, -3.0, polish="failed: refuted"),
        row(3, -4.0, polish="stopped", polished_return=-4.0, polished_driving_angle=20.0),
    ]
    assert spreads(rows[:2])["polished_return"].mean == pytest.approx(-0.7)
    best = best_row(rows, "polished_return")
    assert best is not None
    assert best.seed == 1
    first, *others = polish_lines(rows)
    assert first.startswith("polished: best -0.5000 (seed 1, 1.5000 better), driving angle 20.00°, mean -1.8000")
    assert [line.split(":")[0] for line in others] == ["polish of seed 1", "polish of seed 3", "polish of seed 2"]
    assert polish_lines([row(0, -1.0)]) == []
    assert [r.may_be_polished for r in rows] == [False, False, False, True]
    assert [row(0, -1.0, status).may_be_polished for status in ("ok", "stopped", "no design")] == [True, False, False]


def test_where_vertices_flatter_a_design_is_said() -> None:
    """By more than a tenth of what the surface says, and by more than surfaces are measured to."""
    distances = {
        0: (-1.0, -1.1),
        1: (-1.0, -1.12),
        2: (-0.0001, -0.0009),
        3: (-2.0, -2.0),
        4: (None, None),
        5: (-0.01, -0.02),
    }
    rows = [
        row(seed, -1.0, return_vertex=vertex, return_surface=surface, chamfer=0.5, likeness=0.75, return_percent=-20.0)
        for seed, (vertex, surface) in distances.items()
    ]
    assert [r.seed for r in rows if r.surface_is_worse] == [1, 5]
    [best] = figure_lines(rows)
    assert best == (
        "best (seed 0): 1 cells from the target = 20 % of the target's size; on average 0.5 cells; likeness 0.75"
    )
    worse = surface_line(rows)
    assert worse is not None
    assert worse.startswith("seed 1, 5: by surface the design is further from the target")
    assert surface_line(rows[:1]) is None
    assert figure_lines([row(0, 3.0), row(2, 4.0)]) == ["best (seed 2): return 4.0000"]  # no target
    [met] = figure_lines([row(0, -7.8e-17, chamfer=2.7e-17, likeness=1.0)])
    assert met.startswith("best: 0 cells from the target; on average 0 cells")  # but for rounding
    assert figure_lines([row(0, -9.0, "no design")]) == []


def test_the_end_names_the_best_picture_and_the_page(tmp_path: Path) -> None:
    rows = [row(0, -1.0), row(1, -2.0, polished_return=-0.5), row(2, -9.0, "no design")]
    assert where_lines(rows, tmp_path) == []
    for name in ("seed=0/folded.png", "seed=1/folded.png", "index.html"):
        (tmp_path / name).parent.mkdir(exist_ok=True)
        (tmp_path / name).touch()
    page = f"all of it: {tmp_path / 'index.html'}"
    assert where_lines(rows, tmp_path) == [f"its picture: {tmp_path / 'seed=0/folded.png'}", page]
    (tmp_path / "seed=1/polished.png").touch()
    assert where_lines(rows, tmp_path) == [f"its picture: {tmp_path / 'seed=1/polished.png'}", page]
    # of the design that the picture shows
    for seed in (0, 1):
        (tmp_path / f"seed={seed}/pattern.cut.pdf").touch()
    made = f"to cut it: origami-lab export {tmp_path / 'seed=1/polished.fold'} --to cut"
    assert where_lines(rows, tmp_path)[1:] == [made, page]
    (tmp_path / "seed=1/polished.png").unlink()
    assert where_lines(rows, tmp_path)[1:] == [f"to cut: {tmp_path / 'seed=0/pattern.cut.pdf'}", page]


def test_what_cannot_be_certified_is_said_with_what_may_be() -> None:
    counts, words = certificate_lines([row(0, -1.0, certificate="not certifiable", driving_angle=90.0)])
    assert counts == "certificates: 1 not certifiable"
    assert "driving_angle.max=89.5" in words


@pytest.mark.parametrize(
    ("sides", "name"), [((190.0, 277.0), "A4"), ((277.0, 190.0), "A4"), ((190.1, 277.0), "A3"), ((900.0, 900.0), None)]
)
def test_the_smallest_sheet_has_room_for_its_margins(sides: tuple[float, float], name: str | None) -> None:
    assert smallest_sheet(*sides) == name


@pytest.mark.parametrize(
    ("mean", "std", "n", "shown"),
    [
        (-1.2581, 0.1728, 3, "-1.26 ± 0.17"),  # known to 0.0998
        (-1.2581, 0.1728, 2, "-1.3 ± 0.2"),
        (-0.51234, 0.0001, 10, "-0.5123 ± 0.0001"),
        (123.456, 20.0, 4, "123 ± 20"),
        (-1.0, 0.0, 5, "-1.0000 ± 0.0000"),
        (-1.23456, None, 1, "-1.2346"),
        (-1e-16, None, 1, "0.0000"),
        (-1e-16, 3e-17, 5, "0.0000 ± 0.0000"),
    ],
)
def test_means_are_rounded_to_what_they_are_worth(mean: float, std: float | None, n: int, shown: str) -> None:
    assert Spread(mean, std, n).rounded == shown


def test_lengths_on_paper_and_in_the_file_are_said() -> None:
    paper = {"cell_mm": 5.0, "return_mm": -2.0, "width_mm": 70.0, "height_mm": 60.0, "return_units": -1.6}
    best, size = figure_lines([row(0, -0.4, chamfer=0.1, likeness=1.0, return_percent=-2.0, **paper)])
    assert "0.4 cells from the target = 1.6 units of the file = 2 mm on paper = 2 % of the target's size" in best
    assert size == "its pattern is 70 × 60 mm and fits A6, 5 mm a board cell"


def test_trials_that_ended_early_are_named() -> None:
    ends = ["budget", "target return", "minutes", "minutes", None]
    goal, clock = end_lines([row(seed, -1.0, ended=end) for seed, end in enumerate(ends)])
    assert goal == "seed 1: ended by target_return, which it has reached"
    assert clock.startswith("seed 2, 3: ended by minutes")
    assert "not reproducible by the seed alone" in clock


def test_figures_are_averaged_as_returns_are() -> None:
    rows = [row(0, -1.0, likeness=0.5, chamfer=0.2), row(1, -1.0, likeness=1.0, chamfer=0.4), row(2, -1.0)]
    found = spreads(rows)
    assert (found["likeness"].mean, found["likeness"].n) == (0.75, 2)
    assert found["chamfer"].mean == pytest.approx(0.3)


def test_places_that_were_evaluated_are_said() -> None:
    assert places_line([row(0, -1.0), row(1, -1.0, places_evaluated=0)]) is None
    said = places_line([row(0, -1.0, places_evaluated=1500), row(1, -1.0, places_evaluated=500)])
    assert said == "places evaluated without being played: 2,000"


def test_a_trial_without_a_design_brings_advice() -> None:
    assert hint([row(0, -1.0)]) is None
    advice = hint([row(0, -1.0), row(1, -8.0, "no design")])
    assert advice is not None
    assert advice.startswith("1 trial found no design")
    assert "budget" in advice
