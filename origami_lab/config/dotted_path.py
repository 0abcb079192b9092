"""Finding what a ``_target_`` names, and saying in one line why it cannot be had."""

from __future__ import annotations

import sys
import traceback
from collections.abc import Sequence
from importlib import import_module
from pathlib import Path
from types import ModuleType
from typing import Any

from origami_lab.about import PACKAGE
from origami_lab.config.earlier_versions import new_home, public_target
from origami_lab.config.trusted_code import LIBRARIES, home_of, is_trusted, is_trusted_module, our_parts, spec_of
from origami_lab.errors import InputError
from origami_lab.text import nearest

OURS = "origami_lab"


def locate(field: str, path: object, trust: Sequence[str] = (), *, inner: bool = False) -> Any:
    """The class or function that a dotted path names; its module is imported, if it is one of the user's own.

    Parameters
    ----------
    field
        Where it is named, e.g. ``objective``: parts of ours are to be of that group.
    trust
        Installed packages whose code may be named, too.
    inner
        It is an argument of another part: one of ours may be of any group.

    Raises
    ------
    InputError
        If there is no such module or name, it is not one that may be called, the module raises while it is imported
        (the line says in which file and line), or what is found cannot be called.
    """
    path = public_target(path) if isinstance(path, str) else str(path)
    if not all(part.isidentifier() for part in path.split(".")) or "." not in path:
        raise InputError(field, path, "must be MODULE.NAME, e.g. mine.Tower for the class Tower in mine.py")
    root = path.partition(".")[0]
    if root == "__main__":
        raise InputError(
            field, path, "must be in a file of its own: worker processes cannot import a script or notebook"
        )
    if root == OURS:
        return _ours(field, path, inner)
    module, names = _own_module(field, path, trust)
    value: Any = module
    for name in names:
        if not hasattr(value, name):
            kind = "module" if isinstance(value, ModuleType) else "class"
            known = [word for word in dir(value) if not word.startswith("_")]
            expected = f"there is no {name} in {kind} {value.__name__}{nearest(name, known)}"
            raise InputError(field, path, expected)
        value = getattr(value, name)
        if isinstance(value, ModuleType) and not is_trusted_module(value, trust):
            raise _foreign(field, path)
    if not callable(value):
        raise InputError(field, path, f"is of type {type(value).__name__}; must be a class or a function")
    if any(name.startswith("__") for name in names) or not _may_be_called(value, field, trust, inner):
        raise _foreign(field, path)
    return value


def _ours(field: str, path: str, inner: bool) -> Any:
    """One of our own parts, for its place."""
    known = our_parts("" if inner else field)
    if path not in known:
        what = "a part" if inner else f"a part for {field}"
        raise InputError(field, path, f"is not the public name of {what} of origami-lab's{nearest(path, known)}")
    package, _, name = path.rpartition(".")
    return getattr(import_module(package), name)


def _own_module(field: str, path: str, trust: Sequence[str]) -> tuple[ModuleType, list[str]]:
    """The longest part of a path that is a module, imported, and the names behind it.

    Each module on the way is looked at before it is imported.
    """
    parts = path.split(".")
    found: tuple[ModuleType, list[str]] | None = None
    for count in range(1, len(parts)):
        module = ".".join(parts[:count])
        spec = spec_of(module)
        if spec is None:
            break
        if not is_trusted(spec, trust):
            raise _foreign(field, path)
        imported = _import(field, path, module)
        if imported is None:
            break
        found = imported, parts[count:]
    if found is None:
        hint = nearest(parts[0], (file.stem for file in Path.cwd().glob("*.py")))
        expected = f"there is no module {parts[0]}, neither in {Path.cwd()} nor installed{hint}"
        raise InputError(field, path, expected)
    return found


def _may_be_called(value: Any, field: str, trust: Sequence[str], inner: bool) -> bool:
    """Whether what a path leads to was defined where it may be, or is a part of ours under another name."""
    home = home_of(value)
    if home.partition(".")[0] == OURS:
        return any(value is _ours(field, path, inner) for path in our_parts("" if inner else field))
    return home in sys.modules and is_trusted(spec_of(home), trust)


def _foreign(field: str, path: str) -> InputError:
    expected = (
        f"must be a part of origami-lab's, or be defined in a module below {Path.cwd()} or in a package that the"
        " command line names, trust=PACKAGE"
    )
    return InputError(field, path, expected)


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
