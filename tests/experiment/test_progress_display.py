"""What is shown while trials run."""

from __future__ import annotations

import io
from dataclasses import replace

import pytest
from rich.console import Console

from origami_lab.experiment import progress_display as progress
from origami_lab.experiment.progress_display import LiveDisplay, PlainDisplay, QuietDisplay, make_display
from origami_lab.experiment.trial_pool import Event, Started, Tick
from origami_lab.experiment.trial_progress import Progress
from origami_lab.experiment.trial_worker import Compiled, Compiling, Failed, Finished
from tests.small_runs import trial_row

ROW = trial_row(3, -0.5, interactions=100, interactions_per_second=50.0)
EVENTS = (
    Started(3),
    Tick(),
    Progress(3, 10, None),
    Progress(3, 60, -1.25),
    Finished(3, ROW, ["no motion.gif: the pen broke"]),
    Started(4),
    Failed(4, "RuntimeError: [red] herring", "Traceback ..."),
)


def shown(terminal: bool, monkeypatch: pytest.MonkeyPatch, verbosity: str = "normal") -> str:
    monkeypatch.setenv("TERM", "xterm")
    monkeypatch.setattr(progress, "LINE_EVERY", 0.0)
    out = io.StringIO()
    console = Console(file=out, force_terminal=terminal, width=100)
    with make_display(console, verbosity, [3, 4], 100) as display:
        for event in EVENTS:
            display.show(event)
        display.say("[bold] is not markup")
    return out.getvalue()


def test_plain_lines_for_a_log(monkeypatch: pytest.MonkeyPatch) -> None:
    text = shown(False, monkeypatch)
    assert "\x1b" not in text
    assert "seed 3: 60 of 100 interactions" in text
    assert "best -1.2500" in text
    assert "seed 3: 100 of 100 interactions, 50/s, best -0.5000, ok" in text
    assert "warning: seed 3: no motion.gif: the pen broke" in text
    assert "RuntimeError: [red] herring" in text
    assert "[bold] is not markup" in text


def test_a_table_for_a_terminal(monkeypatch: pytest.MonkeyPatch) -> None:
    text = shown(True, monkeypatch)
    assert "trials done" in text
    assert "best" in text


def test_quiet_shows_only_what_is_said(monkeypatch: pytest.MonkeyPatch) -> None:
    assert shown(False, monkeypatch, "quiet") == "[bold] is not markup\n"


@pytest.mark.parametrize(
    ("events", "said"),
    [
        (
            (Compiling(), Compiled(31.4), Progress(3, 10, None), Finished(3, ROW, [])),
            ["compiling the", "compiled in 31 s"],
        ),
        ((Compiled(0.0), Progress(3, 10, None), Finished(3, ROW, [])), []),
        (
            (Compiling(), Progress(3, 10, None), Finished(3, ROW, [])),
            ["compiling the", "compiled"],
        ),  # parts of a user's
        ((Compiling(), Progress(3, 10, None)), ["compiling the"]),
    ],
)
def test_compiling_is_said_while_it_happens_and_its_end_once(events: tuple[Event, ...], said: list[str]) -> None:
    out = io.StringIO()
    with make_display(Console(file=out, width=100), "normal", [3], 100) as display:
        for event in (Started(3), *events):
            display.show(event)
    found = [line for line in out.getvalue().splitlines() if line.startswith("compil")]
    assert len(found) == len(said)
    assert all(line.startswith(begin) for line, begin in zip(found, said, strict=True))


def test_compiling_is_said_to_go_on(monkeypatch: pytest.MonkeyPatch) -> None:
    out, now = io.StringIO(), [100.0]
    monkeypatch.setattr(progress.time, "monotonic", lambda: now[0])
    with make_display(Console(file=out, width=100), "normal", [3], 100) as display:
        for event in (Started(3), Compiling(), Tick(), Compiled(31.0), Tick()):
            now[0] += 15.0
            display.show(event)
    said = [line for line in out.getvalue().splitlines() if line.startswith("compil")]
    assert said == ["compiling the kernels, the first time only", "compiling for 15 s", "compiled in 31 s"]


def test_the_pace_is_that_of_the_search_alone() -> None:
    out = io.StringIO()
    with make_display(Console(file=out, width=100), "normal", [3], 100) as display:
        for event in (Started(3), Progress(3, 100, -1.0, 0.5)):
            display.show(event)
    assert "100 of 100 interactions, 200/s" in out.getvalue()


