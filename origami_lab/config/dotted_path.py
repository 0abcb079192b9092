"""Finding what a ``_target_`` names, and saying in one line why it cannot be had."""

from __future__ import annotations

import sysconfig
import traceback
from importlib import import_module
from pathlib import Path
from types import ModuleType
from typing import Any

from origami_lab.about import PACKAGE
from origami_lab.config.earlier_versions import new_home, public_target
from origami_lab.errors import InputError
from origami_lab.text import nearest

LIBRARIES = tuple({sysconfig.get_path(name) for name in ("stdlib", "platstdlib", "purelib", "platlib")})


def locate(field: str, path: str) -> Any:
    """The class or function that a dotted path names; its module is imported.

    Parameters
    ----------
    field
        Where it is named, e.g. ``objective``.

    Raises
    ------
    InputError
        If there is no such module or name, the module raises while it is imported (the line says in which file and
        line), or what is found cannot be called.
    """
    path = public_target(path)
    module, name = path, ""
    names: list[str] = []
    if not all(part.isidentifier() for part in path.split(".")) or "." not in path:
        raise InputError(field, path, "must be MODULE.NAME, e.g. mine.Tower for the class Tower in mine.py")
    if module.split(".")[0] == "__main__":
        raise InputError(
            field, path, "must be in a file of its own: worker processes cannot import a script or notebook"
        )
    while True:  # the longest part that is a module, as in package.module.Class.method
        module, _, name = module.rpartition(".")
        names.insert(0, name)
        found = _import(field, path, module)
        if found is not None:
            break
        if "." not in module:
            hint = nearest(module, (file.stem for file in Path.cwd().glob("*.py")))
            expected = f"there is no module {module}, neither in {Path.cwd()} nor installed{hint}"
            raise InputError(field, path, expected)
    value: Any = found
    for name in names:
        if not hasattr(value, name):
            kind = "module" if isinstance(value, ModuleType) else "class"
            known = [word for word in dir(value) if not word.startswith("_")]
            expected = f"there is no {name} in {kind} {value.__name__}{nearest(name, known)}"
            raise InputError(field, path, expected)
        value = getattr(value, name)
    if not callable(value):
        raise InputError(field, path, f"is of type {type(value).__name__}; must be a class or a function")
    return value


def _import(field: str, path: str, module: str) -> ModuleType | None:
    """The module, None if there is none of that name."""
    try:
        return import_module(module)
    except ModuleNotFoundError as error:
        if error.name is not None and (module == error.name or module.startswith(f"{error.name}.")):
            return None
        raise InputError(field, path, f"importing {module} failed: {describe(error)}{_moved(error)}") from error
    except (Exception, SystemExit) as error:
        raise InputError(field, path, f"importing {module} failed: {describe(error)}") from error


def _moved(error: ModuleNotFoundError) -> str:
    """Where the names of a missing module of version 0.1.0 are now."""
    home = new_home(error.name or "")
    return f"; its names are in {home} now: from {home} import ..." if home else ""


def describe(error: BaseException) -> str:
    """An exception in one line: its type, what it says, and the file and line that raised it."""
    lines = [line for line in str(error).splitlines() if line.strip()]
    if isinstance(error, SyntaxError):
        lines, place = [error.msg], (error.filename, error.lineno)
    else:
        place = _place(error)
    text = f"{type(error).__name__}: {lines[0].strip()}" if lines else type(error).__name__
    return text if place[0] is None else f"{text} ({_short(place[0])}, line {place[1]})"


def _place(error: BaseException) -> tuple[str | None, int | None]:
    """File and line of the innermost call in code of the user's; of the innermost one where all is in libraries."""
    frames = [frame for frame in traceback.extract_tb(error.__traceback__) if not frame.filename.startswith("<")]
    own = [frame for frame in frames if not _is_below(frame.filename, *LIBRARIES, str(PACKAGE))]
    for frame in [*own[-1:], *frames[-1:]]:
        return (None, None) if _is_below(frame.filename, str(PACKAGE)) else (frame.filename, frame.lineno)
    return None, None


def _is_below(file: str, *folders: str) -> bool:
    return any(file.startswith(folder) for folder in folders)


def _short(file: str) -> str:
    """The file relative to the working directory where it is in it."""
    try:
        return str(Path(file).relative_to(Path.cwd()))
    except ValueError:
        return file
