"""The doctor: what it finds in places that are made to be found, and that nothing it meets throws it off."""

from __future__ import annotations

import json
import os
import sqlite3
import subprocess
import sys
import threading
from collections.abc import Iterator
from http.server import BaseHTTPRequestHandler, HTTPServer
from importlib import metadata
from pathlib import Path

import pytest

from origami_lab import machine
from origami_lab.cli import main
from origami_lab.commands import doctor
from origami_lab.commands.doctor import NOTE, OK, PROBLEM, examine

ROOT = Path(__file__).parents[2]
NAMES = ["version", "dependencies", "extras", "configuration", "cores", "memory", "kernels", "results", "tracking"]


def found(name: str, directory: Path, uri: str | None = None) -> list[tuple[str, str]]:
    return [(check.status, check.text) for check in examine(directory, uri) if check.name == name]


def one(name: str, directory: Path, uri: str | None = None) -> tuple[str, str]:
    (only,) = found(name, directory, uri)
    return only


def make_store(folder: Path, schema: str, experiments: int = 2) -> Path:
    path = folder / "results/mlflow.db"
    path.parent.mkdir(exist_ok=True)
    database = sqlite3.connect(path)
    database.execute("CREATE TABLE alembic_version (version_num TEXT)")
    database.execute("INSERT INTO alembic_version VALUES (?)", [schema])
    database.execute("CREATE TABLE experiments (name TEXT, lifecycle_stage TEXT)")
    rows = [("Default", "active"), ("old", "deleted"), *((f"task {i}", "active") for i in range(experiments))]
    database.executemany("INSERT INTO experiments VALUES (?, ?)", rows)
    database.commit()
    database.close()
    return path


def newest_schema() -> str:
    from alembic.script import ScriptDirectory
    from mlflow.store.db.utils import _get_alembic_config

    (head,) = ScriptDirectory.from_config(_get_alembic_config("")).get_heads()
    return head


def test_a_process_of_its_own_says_all_and_changes_nothing(tmp_path: Path) -> None:
    source = (
        "import sys; from origami_lab.cli import main; code = main(['doctor', '--json'])\n"
        "assert not {'mlflow', 'pandas', 'matplotlib', 'trimesh'} & set(sys.modules)\n"
        "sys.exit(code)"
    )
    environment = {**os.environ, "PYTHONPATH": str(ROOT)}
    command = [sys.executable, "-c", source]
    done = subprocess.run(command, cwd=tmp_path, env=environment, capture_output=True, text=True, check=False)
    report = json.loads(done.stdout)
    assert list(dict.fromkeys(check["name"] for check in report["checks"])) == NAMES
    assert {check["status"] for check in report["checks"]} <= {"ok", "note", "problem"}
    assert done.returncode == (1 if report["status"] == "problem" else 0)
    assert done.stderr == ""
    assert list(tmp_path.iterdir()) == []


