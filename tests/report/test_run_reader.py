"""What a report reads, what it keeps apart, and what it leaves out and says so."""

from __future__ import annotations

import hashlib
import re
import shutil
from pathlib import Path

import pytest

from origami_lab.cli import main
from origami_lab.errors import InputError
from tests.report.runs import cell, failed, gather, labels, trial, write_run


def test_runs_are_found_at_any_depth_and_once(tmp_path: Path) -> None:
    write_run(tmp_path / "results/cube/rdm/1", "cube", "rdm", [trial(-1.0)])
    write_run(tmp_path / "results/multirun/x/0", "cube", "evo", [trial(-1.0)])
    runs, groups, notes = gather(tmp_path / "results", tmp_path / "results/cube", tmp_path / "results/cube/rdm/1")
    assert [run.method for run in runs] == ["rdm", "evo"]
    assert labels(groups) == (["rdm", "evo"], ["cube"])
    assert notes == []


def test_runs_that_differ_in_nothing_but_seeds_and_their_like_are_pooled(tmp_path: Path) -> None:
    write_run(tmp_path / "a", "cube", "rdm", {0: trial(-1.0), 1: trial(-2.0)}, workers=2)
    write_run(tmp_path / "b", "cube", "rdm", {2: trial(-3.0)}, verbosity="quiet", tracking__kind="mlflow")
    _, groups, notes = gather(tmp_path)
    assert [trial.seed for trial in cell(groups, "rdm", "cube").counted] == [0, 1, 2]
    assert notes == []


@pytest.mark.parametrize(
    ("settings", "rows", "columns"),
    [
        ({"search__population": 64}, ["rdm", "rdm (search.population=64)"], ["cube"]),
        ({"budget": 9000}, ["rdm", "rdm (budget=9000)"], ["cube"]),
        ({"certify": "none"}, ["rdm"], ["cube", "cube (certify=none)"]),
        ({"objective__distance": "sampled"}, ["rdm"], ["cube", "cube (objective.distance=sampled)"]),
        ({"symmetry__name": "y"}, ["rdm"], ["cube", "cube (symmetry=y)"]),
        ({"start___target_": "a.b.Crease"}, ["rdm"], ["cube", "cube (start=Crease)"]),
        ({"start__remove": [[-4, 2]]}, ["rdm"], ["cube", "cube (start.remove=[[-4, 2]])"]),
        ({"max_crease_length": None}, ["rdm"], ["cube", "cube (max_crease_length=null)"]),
    ],
)
def test_other_settings_are_never_pooled(
    tmp_path: Path, settings: dict[str, object], rows: list[str], columns: list[str]
) -> None:
    usual = {"search__population": 10} if "search__population" in settings else {}
    write_run(tmp_path / "a", "cube", "rdm", {0: trial(-1.0)}, **usual)
    write_run(tmp_path / "b", "cube", "rdm", {1: trial(-3.0)}, **usual)
    write_run(tmp_path / "c", "cube", "rdm", {2: trial(-2.0)}, **settings)
    _, groups, notes = gather(tmp_path)
    assert labels(groups) == (rows, columns)
    assert [trial.seed for trial in cell(groups, "rdm", "cube").counted] == [0, 1]
    assert [trial.seed for trial in cell(groups, rows[-1], columns[-1]).counted] == [2]
    assert len([note for note in notes if "where nothing else is said" in note]) == 1


def test_many_differences_have_a_number_and_a_note(tmp_path: Path) -> None:
    write_run(tmp_path / "a", "cube", "rdm", [trial(-1.0)])
    write_run(tmp_path / "b", "cube", "rdm", [trial(-1.0)], certify="none", stuck="x", a=1, b=2)
    _, groups, notes = gather(tmp_path)
    assert labels(groups) == (["rdm"], ["cube", "cube (#2)"])
    assert "cube #2: a=1, b=2, certify=none, stuck=x" in notes


def test_a_searcher_may_have_other_numbers_on_other_tasks(tmp_path: Path) -> None:
    write_run(tmp_path / "a", "cube", "evo", [trial(-1.0)], search__population=10)
    write_run(tmp_path / "b", "bowl", "evo", [trial(-1.0)], search__population=64)
    _, groups, notes = gather(tmp_path)
    assert labels(groups) == (["evo"], ["cube", "bowl"])
    assert notes == ["evo: cube with search.population=10; bowl with search.population=64"]


def test_a_mesh_file_that_changed_is_another_target(tmp_path: Path) -> None:
    for name, content in (("a", b"1"), ("b", b"1"), ("c", b"2")):
        folder = write_run(tmp_path / name, "part", "rdm", {ord(name): trial(-1.0)}, target__path="/part.stl")
        (folder / "target.ply").write_bytes(content)
    _, groups, _ = gather(tmp_path)
    assert [len(group.trials) for group in groups.cells.values()] == [2, 1]


