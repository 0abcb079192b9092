"""No secret of an address is written, shown or handed on: every byte of files, output and commands is looked at."""

from __future__ import annotations

import http.server
import json
import os
import subprocess
import sys
import threading
import time
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import pytest
import yaml

import origami_lab.addresses as addresses
from origami_lab.addresses import NOTED, hidden, hidden_word, keep, whole, without_secrets
from origami_lab.cli import main
from origami_lab.config.compose import compose_settings
from origami_lab.errors import InputError
from origami_lab.runs.run_folder import read_note, write_note
from origami_lab.sweep.storage import storage_name
from origami_lab.sweep.sweep_config import read_declaration
from origami_lab.text import command_text
from origami_lab.tracking.store import check_store, explain, how_to_look, shown
from tests.small_runs import SMALL

ROOT = Path(__file__).parents[2]
SECRET = "sEcr3tW0rd"
HOLDING = {
    "password": ("http://me:{}@h0st:5000", "http://h0st:5000"),
    "a name alone": ("https://{}@h0st/path", "https://h0st/path"),
    "a token in the query": ("http://h0st:5000/x?token={}", "http://h0st:5000/x"),
    "a query with an at sign": ("http://h0st:5000?token=a@{}", "http://h0st:5000"),
    "a fragment": ("http://h0st#{}", "http://h0st"),
    "a database": ("postgresql://me:{}@h0st:5432/db", "postgresql://me@h0st:5432/db"),
    "a driver": ("postgresql+psycopg://me:{}@h0st/db?sslmode=require", "postgresql+psycopg://me@h0st/db"),
    "a database's query": ("mysql://h0st/db?user=me&password={}", "mysql://h0st/db"),
    "percents": ("postgresql://me:a%40{}%2F@h0st/db", "postgresql://me@h0st/db"),
    "a slash": ("postgresql://me:a/{}@h0st/db", "postgresql://me@h0st/db"),
    "an at sign": ("postgresql://me:a@{}@h0st/db", "postgresql://me@h0st/db"),
    "a question mark": ("postgresql://me:a?{}@h0st/db", "postgresql://me@h0st/db"),
    "IPv6": ("http://me:{}@[::1]:5000", "http://[::1]:5000"),
}
PLAIN = [
    *("http://h0st:5000", "postgresql://me@h0st/db", "sqlite:////a/b@c/my.db", "sqlite:///x.db?mode=ro", "databricks"),
    *("databricks://profile", "file:///a/b", "study.journal", "/a/b@c.journal", "results/mlflow.db", ""),
]


@pytest.fixture(autouse=True)
def _nothing_noted(monkeypatch: pytest.MonkeyPatch) -> None:
    for name in (NOTED, *addresses.GIVEN):
        monkeypatch.setenv(name, "")  # so that what a test notes goes
        monkeypatch.delenv(name)


@pytest.mark.parametrize(("address", "written"), HOLDING.values(), ids=HOLDING)
def test_an_address_without_its_secrets(address: str, written: str) -> None:
    address = address.format(SECRET)
    assert without_secrets(address) == written
    assert without_secrets(written) == written
    assert whole(written) == written
    assert keep(address) == written
    assert whole(written) == address
    for text in (address, f"a {address} b", f"tracking.uri={address}", f"'{address}'"):
        assert SECRET not in hidden(text)
    if f":{SECRET}@" in address:
        assert SECRET not in hidden(f"{SECRET} alone")
    for word in (f"tracking.uri={address}", f"--uri={address}", address, f"storage='{address}'", f'uri="{address}"'):
        assert SECRET not in hidden_word(word)
        assert written in hidden_word(word)
    assert SECRET not in command_text(["origami-lab", f"tracking.uri={address}"])
    for say in (shown, how_to_look):
        assert SECRET not in say(address)
    assert SECRET not in explain(RuntimeError(f"cannot reach {address} now"), address)


@pytest.mark.parametrize("address", PLAIN)
def test_an_address_without_secrets_stays(address: str) -> None:
    assert without_secrets(address) == keep(address) == whole(address) == address
    assert NOTED not in os.environ
    assert hidden_word(f"tracking.uri={address}") == f"tracking.uri={address}"


