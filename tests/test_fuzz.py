"""A small slice of `python -m benchmarks.fuzz`: whatever is given, one line and the right exit code."""

from __future__ import annotations

from pathlib import Path

import pytest

from benchmarks import fuzz


@pytest.fixture(autouse=True)
def _elsewhere(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    from origami_lab.experiment import runner

    monkeypatch.chdir(tmp_path)
    # what the fuzz replaces comes back afterwards
    for name in ("TrialPool", "make_tracker"):
        monkeypatch.setattr(runner, name, getattr(runner, name))


def faults(cases: list[fuzz.Case]) -> list[tuple[str | None, list[str], str]]:
    """But for memory: here it is that of all tests before in this process."""
    return [(case.fault, case.arguments, case.error) for case in cases if case.fault not in (None, "too much memory")]


@pytest.mark.slow
def test_random_overrides_are_refused_or_understood() -> None:
    cases = [fuzz.run_inside(arguments) for arguments in fuzz.override_cases(25, seed=3)]
    assert faults(cases) == []
    # a multirun has 1 if a job has not run, and here none does
    assert {case.code for case in cases if "-m" not in case.arguments} == {0, 2}
    assert {case.code for case in cases if "-m" in case.arguments} <= {1, 2}


@pytest.mark.slow
def test_mutated_meshes_are_refused_or_read(tmp_path: Path) -> None:
    cases = [fuzz.run_inside(arguments) for arguments in fuzz.mesh_cases(16, 3, tmp_path)]
    assert faults(cases) == []
    assert {case.code for case in cases} == {0, 2}


@pytest.mark.parametrize(
    "words", ["search=rdm target.rotate={}", "target={}.stl", "target=cube start={},{}", "{}=1", "seed={}"]
)
def test_hints_do_not_repeat_what_is_very_long(words: str) -> None:
    case = fuzz.run_inside(words.format("x" * 5000, "y" * 5000).split())
    assert case.fault in (None, "too much memory")
    assert case.code == 2
    assert len(case.error) < 1500
