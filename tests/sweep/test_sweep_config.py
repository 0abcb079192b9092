"""What is wrong with a sweep's file is said in one line that names the key."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import pytest

from origami_lab.errors import InputError
from origami_lab.sweep.search_space import grid_points
from origami_lab.sweep.storage import check_same
from origami_lab.sweep.studies import check_comparison, check_space
from origami_lab.sweep.sweep_config import read_declaration
from tests.sweep.conftest import ROOT, SMALL, declare, write_file

SPACE = SMALL["space"]


def space(name: str, **parameter: Any) -> dict[str, Any]:
    return {"space": {**SPACE, name: parameter}}


REFUSED: list[tuple[dict[str, Any], str, str]] = [
    ({"task": None}, "task=None:", "must be given"),
    ({"task": 5}, "task=5:", "like target=bowl"),
    ({"space": {}}, "space={}:", "at least one"),
    ({"trails": 5}, "trails=5:", "did you mean trials?"),
    ({"trials": 0}, "trials=0:", "from 1"),
    ({"trials": True}, "trials=True:", "whole number"),
    ({"budget": "many"}, "budget=many:", "whole number"),
    ({"seeds": "4..0"}, "seeds=4..0:", "backwards"),
    ({"sampler": "bayes"}, "sampler.name=bayes:", "tpe, cmaes, random, grid"),
    ({"sampler": {"name": "tpe", "sede": 1}}, "sampler.sede=1:", "did you mean seed?"),
    ({"sampler": [1]}, "sampler=[1]:", "mapping"),
    ({"pruner": {"name": "halving"}}, "pruner.name=halving:", "median, none"),
    ({"workers": 0}, "workers=0:", "from 1"),
    ({"study": "a/b"}, "study=a/b:", "word"),
    ({"tracking": "wandb"}, "tracking.kind=wandb:", "mlflow, none"),
    ({"storage": [5]}, "storage=[5]:", "text"),
    ({"task": ["target=pyramid", "budget=99"]}, "task=budget=99:", "the sweep's own key budget"),
    ({"task": ["search=evo"]}, "task=search=evo:", "the sweep's own key searcher"),
    ({"task": {"seed": 5}}, "task=seed=5:", "the sweep's own key seeds"),
    (space("seed", low=0, high=9), "space=seed:", "the sweep's own key seeds"),
    (space("tracking.uri", choices=["a"]), "space=tracking.uri:", "the sweep's own key tracking"),
    (space("resume", choices=[True]), "space=resume:", "own affair"),
    ({"held_out": {"against": {"more": ["budget=9000"]}}}, "held_out.against.more=budget=9000:", "own key budget"),
    ({"pruner": "wilcoxon"}, "pruner.name=wilcoxon:", "studies that were begun with it go on with pruner=none"),
    (space("search.sigma_2", low=0.1, high=0.35, step=0.1), "space.search.sigma_2.high=0.35:", "0.3 or 0.4"),
    ({"held_out": {"seeds": "1..3"}}, "held_out.seeds=1..3:", "no seed that trials play (1)"),
    ({"held_out": {"seeds": 7}}, "held_out.seeds=7:", "at least two"),
    ({"held_out": {"against": {"best": []}}}, "held_out.against.best=[]:", "other than best"),
    (space("search.elite", low=2, high=2), "space.search.elite.low=2:", "below high"),
    (space("search.elite", low=2), "space.search.elite=", "low and high, or choices"),
    (space("search.sigma_2", low=0, high=2, log=True), "space.search.sigma_2.low=0:", "above 0 where log"),
    (space("search.sigma_2", low=0.1, high=2, log="yes"), "space.search.sigma_2.log=yes:", "true or false"),
    (space("search.sigma_2", low=0.1, high=2, log=True, step=0.1), "space.search.sigma_2.step=0.1:", "log: true"),
    (space("search.sigma_2", low=0.1, high=2, step=3), "space.search.sigma_2.step=3:", "width of the range"),
    (space("search.sigma_2", low="a", high=2), "space.search.sigma_2.low=a:", "number"),
    (space("search.elite", choices=[]), "space.search.elite.choices=[]:", "list of values"),
    (space("search.elite", choices=[1, 1]), "space.search.elite.choices=[1, 1]:", "twice"),
    (space("search.elite", choices=[[1]]), "space.search.elite.choices=[[1]]:", "plain values"),
    (space("search.elite", choices=[1, 2], low=1), "space.search.elite.low=1:", "beside choices"),
    (space("search.elite", low=0, high=1, chioces=[1]), "space.search.elite.chioces=[1]:", "did you mean choices?"),
    (
        space("search.elite", low=0, high=2, when={"search.resale": True}),
        "space.search.elite.when=search.resale:",
        "with choices that is declared above this one (search.rescale)",
    ),
    (
        space("search.elite", low=0, high=2, when={"search.rescale": 1}),
        "space.search.elite.when.search.rescale=1:",
        "one of its choices, or a list of some: true, false",
    ),
    (
        space("search.elite", low=0, high=2, when={"search.population": 8}),
        "space.search.elite.when=search.population:",
        "with choices",
    ),
    ({"sampler": "grid"}, "space.search.population=", "a step, or choices"),
    (
        {"sampler": "grid", "space": {"search.rescale": {"choices": [True, False]}}, "trials": 3},
        "trials=3:",
        "at most 2, the points of the grid",
    ),
]


@pytest.mark.parametrize(("changes", "begin", "also"), REFUSED, ids=[case[1] for case in REFUSED])
def test_refused_with_its_key(tmp_path: Path, changes: dict[str, Any], begin: str, also: str) -> None:
    with pytest.raises(InputError) as caught:
        declare(tmp_path, **changes)
    assert str(caught.value).startswith(begin)
    assert also in str(caught.value)
    assert "\n" not in str(caught.value)


@pytest.mark.parametrize(
    ("text", "also"),
    [
        ("task: [a\nsearcher: evo\n", "in line 2"),
        ("- 1\n", "must hold keys"),
        ("", "must hold keys"),
        ("searcher: evo\nsearcher: mcts\n", "duplicate key"),
        ("task: ${nowhere}\n", "nowhere"),
    ],
)
def test_a_file_that_is_none(tmp_path: Path, text: str, also: str) -> None:
    file = tmp_path / "sweep.yaml"
    file.write_text(text)
    with pytest.raises(InputError, match="sweep=") as caught:
        read_declaration(file)
    assert also in str(caught.value)


@pytest.mark.parametrize(
    ("changes", "begin", "also"),
    [
        (["trials"], "sweep=trials:", "KEY=VALUE"),
        (["trails=5"], "trails=5:", "there is no such key of a sweep"),
        (["space.search.elite=5"], "space.search.elite=5:", "there is no such key"),
        (["sampler.name=none"], "sampler.name=none:", "tpe"),
    ],
)
def test_refused_on_the_command_line(tmp_path: Path, changes: list[str], begin: str, also: str) -> None:
    file = write_file(tmp_path)
    with pytest.raises(InputError) as caught:
        read_declaration(file, changes)
    assert str(caught.value).startswith(begin)
    assert also in str(caught.value)


def test_the_command_line_wins(tmp_path: Path) -> None:
    file = write_file(tmp_path, sampler="tpe", budget=1)
    changes = ["trials=1e2", "sampler.seed=9", "seeds=[3,5]", "held_out.budget=7", "tracking=none", "storage=null"]
    found = read_declaration(file, changes)
    assert found.trials == 100
    assert (found.sampler.name, found.sampler.seed) == ("tpe", 9)
    assert found.seeds == (3, 5)
    assert found.held_out.budget == 7
    assert found.tracking.kind == "none"
    assert found.storage is None


@pytest.mark.parametrize(
    ("changes", "begin", "also"),
    [
        ({"task": ["target=ball"]}, "target=ball:", "bowl"),
        ({"searcher": "genetic"}, "search=genetic:", "evo"),
        (
            {"space": {"search.populaton": {"low": 8, "high": 9}}},
            "space.search.populaton={'low': 8, 'high': 9}:",
            "did you mean search.population?",
        ),
        (space("search.parents", low=0.1, high=0.9), "space.search.parents=0.9:", "parents of the population"),
        (space("search.stuck", choices=["score"]), "space.search.stuck={'choices': ['score']}:", "no such setting"),
        (space("search.population", low=6, high=1e2), "space.search.population=40.", "must be a whole number"),
    ],
)
def test_what_cannot_be_played(tmp_path: Path, changes: dict[str, Any], begin: str, also: str) -> None:
    with pytest.raises(InputError) as caught:
        check_space(declare(tmp_path, **changes))
    assert str(caught.value).startswith(begin)
    assert also in str(caught.value)


def test_what_cannot_be_compared_with(tmp_path: Path) -> None:
    with pytest.raises(InputError, match=r"^search.scale=1: there is no such key"):
        check_comparison(declare(tmp_path, held_out={"against": {"paper": ["search.scale=1"]}}))


def test_a_task_as_nested_mappings(tmp_path: Path) -> None:
    assert declare(tmp_path, task={"target": "bowl", "start": {"size": 2}}).task == ("target=bowl", "start.size=2")


def test_a_file_whose_name_is_no_word(tmp_path: Path) -> None:
    file = write_file(tmp_path).rename(tmp_path / "my sweep.yaml")
    with pytest.raises(InputError, match=r"^sweep=.*my sweep\.yaml: has a name that cannot be the study's"):
        read_declaration(file)
    assert read_declaration(file, ["study=mine"]).study == "mine"


def test_an_end_that_only_suits_others_is_played(tmp_path: Path) -> None:
    """An elite of 5 needs 5 parents: a population of 6 has 2, one of 24 has 6."""
    check_space(declare(tmp_path, **space("search.elite", low=0, high=5)))


def test_a_grid_leaves_out_what_its_conditions_do(tmp_path: Path) -> None:
    declared = declare(
        tmp_path,
        trials=None,
        sampler="grid",
        space={
            "search.rescale": {"choices": [True, False]},
            "search.elite": {"low": 0, "high": 4, "step": 2, "when": {"search.rescale": True}},
            "search.parents": {"low": 0.1, "high": 0.3, "step": 0.1},
        },
    )
    points = [tuple(point.values()) for point in grid_points(declared.space)]
    thirds = (0.1, 0.2, 0.3)
    expected = [(True, elite, part) for elite in (0, 2, 4) for part in thirds] + [(False, part) for part in thirds]
    assert points == expected
    assert declared.trials == 12


@pytest.mark.parametrize("file", sorted((ROOT / "sweeps").glob("*.yaml")), ids=lambda file: file.stem)
def test_the_sweeps_that_come_along(file: Path) -> None:
    declaration = read_declaration(file)
    assert declaration.study == file.stem
    assert len(declaration.held_out.seeds) >= 20
    assert file.stem == f"{declaration.searcher}_{declaration.task[0].partition('=')[2]}"
    assert any(parameter.log for parameter in declaration.space)
    assert any(parameter.when for parameter in declaration.space)
    check_space(declaration)


def test_cmaes_is_refused_without_its_extra(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("origami_lab.sweep.sweep_config.find_spec", lambda name: None)
    with pytest.raises(
        InputError, match=r"^sampler=cmaes: needs the package cmaes: pip install 'origami-lab\[cmaes\]'$"
    ):
        declare(tmp_path, sampler="cmaes")
    assert not (tmp_path / "out").exists()
    assert declare(tmp_path, sampler="tpe").sampler.name == "tpe"


def test_a_study_that_had_the_pruner_wilcoxon_goes_on_without(tmp_path: Path) -> None:
    now = declare(tmp_path, pruner="none").fixed
    before = {**now, "pruner": {"name": "wilcoxon", "startup": 5, "warmup": 1}}
    check_same("small", before, now)
    with pytest.raises(InputError, match=r"^pruner\.name=median: was wilcoxon when the study"):
        check_same("small", before, declare(tmp_path, pruner="median").fixed)
    with pytest.raises(InputError, match=r"^budget=7: was 300 "):
        check_same("small", before, {**now, "budget": 7})


def test_a_step_as_wide_as_the_range_is_taken_as_it_is_written(tmp_path: Path) -> None:
    declaration = declare(tmp_path, **space("search.sigma_2", low=0.1, high=0.3, step=0.2))
    assert declaration.space[-1].values() == (0.1, 0.3)
