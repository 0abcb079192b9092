"""The page of a run and of a multirun: what a browser shows of it, and what it costs."""

from __future__ import annotations

import itertools
import json
import re
import shutil
import webbrowser
from pathlib import Path
from typing import Any

import pytest

from origami_lab.cli import main
from origami_lab.experiment import run_page
from origami_lab.experiment.multirun_page import write_multirun_page
from origami_lab.experiment.page_entries import MeanCurve, curve_of, entry_of, pattern_of, thinned
from origami_lab.experiment.run_page import RunPage, Tally, has_display, open_page, write_run_page
from origami_lab.experiment.trial_progress import Progress
from origami_lab.runs.multirun_folder import Index, PlannedJob, write_index
from origami_lab.runs.run_folder import RunFolder
from origami_lab.runs.trial_row import read_trials, spread_of
from tests.drawing.test_viewer import in_chromium, visit
from tests.report.runs import failed, trial, write_run
from tests.small_runs import trial_row

OLD = Path(__file__).parents[1] / "old_runs/fixtures"
NASTY = "<img src=x onerror=document.title=1>"


def words(dom: str) -> str:
    """What a page says, in one line."""
    body = re.sub(r"<(script|style)\b.*?</\1>", " ", dom, flags=re.DOTALL)
    return (
        " ".join(re.sub(r"<[^>]+>", " ", body).split()).replace("&lt;", "<").replace("&gt;", ">").replace("&amp;", "&")
    )


def live(folder: Path) -> Any:
    text = (folder / "index.data/live.js").read_text("ascii")
    return json.loads(text.removeprefix("live(").removesuffix(");\n"))


@in_chromium
@pytest.mark.slow
def test_a_browser_shows_a_run_from_its_files(tmp_path: Path) -> None:
    """Of version 0.1.0, which had no pages: as after a polish of one of its designs."""
    folder = shutil.copytree(OLD / "cube", tmp_path / "a run & more")
    write_run_page(folder)
    said = words(visit(folder / "index.html", "--dump-dom"))
    [row] = read_trials(folder / "trials.csv")
    assert row.return_ is not None
    assert f"return {row.return_:.4f}".replace("-", "−") in said
    assert f"finished: 1 trial · mean return {row.return_:.4f}".replace("-", "−") in said
    assert "Learning curves" in said
    assert "config.yaml" in said


@in_chromium
@pytest.mark.slow
def test_names_of_strangers_are_only_text(tmp_path: Path) -> None:
    jobs = []
    for number in range(2):
        name = f"job=+{number}"
        trials = {0: trial(-1.0), 1: failed(NASTY), 2: trial(-9.0, status="no design"), 3: trial(-0.5 - number)}
        folder = write_run(tmp_path / name, NASTY, f"m{number}", trials)
        (folder / "seed=0/best.fold").write_text(json.dumps({"vertices_coords": [[0, 0], [1, NASTY]]}))
        write_run_page(folder)
        dom = visit(folder / "index.html", "--dump-dom")
        assert "<img src=" not in dom
        assert f"failed: {NASTY}" in words(dom)
        assert f"{NASTY} · m{number}" in words(dom)
        assert f"return −{(0.5, 1.0)[number]:.4f}" in words(dom)
        jobs.append(PlannedJob(name, (f"search=m{number}",), {"search": f"m{number}"}, NASTY, f"m{number}", "0..3"))
    write_index(tmp_path, Index(f"{NASTY}-1", tuple(jobs)))
    write_multirun_page(tmp_path)
    dom = visit(tmp_path / "index.html", "--dump-dom")
    assert "<img src=" not in dom
    said = words(dom)
    assert "2 of 2 jobs finished · 8 trials" in said
    assert f"m0 {mean([-1.0, -9.0, -0.5])} −0.5000 4 of 4" in said
    assert "job%3D%2B0/index.html" in dom


def mean(values: list[float]) -> str:
    spread = spread_of(values)
    assert spread is not None
    return spread.rounded.replace("-", "−")