def test_whole_addresses_may_come_from_the_environment(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("MLFLOW_TRACKING_URI", f"http://me:{SECRET}@h0st")
    monkeypatch.setenv("OPTUNA_STORAGE", f"postgresql://me:{SECRET}@h0st/db")
    assert whole("http://h0st") == f"http://me:{SECRET}@h0st"
    assert whole("postgresql://me@h0st/db") == f"postgresql://me:{SECRET}@h0st/db"
    assert whole("postgresql://you@h0st/db") == "postgresql://you@h0st/db"
    assert keep("http://you:0ther@h0st") == "http://h0st"
    assert whole("http://h0st") == "http://you:0ther@h0st"  # what was typed wins


TYPOS = [
    *("htp://me:{}@h0st", "http:/me:{}@h0st", "http//me:{}@h0st", "http:me:{}@h0st", "me:{}@h0st:5000", "://me:{}@h"),
    *("http://me:{}@h0st:99999", "http://me:{}@", "http://me:{}@:5000", "postgresql:/me:{}@h0st/db", "ftp://{}@h0st"),
    *("http:///h0st?token={}", "htps://h0st?token={}", "http:/h0st?access_token={}", "postgresql;//me:{}@h0st/db"),
]


@pytest.mark.parametrize("typo", TYPOS)
def test_a_typing_error_is_echoed_without_secrets(typo: str) -> None:
    address = typo.format(SECRET)
    with pytest.raises(InputError) as refused:
        check_store(address)
    assert SECRET not in str(refused.value)
    for field in ("tracking.uri", "trackin.uri", "storage", "storag", "command"):
        assert SECRET not in str(InputError(field, address, f"cannot be {address}"))


@pytest.mark.parametrize("typo", [TYPOS[1], TYPOS[4], TYPOS[-2]])
def test_every_command_echoes_it_so(
    typo: str, capfd: pytest.CaptureFixture[str], tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    address = typo.format(SECRET)
    monkeypatch.chdir(tmp_path)
    Path("sweep.yaml").write_text(yaml.safe_dump({"task": ["target=cube"], "searcher": "evo", "space": {}}))
    for words in (
        ["target=cube", f"tracking.uri={address}", "output=out"],
        ["target=cube", f"trackin.uri={address}", "output=out"],
        ["target=cube", f"tracking.uri={address}[", "output=out"],
        ["target=cube", f"tracking.uri='{address}", "output=out"],
        [f"{address}"],
        ["sweep", "sweep.yaml", f"storage={address}", "output=out"],
        ["sweep", "sweep.yaml", f"storag={address}", "output=out"],
        ["dashboard", "--uri", address],
        ["dashboard", "--urii", address],
        ["dashboard", f"--urii={address}"],
        ["doctor", "--uri", address],
    ):
        assert main(words) != 0
        said = capfd.readouterr()
        assert SECRET not in said.out + said.err, words
    assert not Path("out").exists()


@pytest.mark.parametrize(("address", "written"), HOLDING.values(), ids=HOLDING)
def test_a_configuration_holds_none(
    address: str, written: str, tmp_path: Path, capfd: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.chdir(tmp_path)
    address = address.format(SECRET)
    monkeypatch.setenv("MY_STORE", address)
    for word in (f"tracking.uri='{address}'", "tracking.uri='${oc.env:MY_STORE}'"):
        settings = compose_settings(["target=cube", word])
        assert settings.tracking.uri == settings.config["tracking"]["uri"] == written
        assert whole(written) == address
    for more in ([], ["--resolve"]):
        for word in (f"tracking.uri='{address}'", "tracking.uri='${oc.env:MY_STORE}'"):
            assert main(["target=cube", word, "--cfg", "job", *more]) == 0
            said = capfd.readouterr()
            assert SECRET not in said.out + said.err
            assert said.err.count("warning:") == (address in word)
    Path("conf/experiment").mkdir(parents=True)
    Path("conf/experiment/night.yaml").write_text(f"# @package _global_\ntracking:\n  uri: '{address}'\n")
    assert main(["--config-dir", "conf", "target=cube", "experiment=night", "--cfg", "job"]) == 0
    assert SECRET not in capfd.readouterr().out
    sweep = {"task": ["target=cube"], "searcher": "evo", "space": {"search.elite": {"choices": [0, 1]}}}
    Path("sweep.yaml").write_text(yaml.safe_dump({**sweep, "storage": address, "tracking": {"uri": address}}))
    found = read_declaration(Path("sweep.yaml"))
    assert (found.storage, found.tracking.uri) == (written, written)
    assert SECRET not in repr(found) + storage_name(found)


def test_a_note_of_an_earlier_version_is_cleaned(tmp_path: Path) -> None:
    (tmp_path / "tracking.json").write_text(json.dumps({"uri": f"http://me:{SECRET}@h0st", "key": "a"}))
    note = read_note(tmp_path)
    assert note == {"uri": "http://h0st", "key": "a"}
    assert whole("http://h0st") == f"http://me:{SECRET}@h0st"
    write_note(tmp_path, note)
    assert SECRET not in (tmp_path / "tracking.json").read_text()


class _Refuses(http.server.BaseHTTPRequestHandler):
    """A server that wants a password which it never gets right, and notes what it was given."""

    given: list[str]

    def _answer(self) -> None:
        self.given.append(str(self.headers.get("Authorization")))
        self.send_response(200 if self.path == "/health" else 401)
        self.end_headers()

    do_GET = do_POST = _answer  # noqa: N815

    def log_message(self, *_: Any) -> None:
        pass


@pytest.fixture
def server() -> Iterator[tuple[str, list[str]]]:
    given: list[str] = []
    listening = http.server.ThreadingHTTPServer(("127.0.0.1", 0), type("_Here", (_Refuses,), {"given": given}))
    threading.Thread(target=listening.serve_forever, daemon=True).start()
    yield f"127.0.0.1:{listening.server_port}", given
    listening.shutdown()
    listening.server_close()


def commands_below(pid: int) -> bytes:
    """The command lines of all processes that one has started, and of those that these have."""
    found, typed = b"", Path(f"/proc/{pid}/cmdline")
    for task in Path(f"/proc/{pid}/task").glob("*/children"):
        try:
            for child in task.read_text().split():
                # a child that has not begun its own command yet shows its parent's, which is what the user typed
                own = Path(f"/proc/{child}/cmdline").read_bytes()
                found += (b"" if own == typed.read_bytes() else own) + commands_below(int(child))
        except OSError:  # it has ended
            continue
    return found


def watched(folder: Path, *words: str, **environment: str) -> tuple[int, bytes, bytes]:
    """A command's exit code, all that it wrote, and the commands of the processes that it started."""
    process = subprocess.Popen(
        [sys.executable, "-m", "origami_lab", *words],
        cwd=folder,
        env={**os.environ, "PYTHONPATH": str(ROOT), "TMPDIR": str(folder), **environment},
        stdout=(folder / "stdout").open("wb"),
        stderr=(folder / "stderr").open("wb"),
    )
    commands = b""
    while process.poll() is None:
        commands += commands_below(process.pid)
        time.sleep(0.05)
    return process.returncode, (folder / "stdout").read_bytes() + (folder / "stderr").read_bytes(), commands


def holders(folder: Path) -> list[str]:
    """Files below a folder that hold the secret."""
    files = [file for file in folder.rglob("*") if file.is_file()]
    return [str(file.relative_to(folder)) for file in files if SECRET.encode() in file.read_bytes()]


@pytest.mark.slow
@pytest.mark.skipif(not Path("/proc/self/task").is_dir(), reason="looks at the commands of processes")
def test_a_whole_run_its_resumption_and_a_later_push(tmp_path: Path, server: tuple[str, list[str]]) -> None:
    place, given = server
    words = [*SMALL, "seed=0", "budget=60", "files=designs", "workers=1", "output=out"]
    code, said, commands = watched(tmp_path, *words, f"tracking.uri=http://me:{SECRET}@{place}")
    assert code == 0
    assert said.count(b"others on this machine can see") == 1
    assert b"refuses access" in said
    assert b"push_process" in commands
    assert any(one.startswith("Basic ") for one in given)  # it was used
    runs = [
        [*words, "seed=0..1", "resume=true"],
        ["dashboard", "--sync", "out"],
    ]
    for again in runs:
        given.clear()
        _, said_again, commands_again = watched(
            tmp_path, *again, MLFLOW_TRACKING_USERNAME="me", MLFLOW_TRACKING_PASSWORD=SECRET
        )
        assert any(one.startswith("Basic ") for one in given), again
        assert SECRET.encode() not in said_again + commands_again
    assert SECRET.encode() not in said + commands
    assert holders(tmp_path) == []
    assert json.loads((tmp_path / "out/tracking.json").read_text())["uri"] == f"http://{place}"


@pytest.mark.slow
def test_a_multirun_and_a_sweep(tmp_path: Path) -> None:
    few = ["budget=60", "files=designs", "workers=1", "verbosity=quiet", "output=many"]
    address = f"postgresql://me:{SECRET}@127.0.0.1:9/db"
    code, said, commands = watched(
        tmp_path, "-m", "target=pyramid", "search=rdm,dfts", f"tracking.uri={address}", "tracking.kind=none", *few
    )
    assert code == 0
    sweep = {"task": ["target=pyramid"], "searcher": "evo", "space": {"search.elite": {"choices": [0, 1]}}}
    (tmp_path / "sweep.yaml").write_text(yaml.safe_dump({**sweep, "tracking": "none"}))
    storage = watched(tmp_path, "sweep", "sweep.yaml", f"storage={address}", "output=swept")
    assert storage[0] != 0
    assert SECRET.encode() not in said + commands + storage[1] + storage[2]
    assert holders(tmp_path) == []


def test_no_page_teaches_to_type_one() -> None:
    for page in [ROOT / "README.md", *(ROOT / "docs").glob("*.md"), *(ROOT / "sweeps").glob("*.yaml")]:
        text = page.read_text(encoding="utf-8")
        assert "PASSWORD@" not in text, page
        assert "?token=" not in text, page
