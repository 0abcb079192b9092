"""`origami-lab doctor`: what may keep experiments from running here."""

from __future__ import annotations

import json
import os
import platform
import re
import shutil
import sqlite3
from collections.abc import Callable, Iterator, Sequence
from dataclasses import asdict, dataclass
from importlib import metadata
from importlib.util import find_spec
from pathlib import Path
from urllib.error import HTTPError
from urllib.parse import unquote, urlparse
from urllib.request import urlopen

from origami_lab.about import PACKAGE, __version__
from origami_lab.addresses import without_secrets
from origami_lab.commands.parser import Parser
from origami_lab.errors import EXIT_FAILED, EXIT_OK, InputError
from origami_lab.files import is_writable, nearest_existing
from origami_lab.machine import WORKER_BYTES, container_cores, free_memory, usable_cores
from origami_lab.tracking.store import DEFAULT_STORE, SERVERS, check_store, sqlite_file


def main(arguments: Sequence[str]) -> int:
    """Print one line a check; returns 1 if there is a problem, else 0."""
    description = "Check the installation, the machine, and the folder that experiments run in. Changes nothing."
    parser = Parser("origami-lab doctor", description=description)
    parser.add_argument("directory", nargs="?", default=".", help="where experiments are to run (default: here)")
    parser.add_argument("--uri", help="the MLflow store of tracking.uri (default: results/mlflow.db)")
    parser.add_argument("--json", action="store_true", help="for machines")
    options = parser.parse_args(arguments)

    checks = examine(Path(options.directory), options.uri)
    if options.json:
        print(as_json(checks))
    else:
        width = max(len(check.name) for check in checks)
        for check in checks:
            print(f"{check.status:<7}  {check.name:<{width}}  {check.text}")
    return EXIT_FAILED if any(check.status == PROBLEM for check in checks) else EXIT_OK


OK, NOTE, PROBLEM = "ok", "note", "problem"


DISTRIBUTION = "origami-lab"


PATIENCE_SECONDS = 2.0


LITTLE_DISK = 2**30
"""Bytes below which free space is worth a note: a trial's files take about a megabyte, twice with tracking."""


@dataclass(frozen=True)
class Diagnosis:
    """One line of the report."""

    name: str
    status: str
    """ok, note (works, but worth knowing) or problem (something will not work)."""
    text: str


Found = tuple[str, str]
"""Status and text."""


def examine(directory: Path, uri: str | None = None) -> list[Diagnosis]:
    """All checks, for experiments started in ``directory`` and tracked in the store ``uri`` (None: its default)."""
    checks: list[tuple[str, Callable[[], Iterator[Found]]]] = [
        ("version", _version),
        ("dependencies", _dependencies),
        ("extras", _extras),
        ("configuration", _configuration),
        ("cores", _cores),
        ("memory", _memory),
        ("kernels", _kernels),
        ("results", lambda: _results(directory)),
        ("tracking", lambda: _tracking(directory, uri)),
    ]
    found = []
    for name, check in checks:
        try:
            found += [Diagnosis(name, status, " ".join(text.split())) for status, text in check()]
        except Exception as error:
            found.append(
                Diagnosis(name, PROBLEM, " ".join(f"cannot be found out: {type(error).__name__}: {error}".split()))
            )
    return found


def as_json(checks: list[Diagnosis]) -> str:
    """The report for machines."""
    worst = max((check.status for check in checks), key=(OK, NOTE, PROBLEM).index, default=OK)
    return json.dumps({"status": worst, "checks": [asdict(check) for check in checks]}, indent=1)


def _version() -> Iterator[Found]:
    python = f"Python {platform.python_version()}, {platform.system()} {platform.machine()}"
    yield OK, f"origami-lab {__version__} in {PACKAGE}, {python}"


