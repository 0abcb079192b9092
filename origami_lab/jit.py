"""How the kernels are compiled: one decorator, so that the compiler can be switched off in one place.

``NUMBA_DISABLE_JIT=1`` runs the same functions as plain Python, for coverage and debugging.

Machine code is cached on disk, in ``~/.cache/origami-lab`` (or under ``XDG_CACHE_HOME``, or ``NUMBA_CACHE_DIR``); where
that cannot be written, among the temporary files, and a warning is logged: one line on stderr. Numba looks only at the
file a kernel is in to see whether its cache is stale, but a kernel contains the code of those it calls; so the folder
is named after the contents of all files with kernels.
"""

from __future__ import annotations

import hashlib
import logging
import time
import uuid
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any, TypeVar, cast

import numba
from numba.core import types
from numba.core.caching import IndexDataCacheFile
from numba.core.cpu import CPUTargetOptions
from numba.core.event import Listener, install_listener
from numba.extending import overload

from origami_lab.caches import kernel_cache

F = TypeVar("F", bound=Callable[..., Any])

_WITH_KERNELS = ("geometry", "kinematics", "game", "objectives", "search", "drawing", "polish")


def cache_folder() -> Path | None:
    """Where the machine code of this version of the kernels is kept; None if there is no place for it."""
    base = kernel_cache().base
    if base is None:
        return None
    package = Path(__file__).parent
    digest = hashlib.sha256(numba.__version__.encode())
    digest.update(Path(__file__).read_bytes())
    for layer in _WITH_KERNELS:
        for file in sorted((package / layer).rglob("*.py")):
            digest.update(file.name.encode())
            digest.update(file.read_bytes())
    return base / digest.hexdigest()[:16]


_FOLDER = cache_folder()
_IS_KEPT = _FOLDER is not None
if _FOLDER is not None:
    numba.config.CACHE_DIR = str(_FOLDER)
if kernel_cache().remark:
    logging.getLogger(__name__).warning("note: %s", kernel_cache().remark)


def counting(options: type, counts: bool) -> dict[str, bool]:
    """The option that says whether references are counted, if numba's class of options has it: it is not public.

    It must always be said: a function takes the options that it leaves open from the one that calls it first.
    """
    return {"_nrt": counts} if hasattr(options, "_nrt") else {}


_WITH_COUNTS, _WITHOUT_COUNTS = counting(CPUTargetOptions, True), counting(CPUTargetOptions, False)


def content_names(record: types.Record) -> tuple[str, tuple[str, ...]]:
    """The name of a record, such as a board, in the names of the functions that take it: one for one content.

    Numba takes a number that says how many types this process knew before (its issue 7654). Of code that two processes
    kept on disk, functions for different boards could then have one name, and a third process that loads both calls
    one of them for the other.
    """
    return type(record).__name__, (hashlib.sha256(record.name.encode()).hexdigest()[:16],)


types.Record.mangling_args = property(content_names)  # type: ignore[assignment, method-assign]


class OwnNames(IndexDataCacheFile):  # type: ignore[misc]
    """The files of one kernel's machine code on disk: each version has a name that no other ever had.

    Numba numbers them. Of two processes that save different versions of a kernel at the same moment, one could later
    be handed the other's code for its own.
    """

    def save(self, key: object, data: object) -> None:
        """Save a version; what other processes save meanwhile keeps its name, or is compiled once more."""
        name = self._load_index().get(key) or self._data_name(uuid.uuid4().int)
        self._save_data(name, data)
        self._save_index({**self._load_index(), key: name})


def named(dispatcher: Any) -> Any:
    """A kernel whose versions on disk have names of their own, if numba keeps them as it did: that is not public."""
    file = getattr(getattr(dispatcher, "_cache", None), "_cache_file", None)
    if type(file) is IndexDataCacheFile:
        file.__class__ = OwnNames
    return dispatcher


def kernel(function: F) -> F:
    """Compile ``function`` in nopython mode and cache the machine code on disk.

    No ``fastmath``: results must be the same bits on every run, and mirror images exact.
    """
    return cast(F, named(numba.njit(cache=_IS_KEPT, error_model="numpy", **_WITH_COUNTS)(function)))


def bare(function: F) -> F:
    """Like :func:`kernel` for code that makes no arrays; if it does, it does not compile.

    Numba counts references to every array and slice that code with arrays of its own is handed, a fifth of the time of
    a search. Here it does not, where this version of numba can do without; the results are the same.
    """
    return cast(F, named(numba.njit(cache=_IS_KEPT, error_model="numpy", **_WITHOUT_COUNTS)(function)))


def inlined(function: F) -> F:
    """Like :func:`bare` for small helpers of the hot loops, which LLVM shall inline."""
    options = {"error_model": "numpy", "forceinline": True, **_WITHOUT_COUNTS}
    return cast(F, named(numba.njit(cache=_IS_KEPT, **options)(function)))


def compiled_as(function: Callable[..., Any]) -> Callable[[F], F]:
    """Decorator of what says, from the types of the arguments, which code ``function`` is inside kernels.

    It returns a function with the same parameters; plain Python runs ``function`` itself.
    """
    return cast(
        Callable[[F], F], overload(function, jit_options={"error_model": "numpy", **_WITHOUT_COUNTS}, strict=False)
    )


@kernel
def get_ready(nothing: int) -> int:
    """The smallest kernel: with the first one of a process numba imports what it knows of numpy, for half a second."""
    return nothing


def compile_for(function: Callable[..., Any], *arguments: object) -> None:
    """Compile a kernel for arguments like these, without a call, or load it if that was done before."""
    compile_version = getattr(function, "compile", None)
    if compile_version is not None:  # not in plain Python
        compile_version(tuple(numba.typeof(argument) for argument in arguments))


class CompileClock(Listener):  # type: ignore[misc]
    """Measures the time in which this process compiles kernels; loading compiled ones is not counted.

    Parameters
    ----------
    begins
        Called when compiling begins for the first time.
    """

    def __init__(self, begins: Callable[[], None]) -> None:
        self.seconds = 0.0
        self._begins, self._depth, self._since, self._said = begins, 0, 0.0, False

    def on_start(self, event: object) -> None:
        if self._depth == 0:
            self._since = time.perf_counter()
            if not self._said:
                self._said = True
                self._begins()
        self._depth += 1

    def on_end(self, event: object) -> None:
        self._depth -= 1
        if self._depth == 0:
            self.seconds += time.perf_counter() - self._since


@contextmanager
def compile_clock(begins: Callable[[], None] = lambda: None) -> Iterator[CompileClock]:
    """A clock that runs while kernels are compiled inside the block."""
    with install_listener("numba:compile", CompileClock(begins)) as clock:
        yield clock
