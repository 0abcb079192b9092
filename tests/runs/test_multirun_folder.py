"""The index of a multirun: names, what stays when a multirun is extended, and the table of what was found."""

from __future__ import annotations

import csv
import io
import json
import re
import statistics
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from omegaconf import OmegaConf

from origami_lab.config.seeds import format_seeds
from origami_lab.errors import InputError
from origami_lab.machine import usable_cores
from origami_lab.multirun.check_jobs import enter_job
from origami_lab.multirun.folder_of_command import multirun_folder
from origami_lab.multirun.launchers import LAUNCHERS, cores_of_job, launcher_settings
from origami_lab.runs.multirun_folder import (
    Index,
    PlannedJob,
    begun_seeds,
    membership,
    new_index,
    outcomes,
    read_index,
    table_text,
    write_index,
)
from origami_lab.runs.trial_row import format_trials
from tests.small_runs import inside, trial_row

PAIRS = [(target, search) for target in ("cube", "bowl") for search in ("rdm", "evo")]
GRID = [[f"target={target}", f"search={search}", "budget=10"] for target, search in PAIRS]


def folders(index: Index) -> list[str]:
    return [job.folder for job in index.jobs]


@pytest.mark.parametrize(
    ("jobs", "names"),
    [
        (GRID, ["cube-rdm", "cube-evo", "bowl-rdm", "bowl-evo"]),
        ([["target=cube", "seed=0..4"]], ["cube"]),
        ([["budget=10"]], ["job"]),
        ([["search.population=8"], ["search.population=16"]], ["population=8", "population=16"]),
        (
            [["board.size=9", "start.size=1"], ["board.size=11", "start.size=2"]],
            ["board.size=9-start.size=1", "board.size=11-start.size=2"],
        ),
        ([["experiment=paper/bowl"], ["experiment=paper/cube"]], ["paper_bowl", "paper_cube"]),
        ([["seed=[0,1]"], ["seed=[2]"]], ["seed=_0_1", "seed=_2"]),
        ([["task=A"], ["task=a"]], ["task=A", "task=a_2"]),
        ([["target.path=../x/part.stl"], ["target.path=../y/part.stl"]], ["path=.._x_part.stl", "path=.._y_part.stl"]),
        ([["+search.sigma=0.1"], ["+search.sigma=1"]], ["sigma=0.1", "sigma=1"]),
    ],
)
def test_folders_are_named_by_what_differs(jobs: list[list[str]], names: list[str]) -> None:
    index = Index("x").planned(jobs)
    assert folders(index) == names
    assert len({name.casefold() for name in folders(index)}) == len(jobs)
    assert all("/" not in name and not name.startswith(".") for name in folders(index))
    assert [index.find(job) for job in jobs] == list(index.jobs)


@pytest.mark.parametrize(
    ("varied", "name"),
    [
        ({"target": "bowl", "search": "evo"}, "bowl · evo"),
        ({"search.population": "64"}, "population=64 · bowl · evo"),
        ({"target": "bowl", "seed": "0..1", "search.sigma": "1"}, "seed=0..1 · sigma=1 · bowl · evo"),
    ],
)
def test_a_name_begins_with_what_differs(varied: dict[str, str], name: str) -> None:
    job = PlannedJob("x", (), varied, "bowl", "evo")
    assert job.name == name
    assert Index("x", (PlannedJob("y", (), {}), job)).heading(job) == f"job 2 of 2: {name}"


def test_long_values_make_short_names() -> None:
    index = Index("x").planned([[f"target.path={'a' * 300}{end}"] for end in "xy"])
    assert all(len(name) < 120 for name in folders(index))
    assert len(set(folders(index))) == 2


def test_the_same_job_twice_is_refused() -> None:
    with pytest.raises(InputError, match="seed=1: makes the same job twice"):
        Index("x").planned([["target=cube", "seed=1"], ["target=cube", "seed=1"]])
    # other words for the same seeds
    with pytest.raises(InputError, match=r"seed=0\.\.1: makes the same job twice"):
        Index("x").planned([["seed=[1,0]", "workers=1"], ["seed=0..1", "workers=1"]], [(1, 0), (0, 1)])


def test_an_extended_multirun_keeps_its_folders() -> None:
    first = Index("x").planned([[f"target={name}", "search=rdm", "seed=0..1"] for name in ("cube", "bowl")])
    assert folders(first) == ["cube", "bowl"]
    # other seeds are the same job, another searcher is another one, and what is not asked for stays known
    asked = [["seed=0..9", "target=bowl", f"search={name}", "workers=1"] for name in ("evo", "rdm")]
    longer = first.planned(asked)
    assert folders(longer) == ["cube", "bowl", "bowl-evo"]
    assert [longer.find(job) for job in asked] == [longer.jobs[2], longer.jobs[1]]
    assert longer.id == first.id
    # but a seed that tells jobs apart does
    seeds = Index("x").planned([["seed=0"], ["seed=1"]])
    assert folders(seeds.planned([["seed=1"], ["seed=2"]])) == ["seed=0", "seed=1", "seed=2"]
    # also where the jobs of the command do not differ in it
    assert folders(seeds.planned([["seed=2"]])) == ["seed=0", "seed=1", "seed=2"]
    # and a job is named by what tells it from those that are there
    other = first.planned([["target=cube", "search=rdm", "seed=0..1", "budget=20"]])
    assert folders(other) == ["cube", "bowl", "cube-budget=20"]


