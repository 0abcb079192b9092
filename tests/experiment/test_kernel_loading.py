"""Kernels that are compiled by two processes at once."""

from __future__ import annotations

import pytest

from origami_lab.caches import KernelCache
from origami_lab.config.compose import compose_settings
from origami_lab.experiment import kernel_loading
from origami_lab.experiment.kernel_loading import can_compile_beside, load_beside


@pytest.mark.parametrize(
    "words",
    [
        ["target=bowl", "search=rdm"],
        ["target=pyramid", "objective.distance=surface"],
        ["target=bowl", "objective.distance=sampled", "files=designs"],
        ["objective=shelf", "search=evo"],
        ["+experiment=paper/table"],
    ],
)
def test_what_is_compiled_beside_a_run_is_what_can_be_played(words: list[str]) -> None:
    load_beside(compose_settings([*words, "tracking=none"]))


def test_a_second_process_compiles_where_there_is_a_core_and_memory_for_it(monkeypatch: pytest.MonkeyPatch) -> None:
    """And where the two share a folder: else neither would find what the other compiled."""
    enough = {"usable_cores": lambda: 4, "container_cores": lambda: 2.0, "free_memory": lambda: (8 * 2**30, 16 * 2**30)}
    too_little = {"usable_cores": lambda: 1, "container_cores": lambda: 1.5, "free_memory": lambda: (2**30, 16 * 2**30)}
    for name, answer in enough.items():
        monkeypatch.setattr(kernel_loading, name, answer)
    assert can_compile_beside()
    for name, answer in too_little.items():
        with monkeypatch.context() as other:
            other.setattr(kernel_loading, name, answer)
            assert not can_compile_beside()
    with monkeypatch.context() as other:
        other.setattr(kernel_loading, "kernel_cache", lambda: KernelCache(None))
        assert not can_compile_beside()