def test_the_display_fits_where_the_output_goes(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("TERM", "xterm")
    log, terminal = Console(file=io.StringIO()), Console(file=io.StringIO(), force_terminal=True)
    assert type(make_display(log, "normal", [0], 1)) is PlainDisplay
    assert type(make_display(terminal, "normal", [0], 1)) is LiveDisplay
    assert type(make_display(terminal, "quiet", [0], 1)) is QuietDisplay
    monkeypatch.setenv("TERM", "dumb")
    assert type(make_display(terminal, "normal", [0], 1)) is PlainDisplay


def test_drawing_is_said_once_and_no_design_has_no_return(monkeypatch: pytest.MonkeyPatch) -> None:
    out = io.StringIO()
    with make_display(Console(file=out, width=100), "normal", [3], 100) as display:
        for event in (Started(3), Progress(3, 100, None), Progress(3, 100, None)):
            display.show(event)
        display.show(Finished(3, replace(ROW, return_=-24.0, status="no design"), []))
    assert out.getvalue().count("drawing its pictures") == 1
    assert "seed 3: 100 interactions, 50/s, no design\n" in out.getvalue()
    assert "-24" not in out.getvalue()


def test_a_trial_without_pictures_draws_none() -> None:
    log, terminal = (Console(file=io.StringIO(), force_terminal=live, width=100) for live in (False, True))
    for console in (log, terminal):
        with make_display(console, "normal", [3], 100, draws=False) as display:
            for event in (Started(3), Progress(3, 100, -1.0)):
                display.show(event)
            if isinstance(display, LiveDisplay):
                console.print(display._table())
            display.show(Finished(3, ROW, []))
        text = console.file.getvalue()  # type: ignore[attr-defined]
        assert "seed 3: 100 of 100" in text or "writing" in text
        assert "drawing" not in text


def test_the_time_left_is_that_of_all_trials_by_the_workers() -> None:
    """In seconds: of 100 interactions at 10 a second each, with two of four trials at work."""
    display = PlainDisplay(Console(file=io.StringIO()), range(4), 100, workers=2)
    assert display.seconds_left() is None
    for event in (Started(0), Progress(0, 50, None, 5.0), Started(1), Progress(1, 50, None, 5.0)):
        display.show(event)
    assert display.seconds_left() == pytest.approx((5 + 5 + 10 + 10) / 2)
    limited = PlainDisplay(Console(file=io.StringIO()), range(2), 10**9, minutes=1, workers=2)
    for event in (Started(0), Progress(0, 50, None, 45.0)):
        limited.show(event)
    assert limited.seconds_left() == pytest.approx((15 + 60) / 2)
    last = PlainDisplay(Console(file=io.StringIO()), range(2), 100, workers=2)
    for event in (Started(0), Progress(0, 10, None, 1.0), Started(1), Progress(1, 100, None, 1.0)):
        last.show(event)
    assert last.seconds_left() == pytest.approx(9.0)  # that of the one that is behind


def test_pictures_that_take_longer_than_the_searches_are_said(monkeypatch: pytest.MonkeyPatch) -> None:
    for draws, searched, said in ((True, 1.0, True), (True, 9.0, False), (False, 1.0, False)):
        out, clock = io.StringIO(), [0.0]
        monkeypatch.setattr(progress.time, "monotonic", lambda clock=clock: clock[0])
        display = PlainDisplay(Console(file=out, width=200), range(10), 100, draws)
        for seed in range(10):
            display.show(Started(seed))
            display.show(Progress(seed, 100, -1.0, searched))
            clock[0] += 4.0
            display.show(Finished(seed, replace(ROW, seed=seed, seconds=searched), []))
        text = "took 4.0 s a trial, its search 1.0 s: files=designs leaves them out"
        assert (text in out.getvalue()) is said


def test_notes_are_not_for_the_quiet() -> None:
    out = io.StringIO()
    for verbosity in ("quiet", "normal"):
        make_display(Console(file=out), verbosity, [3], 100).note(verbosity)
    assert out.getvalue() == "normal\n"


def test_a_narrow_terminal_keeps_what_matters() -> None:
    out = io.StringIO()
    console = Console(file=out, force_terminal=True, width=40)
    display = LiveDisplay(console, [3], 100)
    for event in (Started(3), Progress(3, 60, -1.25)):
        display.show(event)
    console.print(display._table())
    line = next(line for line in out.getvalue().splitlines() if "-1.2500" in line)
    assert "running" in line
    assert "60" in line


def test_many_trials_fit_a_screen() -> None:
    out = io.StringIO()
    display = LiveDisplay(Console(file=out, force_terminal=True, width=100), range(500), 100)
    for seed in range(300):
        display.show(Finished(seed, replace(ROW, seed=seed), []))
    for seed in range(300, 304):
        display.show(Started(seed))
    assert display._table().row_count == progress.SHOWN