def test_a_start_file_that_changed_is_another_start(tmp_path: Path) -> None:
    for name, content in (("a", b"1"), ("b", b"1"), ("c", b"2")):
        folder = write_run(tmp_path / name, "cube", "rdm", {ord(name): trial(-1.0)}, start__path="/mine.fold")
        (folder / "start.json").write_bytes(content)
    for name in ("d", "e"):  # what is no file of the user's is not compared
        folder = write_run(tmp_path / name, "bowl", "rdm", {ord(name): trial(-1.0)})
        (folder / "start.json").write_text(name, encoding="utf-8")
    write_run(tmp_path / "f", "bowl", "rdm", [trial(-1.0)])
    _, groups, _ = gather(tmp_path)
    [row], columns = labels(groups)
    short = hashlib.sha256(b"2").hexdigest()[:8]
    assert columns == ["cube", f"cube (start.pattern={short})", "bowl"]
    assert [len(cell(groups, row, column).trials) for column in columns] == [2, 1, 3]


def test_a_seed_counts_once(tmp_path: Path) -> None:
    write_run(tmp_path / "a", "cube", "rdm", {0: trial(-1.0), 1: failed()})
    shutil.copytree(tmp_path / "a", tmp_path / "b")
    write_run(tmp_path / "c", "cube", "rdm", {0: trial(-5.0), 1: trial(-2.0)})
    _, groups, notes = gather(tmp_path)
    assert [trial.row.return_ for trial in cell(groups, "rdm", "cube").counted] == [-1.0, -2.0]
    assert f"{tmp_path / 'a'} and {tmp_path / 'b'}: the same trials (seed 0); those of the first count" in notes
    assert any("different returns though all settings are the same (seed 0)" in note for note in notes)


def test_what_is_damaged_is_left_out_and_named(tmp_path: Path) -> None:
    good = write_run(tmp_path / "good", "cube", "rdm", {seed: trial(-float(seed)) for seed in range(5)})
    (good / "seed=1/result.json").write_text('{"seed": 1', encoding="utf-8")
    (good / "seed=2/result.json").write_text('{"seed": 2, "return": NaN, "status": "ok"}', encoding="utf-8")
    (good / "summary.json").write_text("[]", encoding="utf-8")
    shutil.rmtree(good / "seed=3")  # known from the table
    for name, config in (("bad", "a: ["), ("list", "- 1"), ("short", "task: cube\nmethod: rdm\n")):
        write_run(tmp_path / name, "cube", "rdm", [trial(-9.0)])
        (tmp_path / name / "config.yaml").write_text(config, encoding="utf-8")
    binary = write_run(tmp_path / "binary", "cube", "evo", [trial(-1.0)])
    (binary / "trials.csv").write_bytes(b"seed\xff\xfe,\n1,2")
    (binary / "summary.json").write_bytes(b"\xff")
    runs, groups, notes = gather(tmp_path)
    assert {run.folder.name for run in runs} == {"good", "binary"}
    assert [trial.seed for trial in cell(groups, "rdm", "cube").counted] == [0, 3, 4]
    assert len(cell(groups, "evo", "cube").counted) == 1
    text = "\n".join(notes)
    for name in ("bad", "list", "short"):
        assert f"{tmp_path / name}: left out, it cannot be read" in text
    for seed in (1, 2):
        assert f"{good / f'seed={seed}'}: left out, its result is damaged" in text
    assert f"{good}: not finished, 3 of 5 trials" in text
    assert f"{good}: its summary.json is damaged" in text
    assert f"{binary}: its trials.csv is damaged" in text


def test_a_run_that_goes_on_counts_as_far_as_it_is(tmp_path: Path) -> None:
    folder = write_run(tmp_path / "a", "cube", "rdm", [trial(-1.0)], seed="0..9")
    (folder / "summary.json").unlink()
    (folder / "trials.csv").unlink()
    _, groups, notes = gather(tmp_path)
    assert len(cell(groups, "rdm", "cube").counted) == 1
    assert notes == [f"{folder}: not finished, 1 of 10 trials"]


def test_nothing_to_read_is_an_error(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    (tmp_path / "empty").mkdir()
    broken = write_run(tmp_path / "broken", "cube", "rdm", [trial(-1.0)])
    (broken / "config.yaml").write_text("a: [", encoding="utf-8")
    for name, why in (("nowhere", "no such folder"), ("empty", "no run folder"), ("broken", "no run that can be read")):
        with pytest.raises(InputError, match=why):
            gather(tmp_path / name)
        assert main(["report", str(tmp_path / name)]) == 2
        error = capsys.readouterr().err
        assert error.startswith("error: DIR=")
        assert error.count("\n") == 1
        assert not (tmp_path / name / "report").exists()


def test_what_is_in_a_run_is_not_one_but_the_run_is_named(tmp_path: Path) -> None:
    run = write_run(tmp_path / "run", "cube", "rdm", [trial(-1.0)])
    (tmp_path / "file").touch()
    meant = rf"\; did you mean the run folder that it is in, {re.escape(str(run))}\?$"
    for name, why in (
        ("run/trials.csv", "must be a folder, this is a file" + meant),
        ("run/seed=0", "there is no run folder at or below it .*" + meant),
        ("file", "must be a folder, this is a file$"),
    ):
        with pytest.raises(InputError, match=why):
            gather(tmp_path / name)