@in_chromium
@pytest.mark.slow
def test_the_page_rounds_as_the_terminal_does(tmp_path: Path) -> None:
    folder = write_run(tmp_path / "run", "cube", "rdm", [trial(-1.0)])
    write_run_page(folder)
    cases = [[-1.25, -1.5, -0.7], [-100.0, -300.0], [-0.5, -0.5002], [3.0, 3.0], [-1.0], [0.0, -0.00001]]
    spreads = [spread_of(values) for values in cases]
    asked = json.dumps([vars(found) for found in spreads])
    script = f"<script>document.title = JSON.stringify({asked}.map(spread))</script>"
    page = folder / "index.html"
    page.write_text(page.read_text(encoding="utf-8").replace("</body>", f"{script}</body>"), encoding="utf-8")
    title = re.search(r"<title>(.*?)</title>", visit(page, "--dump-dom"))
    assert title is not None
    expected = [found.rounded for found in spreads if found is not None]
    assert [text.replace("−", "-") for text in json.loads(title[1])] == [
        re.sub(r"-(0\.0+)\b", r"\1", text) for text in expected
    ]


def test_the_page_is_written_every_two_seconds_at_most(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    clock, written = [0.0], []
    monkeypatch.setattr(run_page.time, "monotonic", lambda: clock[0])
    monkeypatch.setattr(RunPage, "write", lambda page, state: written.append(clock[0]) or _noted(page, clock[0]))
    folder = write_run(tmp_path / "run", "cube", "rdm", [trial(-1.0)])
    page = RunPage(RunFolder(folder), RunFolder(folder).config(), 1, "")
    page.take("a worker is about to begin")
    assert written == []
    for step in range(200):
        clock[0] = 0.1 * step
        page.take(Progress(0, step, None))
    assert len(written) == pytest.approx(10, abs=1)
    assert min(later - earlier for earlier, later in itertools.pairwise(written)) >= 1.99


def _noted(page: RunPage, now: float) -> None:
    page._written, page._tried = now, True


def test_what_a_running_trial_has_found_is_on_the_page(tmp_path: Path) -> None:
    folder = write_run(tmp_path / "run", "cube", "rdm", {0: trial(-1.0), 1: trial(-2.0)})
    page = RunPage(RunFolder(folder), RunFolder(folder).config(), 3, "origami-lab")
    page.begin(RunFolder(folder).rows([0]).values())
    for step in range(1000):
        page.take(Progress(2, step, -10.0 + step / 100))
    page.write("running")
    [running] = live(folder)["running"]
    assert len(running["curve"]) <= 121
    assert (running["curve"][0], running["curve"][-1]) == ([0, -10.0], [999, -10.0 + 9.99])
    assert live(folder)["best"]["seed"] == 0
    page.end(trial_row(2, -0.5))
    page.write("finished")
    assert live(folder)["running"] == []
    assert (live(folder)["best"]["seed"], live(folder)["ended"]) == (2, 2)


def test_the_tally_is_that_of_all_trials() -> None:
    rows = [trial_row(4, -1.0), trial_row(1, -1.0), trial_row(2, -9.0, "no design"), trial_row(3, None, "failed: x")]
    rows += [trial_row(5, -0.25, "stopped")]
    tally = Tally()
    for row in rows:
        tally.add(row, {"seed": row.seed, "curve": []})
    said = tally.to_json()
    spread = spread_of([-1.0, -1.0, -9.0])
    assert spread is not None
    assert said["returns"] == pytest.approx(vars(spread))
    assert said["outcomes"] == {"ok": 2, "no design": 1, "failed": 1, "stopped": 1}
    assert said["best"] == {"seed": 5, "curve": []}


def test_a_page_that_cannot_be_written_costs_nothing(tmp_path: Path) -> None:
    folder = write_run(tmp_path / "run", "cube", "rdm", [trial(-1.0)])
    (folder / "index.data").write_text("in the way")
    write_run_page(folder)
    (tmp_path / "no run").mkdir()
    write_run_page(tmp_path / "no run")
    assert not (folder / "index.html").exists()
    assert list((tmp_path / "no run").iterdir()) == []


def test_a_page_that_cannot_be_written_is_not_tried_at_every_event(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    folder = write_run(tmp_path / "run", "cube", "rdm", [trial(-1.0)])
    (folder / "index.data").write_text("in the way")
    asked: list[int] = []
    monkeypatch.setattr(run_page, "run_page_text", lambda *arguments: asked.append(1) or "")
    page = RunPage(RunFolder(folder), RunFolder(folder).config(), 1, "")
    for step in range(1000):
        page.take(Progress(0, step, None))
    assert len(asked) <= 2


def test_no_report_takes_the_page_of_a_run_for_its_own(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    folder = write_run(tmp_path / "run", "cube", "rdm", [trial(-1.0)])
    write_run_page(folder)
    before = (folder / "index.html").read_bytes()
    assert main(["report", str(folder), "--output", str(folder)]) == 2
    assert "must be a new or empty folder, or that of an earlier report" in capsys.readouterr().err
    assert (folder / "index.html").read_bytes() == before


def test_curves_and_patterns_are_short_and_hold_what_files_say(tmp_path: Path) -> None:
    assert thinned([[k, k] for k in range(1000)], 10)[::9] == [[0, 0], [999, 999]]
    assert len(thinned([[k, k] for k in range(1000)], 10)) == 10
    assert curve_of(tmp_path / "none.csv") == []
    (tmp_path / "curve.csv").write_text("interactions,return\n1,-2\n3,nan\n5,-1\n")
    assert curve_of(tmp_path / "curve.csv") == [[1, -2.0], [5, -1.0]]
    pattern = pattern_of(OLD / "cube/seed=0/best.fold")
    document = json.loads((OLD / "cube/seed=0/best.fold").read_text())
    assert pattern is not None
    assert pattern["edges"] == document["edges_vertices"]
    assert pattern["letters"] == "".join(document["edges_assignment"])
    for broken in ("{}", "[", '{"vertices_coords": [[0, 1e999]], "edges_vertices": [], "edges_assignment": []}'):
        (tmp_path / "a.fold").write_text(broken)
        assert pattern_of(tmp_path / "a.fold") is None
    (tmp_path / "a.fold").write_text(
        '{"vertices_coords": [[0, 0]], "edges_vertices": [[0, 7]], "edges_assignment": ["M"]}'
    )
    assert pattern_of(tmp_path / "a.fold") is None


def test_the_mean_curve_is_the_mean_of_the_steps_where_every_trial_has_one() -> None:
    curves = [[[1, -4.0], [10, -2.0]], [[3, -6.0], [100, -1.0]], []]
    mean = MeanCurve(1000)
    for curve in curves:
        mean.add(curve)

    def step(curve: list[list[float]], at: float) -> float:
        return [value for when, value in curve if when <= at][-1]

    points = mean.points()
    assert [at for at, _ in points] == [at for at in mean.at if at >= 3]
    assert (mean.at[0], mean.at[-1]) == (1, 1000)
    for at, value in points:
        assert value == pytest.approx((step(curves[0], at) + step(curves[1], at)) / 2)
    assert MeanCurve(1000).points() == []


def test_a_trial_without_a_design_has_no_return_on_the_page(tmp_path: Path) -> None:
    entry = entry_of(tmp_path, trial_row(0, -24.0, "no design"), draws=True)
    assert "return" not in entry["cells"]
    assert entry["status"] == "no design"


def test_a_page_is_opened_where_there_is_a_display_only(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    opened: list[str] = []
    monkeypatch.setattr(webbrowser, "open", opened.append)
    monkeypatch.setattr(run_page.sys, "platform", "linux")
    for name in ("DISPLAY", "WAYLAND_DISPLAY"):
        monkeypatch.delenv(name, raising=False)
    assert not has_display()
    open_page(tmp_path / "index.html")
    assert opened == []
    monkeypatch.setenv("DISPLAY", ":0")
    open_page(tmp_path / "index.html")
    assert opened == [(tmp_path / "index.html").as_uri()]


def test_the_page_of_a_part_has_the_name_of_its_file() -> None:
    config = {"task": "mesh", "method": "lns", "budget": 10, "target": {"path": "parts/tray.stl"}}
    text = run_page.run_page_text(config, Path("out"), "origami-lab target=mesh")
    heading = re.search(r"<h1[^>]*>(.*?)</h1>", text, flags=re.DOTALL)
    assert heading is not None
    assert "tray" in heading[1]