def _dependencies() -> Iterator[Found]:
    """Installed packages against the declared ones: one line for all that fit and one for each that does not."""
    from packaging.requirements import Requirement

    try:
        declared = [Requirement(text) for text in metadata.requires(DISTRIBUTION) or []]
    except metadata.PackageNotFoundError:
        yield NOTE, "origami-lab runs from a folder that is not installed, so it is not known what it needs"
        return
    fitting = []
    for requirement in declared:
        if requirement.marker is not None and not requirement.marker.evaluate({"extra": ""}):
            continue
        name, wanted = requirement.name, str(requirement.specifier)
        version = _installed(name)
        if version is None:
            yield PROBLEM, f"{name} is missing (needs {name}{wanted})"
        elif not requirement.specifier.contains(version, prereleases=True):
            yield PROBLEM, f"{name} is {version}, but needed is {name}{wanted}"
        else:
            fitting.append(f"{name} {version}")
    yield OK, ", ".join(fitting)


def _extras() -> Iterator[Found]:
    """For each optional extra what is missing of it, and the command that adds it."""
    from packaging.requirements import Requirement

    try:
        distribution = metadata.distribution(DISTRIBUTION)
    except metadata.PackageNotFoundError:
        return
    for extra in distribution.metadata.get_all("Provides-Extra") or []:
        missing = []
        for requirement in map(Requirement, distribution.requires or []):
            marker = requirement.marker
            if marker is None or marker.evaluate({"extra": ""}) or not marker.evaluate({"extra": extra}):
                continue
            version = _installed(requirement.name)
            if version is None or not requirement.specifier.contains(version, prereleases=True):
                missing.append(requirement.name)
        if missing:
            yield NOTE, f"{extra}: without {', '.join(missing)}; to add it: {_pip_command(distribution, extra)}"
        else:
            yield OK, f"{extra}: complete"


def _installed(name: str) -> str | None:
    try:
        return metadata.version(name)
    except metadata.PackageNotFoundError:
        return None


def _pip_command(distribution: metadata.Distribution, extra: str) -> str:
    """How to install an extra into an installation of this kind: editable, from a folder or a wheel, or by name."""
    origin = json.loads(distribution.read_text("direct_url.json") or "{}")
    path = unquote(urlparse(origin.get("url", "")).path) if str(origin.get("url", "")).startswith("file:") else ""
    if not path or not Path(path).exists():
        return f"pip install '{DISTRIBUTION}[{extra}]'"
    editable = "-e " if origin.get("dir_info", {}).get("editable") else ""
    return f"pip install {editable}'{path}[{extra}]'"


def _configuration() -> Iterator[Found]:
    from origami_lab.config.option_files import config_dir

    yield OK, str(config_dir())


def _cores() -> Iterator[Found]:
    usable = usable_cores()
    total = os.cpu_count() or usable
    text = f"{usable} usable" + (f" of {total}" if usable != total else "")
    limit = container_cores()
    if limit is not None and limit < usable:
        yield NOTE, f"{text}, but limited to the time of {limit:g}; best is workers={max(int(limit), 1)}"
    else:
        yield OK, f"{text}: as many trials run at a time"


def _memory() -> Iterator[Found]:
    free, total = free_memory()
    if free is None or total is None:
        yield NOTE, "not known on this system"
        return
    text = f"{_size(free)} free of {_size(total)}"
    trials = free // WORKER_BYTES
    if trials < usable_cores():
        expected = f"enough for {trials} trials at a time (about {_size(WORKER_BYTES)} each)"
        yield NOTE, f"{text}: {expected}; best is workers={max(trials, 1)}"
    else:
        yield OK, text


def _kernels() -> Iterator[Found]:
    """Where compiled kernels are kept, and whether those of this version are there."""
    from numba.core.caching import UserWideCacheLocator

    from origami_lab.caches import kernel_cache
    from origami_lab.jit import cache_folder

    if remark := kernel_cache().remark:
        yield NOTE, remark
        return
    folder = cache_folder()
    assert folder is not None
    if os.environ.get("NUMBA_DISABLE_JIT", "0") not in ("", "0"):
        yield NOTE, "NUMBA_DISABLE_JIT is set: kernels run as plain Python, far slower"
        return
    # numba keeps the kernels of each folder of sources by themselves: another checkout's are not ours
    sources = PACKAGE.rglob("__init__.py")
    ours = [folder / UserWideCacheLocator.get_suitable_cache_subpath(str(file)) for file in sources]
    compiled = [file for place in ours for file in place.glob("*.nbc")]
    if compiled:
        yield OK, f"compiled, {_size(sum(file.stat().st_size for file in compiled))} in {folder}"
    else:
        yield NOTE, f"not compiled yet: the first run takes up to a minute more; they will be in {folder}"