def test_lines_and_exit_codes(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    (tmp_path / "results").write_text("a file where a folder should be")
    assert main(["doctor", str(tmp_path)]) == 1
    lines = capsys.readouterr().out.splitlines()
    assert list(dict.fromkeys(line.split()[1] for line in lines)) == NAMES
    (line,) = (line for line in lines if line.split()[1] == "results")
    assert line.startswith("problem")
    assert "cannot be written" in line
    assert main(["doctor", "--json", str(tmp_path)]) == 1
    assert json.loads(capsys.readouterr().out)["status"] == "problem"
    assert main(["doctor", "--help"]) == 0
    assert main(["doctor", "--nosuch"]) == 2


def test_a_check_that_fails_is_its_own_line(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    def broken() -> Iterator[tuple[str, str]]:
        raise RuntimeError("what\never")

    monkeypatch.setattr(doctor, "_cores", broken)
    assert one("cores", tmp_path) == (PROBLEM, "cannot be found out: RuntimeError: what ever")
    assert list(dict.fromkeys(check.name for check in examine(tmp_path))) == NAMES


def test_dependencies_name_what_is_needed(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    needs = ["numpy>=2.0", "pandas>=999", "nosuchpackage<3,>=2", "ruff>=999; extra == 'dev'"]
    monkeypatch.setattr(metadata, "requires", lambda name: needs)
    version = metadata.version
    assert found("dependencies", tmp_path) == [
        (PROBLEM, f"pandas is {version('pandas')}, but needed is pandas>=999"),
        (PROBLEM, "nosuchpackage is missing (needs nosuchpackage<3,>=2)"),
        (OK, f"numpy {version('numpy')}"),
    ]


@pytest.mark.parametrize(
    ("origin", "command"),
    [
        (None, "pip install 'origami-lab[fancy]'"),
        ({"url": "https://example.org/x.whl"}, "pip install 'origami-lab[fancy]'"),
        ({"url": "file:///gone/x.whl"}, "pip install 'origami-lab[fancy]'"),
        ({"url": "FOLDER", "dir_info": {}}, "pip install 'PATH[fancy]'"),
        ({"url": "FOLDER", "dir_info": {"editable": True}}, "pip install -e 'PATH[fancy]'"),
    ],
)
def test_extras_name_what_is_missing_and_how_to_add_it(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, origin: dict[str, object] | None, command: str
) -> None:
    place = tmp_path / "a folder"
    info = place / "origami_lab-1.dist-info"
    info.mkdir(parents=True)
    lines = ["Metadata-Version: 2.1", "Name: origami-lab", "Version: 1", "Requires-Dist: numpy"]
    lines += ["Provides-Extra: plain", "Provides-Extra: fancy", "Requires-Dist: numpy>=1; extra == 'plain'"]
    lines += ["Requires-Dist: nosuchpackage; extra == 'fancy'", "Requires-Dist: numpy>=999; extra == 'fancy'"]
    (info / "METADATA").write_text("\n".join(lines))
    if origin is not None:
        (info / "direct_url.json").write_text(json.dumps(origin).replace("FOLDER", place.as_uri()))
    real, fake = metadata.distribution, metadata.PathDistribution(info)
    monkeypatch.setattr(metadata, "distribution", lambda name: fake if name == "origami-lab" else real(name))
    expected = f"fancy: without nosuchpackage, numpy; to add it: {command.replace('PATH', str(place))}"
    assert found("extras", tmp_path) == [(OK, "plain: complete"), (NOTE, expected)]


CGROUPS = [{"cpu.max": "50000 100000"}, {"cpu/cpu.cfs_quota_us": "50000", "cpu/cpu.cfs_period_us": "100000"}]


@pytest.mark.parametrize("files", CGROUPS, ids=["v2", "v1"])
def test_a_containers_processor_limit_is_seen(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, files: dict[str, str]
) -> None:
    for name, text in files.items():
        (tmp_path / name).parent.mkdir(exist_ok=True)
        (tmp_path / name).write_text(text + "\n")
    monkeypatch.setattr(machine, "CGROUP", tmp_path)
    status, text = one("cores", tmp_path)
    assert status == NOTE
    assert "limited to the time of 0.5; best is workers=1" in text


def test_a_containers_memory_limit_is_seen(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    (tmp_path / "memory.max").write_text(f"{300 * 2**20}\n")
    (tmp_path / "memory.current").write_text(f"{100 * 2**20}\n")
    (tmp_path / "cpu.max").write_text("max 100000\n")
    monkeypatch.setattr(machine, "CGROUP", tmp_path)
    status, text = one("memory", tmp_path)
    assert status == NOTE
    assert text.startswith("200 MB free of 300 MB: enough for 0 trials")
    assert one("cores", tmp_path)[0] == OK


def test_kernels_that_are_not_there_yet(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.delenv("NUMBA_DISABLE_JIT", raising=False)
    monkeypatch.setenv("NUMBA_CACHE_DIR", str(tmp_path / "cache"))
    status, text = one("kernels", tmp_path)
    assert status == NOTE
    assert text.startswith("not compiled yet")
    (tmp_path / "file").touch()
    monkeypatch.setenv("NUMBA_CACHE_DIR", str(tmp_path / "file/cache"))
    status, text = one("kernels", tmp_path)
    assert status == NOTE
    assert "file/cache cannot be written: compiled kernels are kept in" in text


def test_kernels_that_were_compiled_are_seen(tmp_path: Path) -> None:
    source = "import os\nfrom origami_lab.geometry.planar import cross\ncross(1, 2, 3, 4)\n"
    environment = {**os.environ, "PYTHONPATH": str(ROOT), "NUMBA_CACHE_DIR": str(tmp_path)}
    environment.pop("NUMBA_DISABLE_JIT", None)
    subprocess.run([sys.executable, "-c", source], env=environment, check=True)
    code = "import sys; from origami_lab.cli import main; sys.exit(main(['doctor']))"
    done = subprocess.run(
        [sys.executable, "-c", code], cwd=tmp_path, env=environment, capture_output=True, text=True, check=False
    )
    (line,) = (line for line in done.stdout.splitlines() if line.split()[1] == "kernels")
    assert line.startswith("ok")
    assert "compiled, " in line


def test_a_store_that_is_not_there_yet(tmp_path: Path) -> None:
    assert one("tracking", tmp_path) == (OK, f"{tmp_path}/results/mlflow.db is not there yet; the first run makes it")


def test_a_store_is_read_and_left_as_it_is(tmp_path: Path) -> None:
    path = make_store(tmp_path, newest_schema())
    before = path.read_bytes()
    assert one("tracking", tmp_path) == (OK, f"{path} with 2 experiments")
    assert one("tracking", Path("/"), f"sqlite:///{path}") == (OK, f"{path} with 2 experiments")
    assert path.read_bytes() == before
    assert list(path.parent.iterdir()) == [path]


def test_a_locked_store(tmp_path: Path) -> None:
    path = make_store(tmp_path, newest_schema())
    database = sqlite3.connect(path, isolation_level=None)
    database.execute("BEGIN EXCLUSIVE")
    try:
        assert one("tracking", tmp_path) == (PROBLEM, f"{path} is locked by another process")
    finally:
        database.close()


def test_stores_of_other_versions(tmp_path: Path) -> None:
    path = make_store(tmp_path, "0a8213491aaa", experiments=1)  # MLflow 1.0's
    status, text = one("tracking", tmp_path)
    assert status == NOTE
    assert text.startswith(f"{path} with 1 experiment, of an older MLflow")
    path.unlink()
    make_store(tmp_path, "fedcba987654")
    status, text = one("tracking", tmp_path)
    assert status == PROBLEM
    assert "of a newer MLflow (schema fedcba987654)" in text


@pytest.mark.parametrize("content", [b"", b"no database at all, but long enough to be read as one" * 20])
def test_what_is_no_store(tmp_path: Path, content: bytes) -> None:
    (tmp_path / "results").mkdir()
    (tmp_path / "results/mlflow.db").write_bytes(content)
    status, text = one("tracking", tmp_path)
    assert status == PROBLEM
    assert "is not an MLflow store" in text


class _Server(BaseHTTPRequestHandler):
    def do_GET(self) -> None:
        self.send_response(200 if self.path == "/version" else 404)
        self.end_headers()
        self.wfile.write(b"3.17.0")

    def log_message(self, *_: object) -> None:  # type: ignore[override]
        """Nothing."""


def test_servers(tmp_path: Path) -> None:
    server = HTTPServer(("127.0.0.1", 0), _Server)
    uri = f"http://127.0.0.1:{server.server_port}"
    thread = threading.Thread(target=server.serve_forever, daemon=True)
    thread.start()
    try:
        assert one("tracking", tmp_path, uri) == (OK, f"{uri} answers: MLflow 3.17.0")
        status, text = one("tracking", tmp_path, f"{uri}/elsewhere")
        assert status == NOTE
        assert "404" in text
    finally:
        server.shutdown()
        server.server_close()
        thread.join()
    status, text = one("tracking", tmp_path, uri)
    assert status == PROBLEM
    assert "does not answer" in text
    assert one("tracking", tmp_path, "postgresql://somewhere/db")[0] == NOTE