def seeds_in(name: str) -> tuple[int, ...]:
    """What a folder's name says of its seeds; () if nothing."""
    found = re.search(r"seed=(\d+)(?:\.\.(\d+))?", name)
    return tuple(range(int(found[1]), int(found[2] or found[1]) + 1)) if found else ()


def test_name_seed_column_and_contents_agree_whatever_was_asked_for_before(tmp_path: Path) -> None:
    rng = np.random.default_rng(0)
    kinds = set()
    for number in range(60):
        folder, index = tmp_path / str(number), Index("x")
        for _ in range(4):
            spans = rng.integers(0, 4, (int(rng.integers(1, 3)), 2))
            seeds = sorted({tuple(range(low, low + more + 1)) for low, more in spans.tolist()})
            budgets = rng.permutation([500, 600])[: rng.integers(1, 3)]
            asked = [(budget, own) for budget in budgets for own in seeds]
            jobs = [[f"budget={budget}", f"seed={own[0]}..{own[-1]}"] for budget, own in asked]
            index = index.planned(jobs, [own for _, own in asked])
            for overrides, (budget, own) in zip(jobs, asked, strict=True):
                job = index.find(overrides)
                assert job is not None
                path = folder / job.folder
                holds = sorted({*begun_seeds(path), *own})
                place = index.jobs.index(job)
                jobs_now = (*index.jobs[:place], replace(job, seeds=format_seeds(holds)), *index.jobs[place + 1 :])
                index = replace(index, jobs=jobs_now)
                path.mkdir(parents=True, exist_ok=True)
                (path / "budget").write_text(str(budget))
                (path / "config.yaml").write_text(f"seed: {format_seeds(holds)}\n")
        for row in csv.DictReader(io.StringIO(table_text(outcomes(folder, index)))):
            held = begun_seeds(folder / row["folder"])
            kinds.add("seed" in row)
            assert int(row["asked"]) == len(held)
            assert seeds_in(row["folder"]) in ((), held), row
            if "seed" in row:
                assert row["seed"] == str(format_seeds(held))
            if "budget" in row:
                assert row["budget"] == (folder / row["folder"] / "budget").read_text()
    assert kinds == {True, False}


def test_the_index_on_disk(tmp_path: Path) -> None:
    index = new_index(tmp_path / "my sweep").planned(GRID)
    assert index.id.startswith("my_sweep-")
    assert index.experiment == f"multirun-{index.id}"
    write_index(tmp_path, index)
    assert read_index(tmp_path) == index
    assert membership(tmp_path / "bowl-rdm") == (index, index.jobs[2])
    assert membership(tmp_path / "other") is None
    assert membership(tmp_path) is None
    for damaged in ("", "{", "[]", '{"id": "x"}', '{"id": "x", "jobs": [{"folder": "a"}]}', '{"id": 1, "jobs": [3]}'):
        (tmp_path / "multirun.json").write_text(damaged)
        assert read_index(tmp_path) is None


def test_the_table_says_what_is_on_disk(tmp_path: Path) -> None:
    index = Index("x").planned(GRID)
    returns = [-1.5, -0.25, -3.0]
    rows = [trial_row(n, value) for n, value in enumerate(returns)]
    for name, seeds, kept in (
        ("cube-rdm", "0..2", rows),
        ("cube-evo", "0..2", rows[:2]),
        ("bowl-rdm", "3", [trial_row(3, status="failed: it")]),
    ):
        (tmp_path / name).mkdir()
        (tmp_path / name / "config.yaml").write_text(f"seed: {seeds}\n")
        (tmp_path / name / "trials.csv").write_text(format_trials(kept))
        for row in kept:
            if row.status == "ok":
                (tmp_path / name / f"seed={row.seed}").mkdir()
                (tmp_path / name / f"seed={row.seed}/result.json").write_text(json.dumps(row.values()))
    found = outcomes(tmp_path, index)
    assert [outcome.status for outcome in found] == ["ok", "stopped", "failed", "not run"]
    table = list(csv.DictReader(io.StringIO(table_text(found))))
    assert [row["folder"] for row in table] == folders(index)
    assert [(row["target"], row["search"]) for row in table] == PAIRS
    assert [(row["trials"], row["asked"]) for row in table] == [("3", "3"), ("2", "3"), ("0", "1"), ("0", "0")]
    # the index knows what a job was asked for that has not begun, or not with all
    asked = replace(index, jobs=tuple(replace(job, seeds="0..3") for job in index.jobs))
    more = outcomes(tmp_path, asked)
    assert [(outcome.status, outcome.asked) for outcome in more] == [
        *(("stopped", 4), ("stopped", 4), ("failed", 4), ("not run", 4)),
    ]
    assert float(table[0]["return_mean"]) == pytest.approx(statistics.fmean(returns))
    assert float(table[0]["return_std"]) == pytest.approx(statistics.stdev(returns))
    assert (table[0]["best_return"], table[0]["best_seed"], table[0]["interactions"]) == ("-0.25", "1", "30")
    assert table[3]["return_mean"] == table[3]["best_return"] == ""