def _results(directory: Path) -> Iterator[Found]:
    folder = directory.absolute() / "results"
    if not is_writable(folder):
        yield PROBLEM, f"{folder} cannot be written; run elsewhere, or give output=DIR and tracking.uri"
        return
    free = shutil.disk_usage(nearest_existing(folder)).free
    status = NOTE if free < LITTLE_DISK else OK
    yield status, f"{folder} can be written, {_size(free)} free"


def _tracking(directory: Path, uri: str | None) -> Iterator[Found]:
    """The MLflow store: the folder's own, or the one at a URI."""
    if uri is None:
        yield _database(directory.absolute() / DEFAULT_STORE, "the first run makes it")
        return
    try:
        check_store(uri)
    except InputError as error:
        yield PROBLEM, str(error)
        return
    file = sqlite_file(uri)
    if file is not None:
        yield _database(file.absolute(), "the first run with this tracking.uri makes it")
    elif uri.startswith(SERVERS):
        yield _server(without_secrets(uri))
    else:
        yield NOTE, f"{without_secrets(uri)}: only sqlite:/// and http(s):// are looked at here"


def _database(path: Path, hint: str) -> Found:
    """An SQLite store, read without changing it."""
    if not path.exists():
        if not is_writable(path.parent):
            return PROBLEM, f"{path} is not there and cannot be made"
        return OK, f"{path} is not there yet; {hint}"
    if not os.access(path, os.W_OK) or not os.access(path.parent, os.W_OK):
        return PROBLEM, f"{path} cannot be written"
    try:
        database = sqlite3.connect(f"{path.as_uri()}?mode=ro", uri=True, timeout=PATIENCE_SECONDS / 2)
        try:
            (schema,) = database.execute("SELECT version_num FROM alembic_version").fetchone() or ("none",)
            query = "SELECT COUNT(*) FROM experiments WHERE lifecycle_stage = 'active' AND name <> 'Default'"
            (count,) = database.execute(query).fetchone()
        finally:
            database.close()
    except sqlite3.Error as error:
        if "locked" in str(error):
            return PROBLEM, f"{path} is locked by another process"
        return PROBLEM, f"{path} is not an MLflow store ({error})"
    text = f"{path} with {count} experiment{'' if count == 1 else 's'}"
    known, heads = _schemas()
    if not heads or schema in heads:
        return OK, text
    if schema in known:
        return (
            NOTE,
            f"{text}, of an older MLflow; if it is refused, back it up and run: mlflow db upgrade sqlite:///{path}",
        )
    return PROBLEM, f"{text}, of a newer MLflow (schema {schema}): install that one, or give another tracking.uri"


def _schemas() -> tuple[set[str], set[str]]:
    """The schema versions that the installed MLflow knows, and the newest of them, read from its sources."""
    spec = find_spec("mlflow")
    if spec is None or spec.origin is None:
        return set(), set()
    known, older = set(), set()
    for file in (Path(spec.origin).parent / "store/db_migrations/versions").glob("*.py"):
        text = file.read_text(encoding="utf-8")
        known.update(re.findall(r"^revision\s*=\s*[\"'](\w+)", text, re.MULTILINE))
        for line in re.findall(r"^down_revision\s*=(.*)", text, re.MULTILINE):
            older.update(re.findall(r"[\"'](\w+)[\"']", line))
    return known, known - older


def _server(uri: str) -> Found:
    try:
        with urlopen(f"{uri.rstrip('/')}/version", timeout=PATIENCE_SECONDS) as answer:
            version = answer.read(40).decode("ascii", "replace")
        return OK, f"{uri} answers: MLflow {version}"
    except HTTPError as error:
        return NOTE, f"{uri} answers, but not as an MLflow server does ({error.code} {error.reason})"
    except OSError as error:
        return PROBLEM, f"{uri} does not answer ({getattr(error, 'reason', error)})"


def _size(count: float) -> str:
    """Bytes for people."""
    for unit in ("B", "kB", "MB"):
        if count < 1024:
            return f"{count:.0f} {unit}"
        count /= 1024
    return f"{count:.1f} GB"
