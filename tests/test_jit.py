"""Kernels that make no arrays count no references, where this version of numba can do without."""

from __future__ import annotations

import numba
import numpy as np
import pytest
from numpy.typing import NDArray

from origami_lab.jit import bare, counting, kernel

Array = NDArray[np.float64]


def calls_of(compiled: object) -> bool:
    """Whether the code that was made of a function counts references."""
    return any("NRT_incref" in code or "NRT_decref" in code for code in compiled.inspect_llvm().values())  # type: ignore[attr-defined]


@pytest.mark.skipif(numba.config.DISABLE_JIT, reason="nothing is compiled")
def test_bare_kernels_count_no_references() -> None:
    """The option is not a public one of numba: a version that ignores it is to be noticed."""
    table = np.random.default_rng(0).random((7, 5))

    def plain(rows: Array) -> Array:
        return rows[1:].copy()

    counted = kernel(plain)
    assert (counted(table) == table[1:]).all()
    assert calls_of(counted), "so the check can fail"
    found = bare(lambda rows: rows[2][3] + rows[1:][0, 0])
    assert found(table) == table[2, 3] + table[1, 0]
    assert not calls_of(found)


@pytest.mark.skipif(numba.config.DISABLE_JIT, reason="nothing is compiled")
def test_a_bare_kernel_that_makes_an_array_is_refused_not_miscounted() -> None:
    def made(n: int) -> float:
        return np.ones(n).sum()  # type: ignore[no-any-return]

    def made_as_well(n: int) -> float:  # machine code on disk is told apart by names
        return np.ones(n).sum()  # type: ignore[no-any-return]

    assert kernel(made_as_well)(3) == 3.0
    if counting(numba.core.cpu.CPUTargetOptions, False):
        with pytest.raises(numba.core.errors.TypingError):
            bare(made)(3)


def test_a_numba_without_the_option_is_not_asked_for_it() -> None:
    class Options:
        error_model = None

    class Later(Options):
        _nrt = None

    assert counting(Options, True) == counting(Options, False) == {}
    assert counting(Later, True) == {"_nrt": True}
    assert counting(Later, False) == {"_nrt": False}


@pytest.mark.skipif(numba.config.DISABLE_JIT, reason="nothing is compiled")
def test_whoever_calls_first_decides_nothing() -> None:
    """Numba hands options that are left open down to what is called: a kernel has to say that it makes arrays."""
    inner = kernel(lambda n: np.ones(n).sum())

    @bare
    def outer(n: int) -> float:
        return inner(n) + 1.0

    assert outer(3) == 4.0