@pytest.mark.parametrize(
    ("overrides", "field"),
    [
        (["output=a,b"], "output"),
        (["output='x/${task}'"], "output"),
        (["output=x", "hydra.sweep.dir=y"], "hydra.sweep.dir"),
        (["resume=true"], "resume"),
    ],
)
def test_a_multirun_has_one_folder(overrides: list[str], field: str, tmp_path: Path) -> None:
    with inside(tmp_path), pytest.raises(InputError) as error, multirun_folder(overrides):
        pass
    assert error.value.field == field
    assert list(tmp_path.iterdir()) == []


def test_where_a_multirun_goes(tmp_path: Path) -> None:
    with inside(tmp_path):
        with multirun_folder(["output='my sweep'"]) as folder:
            assert folder == Path("my sweep")
        with multirun_folder(["hydra.sweep.dir='x/${now:%Y}'"]) as folder:
            assert folder.parent == Path("x")
            assert folder.name.isdigit()
        assert list(tmp_path.iterdir()) == []
        with multirun_folder(["target=a,b"]) as first, multirun_folder([]) as second:
            assert first.parent == second.parent == Path("results/multirun")
            assert first != second
            (second / "multirun.json").touch()
        # nothing was written to the first one
        assert list(Path("results/multirun").iterdir()) == [second]
        with pytest.raises(InputError, match=str(second)), multirun_folder(["resume=true"]):
            pass


def test_a_launcher_that_is_not_there_names_its_extra(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("origami_lab.multirun.launchers.find_spec", lambda name: None)
    for name, launcher in LAUNCHERS.items():
        with pytest.raises(InputError, match=rf"hydra/launcher={name}: needs pip install 'origami-lab\[\w+\]'"):
            launcher_settings([f"hydra/launcher={name}"])
        assert f"[{launcher.extra}]" in (Path(__file__).parents[2] / "docs/scaling.md").read_text(encoding="utf-8")
    assert launcher_settings(["hydra/launcher=basic"]) == launcher_settings([]) == ()


def test_cores_are_shared_among_the_jobs_of_one_machine() -> None:
    cores = usable_cores()
    for n_jobs, share in ((-1, 1), (1, cores), (cores, 1), (2 * cores, 1)):
        assert cores_of_job(OmegaConf.create({"n_jobs": n_jobs})) == share
    assert cores_of_job(OmegaConf.create({"ray": {"init": {}, "remote": {"num_cpus": 3}}})) == 3
    assert cores_of_job(OmegaConf.create({"ray": {"init": {}, "remote": {}}})) == 1
    assert cores_of_job(OmegaConf.create({"timeout_min": 60, "cpus_per_task": 5})) == 5
    assert cores_of_job(OmegaConf.create({"timeout_min": 60, "cpus_per_task": None})) is None


def test_a_job_finds_its_folder_wherever_it_runs(tmp_path: Path) -> None:
    index = Index("x").planned(GRID)
    (tmp_path / "out").mkdir()
    write_index(tmp_path / "out", index)
    hydra = OmegaConf.create(
        {
            "launcher": {"ray": {"remote": {"num_cpus": 2}}},
            "sweeper": {"_target_": "hydra._internal.core_plugins.basic_sweeper.BasicSweeper"},
            "overrides": {"task": GRID[2]},
            "job": {"num": 7},
        }
    )
    config = OmegaConf.create({"output": "out", "resume": True, "workers": "auto"})
    with inside(tmp_path):
        Path("elsewhere").mkdir()
        with inside(tmp_path / "elsewhere"):
            assert enter_job(config, hydra, Path("out"), tmp_path) == "bowl-rdm"
            assert Path.cwd() == tmp_path
        assert config == {"output": "out/bowl-rdm", "resume": False, "workers": 2, "open": False}
        # a cluster starts a job again whose node died: it has begun, and goes on
        Path("out/bowl-rdm").mkdir()
        Path("out/bowl-rdm/config.yaml").touch()
        again = OmegaConf.create({"output": "out", "resume": False, "workers": 1})
        assert enter_job(again, hydra, Path("out"), tmp_path) == "bowl-rdm"
        assert again == {"output": "out/bowl-rdm", "resume": True, "workers": 1, "open": False}
        hydra.overrides.task = ["budget=11"]
        with pytest.raises(InputError, match=r"^output=out: has no job budget=11 in its multirun.json"):
            enter_job(again, hydra, Path("out"), tmp_path)
        # a sweeper that makes up its jobs has them numbered
        hydra.sweeper._target_ = "somebody.s.OptunaSweeper"
        assert enter_job(again, hydra, Path("out"), tmp_path) == "7"
