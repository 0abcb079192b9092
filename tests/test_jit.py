"""Kernels that make no arrays count no references, where this version of numba can do without."""

from __future__ import annotations

import subprocess
import sys
from pathlib import Path
from typing import Any

import numba
import numpy as np
import pytest
from numba.core.caching import IndexDataCacheFile
from numpy.typing import NDArray

from origami_lab import jit
from origami_lab.jit import OwnNames, bare, compile_for, counting, kernel

Array = NDArray[np.float64]


def calls_of(compiled: object) -> bool:
    """Whether the code that was made of a function counts references."""
    return any("NRT_incref" in code or "NRT_decref" in code for code in compiled.inspect_llvm().values())  # type: ignore[attr-defined]


@pytest.mark.skipif(numba.config.DISABLE_JIT, reason="nothing is compiled")
def test_bare_kernels_count_no_references(monkeypatch: pytest.MonkeyPatch) -> None:
    """The option is not a public one of numba: a version that ignores it is to be noticed."""
    monkeypatch.setattr(jit, "_IS_KEPT", False)  # of code that comes from disk not all can be looked at
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


class Interrupted:
    """A cache file of a class, whose process is overtaken by another's before it saves its code."""

    def __init__(self, kind: type[Any], folder: Path) -> None:
        self.other = kind(str(folder), "kernel", "stamp")
        file = self.file = kind(str(folder), "kernel", "stamp")
        save_data, load_index = file._save_data, self.other._load_index
        stale = load_index()

        def overtaken(name: str, data: object) -> None:
            self.other._load_index = lambda: dict(stale)
            self.other.save("theirs", "their code")
            self.other._load_index = load_index
            save_data(name, data)

        file._save_data = overtaken


@pytest.mark.parametrize(("kind", "mixes_up"), [(IndexDataCacheFile, True), (OwnNames, False)])
def test_two_processes_that_save_at_once_never_get_each_others_code(
    tmp_path: Path, kind: type[Any], mixes_up: bool
) -> None:
    """Numba's own way, which is shown to mix them up, is not ours."""
    both = Interrupted(kind, tmp_path)
    both.file.save("ours", "our code")
    fresh = kind(str(tmp_path), "kernel", "stamp")
    ours, theirs = fresh.load("ours"), fresh.load("theirs")
    assert (ours not in (None, "our code") or theirs not in (None, "their code")) == mixes_up


@pytest.mark.skipif(numba.config.DISABLE_JIT, reason="nothing is compiled")
def test_kernels_on_disk_have_names_of_their_own() -> None:
    """What is replaced is no public part of numba: a version without it is to be noticed."""
    from origami_lab.game.kernels.play import step

    assert type(step._cache._cache_file) is OwnNames  # type: ignore[attr-defined]


@pytest.mark.skipif(numba.config.DISABLE_JIT, reason="nothing is compiled")
def test_a_kernel_is_compiled_without_a_call() -> None:
    def plain(n: int) -> int:
        return n + 1

    compiled = kernel(plain)
    compile_for(compiled, 3)
    assert [signature[0] for signature in compiled.overloads] == [numba.int64]  # type: ignore[attr-defined]
    compile_for(plain, 3)  # plain Python: there is nothing to do


NAMES = """
import sys
import numpy as np
from numba.core.itanium_mangler import mangle
from numba.core.types import Array, float64, int64
from numba.np.numpy_support import from_dtype

import origami_lab.jit

for count in range(int(sys.argv[1])):  # other types that a process came across before
    from_dtype(np.dtype([("other", np.int64, (count + 1,))]))
for place in ("f8", "i8"):
    board = from_dtype(np.dtype([("place", place, (3, 2)), ("count", np.int64)], align=True))
    print(mangle("step", [board, Array(board, 1, "C")]))
"""


@pytest.mark.skipif(numba.config.DISABLE_JIT, reason="nothing is compiled")
def test_a_function_has_one_name_for_one_board_in_every_process() -> None:
    """Else code of two processes, loaded into a third, could be mixed up: boards were numbered in each of them."""
    said = [
        subprocess.run([sys.executable, "-c", NAMES, others], capture_output=True, text=True, check=True).stdout.split()
        for others in ("0", "1", "7")
    ]
    assert said[0] == said[1] == said[2]
    assert len(set(said[0])) == 2
