"""Odd machines and habits: terminals that know few letters, streams that are closed or left, users without a home."""

from __future__ import annotations

import os
import subprocess
import sys
from collections.abc import Callable
from pathlib import Path

import pytest

from origami_lab import caches, errors, streams
from origami_lab.caches import homeless, kernel_cache, settle_matplotlib, temporary_folder
from origami_lab.cli import main

ROOT = Path(__file__).parents[2]
DESIGN = ROOT / "results/paper/designs/pyramid-rdm-seed0.fold"
COMMANDS: dict[str, tuple[list[str], int]] = {
    "verify": (["verify", str(DESIGN)], 0),
    "refuted": (["verify", "refuted.fold"], 2),
    "help": (["--help"], 0),
    "export": (["export", str(DESIGN), "--to", "svg", "--output", "x.svg"], 0),
    "misspelt": (["exprot", "x", "--to", "svg"], 2),
}
ASCII = {"LC_ALL": "C", "PYTHONUTF8": "0", "PYTHONIOENCODING": "ascii"}
POSIX = {"LC_ALL": "POSIX", "PYTHONUTF8": "0", "PYTHONCOERCECLOCALE": "0"}
CONDITIONS: dict[str, tuple[dict[str, str], str]] = {
    # variables of the environment, and how a shell redirects
    "ascii": (ASCII, ""),
    "posix": (POSIX, ""),
    "no output": ({}, ">&-"),
    "no errors": ({}, "2>&-"),
    "no input": ({}, "<&-"),
    "nothing": ({}, "<&- >&- 2>&-"),
    "left": ({}, "| head -1"),
}
TABLE = [("verify", condition) for condition in CONDITIONS] + [
    (command, condition) for command in list(COMMANDS)[1:] for condition in ("ascii", "nothing", "left")
]


def ended(place: Path, words: list[str], environment: dict[str, str], redirection: str) -> tuple[int, str, str]:
    """The exit code of a command, and what it wrote to standard output and errors."""
    script = f'{{ "$0" -m origami_lab "$@"; echo $? > code; }} {redirection}'
    if redirection and not redirection.startswith("|"):
        script = f'"$0" -m origami_lab "$@" {redirection}; echo $? > code'
    done = subprocess.run(
        ["bash", "-c", script, sys.executable, *words],
        env={**os.environ, "PYTHONPATH": str(ROOT), **environment},
        capture_output=True,
        cwd=place,
        check=False,
    )
    code = int((place / "code").read_text("ascii"))
    return code, done.stdout.decode("ascii" if environment else "utf-8"), done.stderr.decode("utf-8")


@pytest.mark.slow
@pytest.mark.parametrize(("command", "condition"), TABLE)
def test_a_command_ends_as_it_does_elsewhere(command: str, condition: str, tmp_path: Path) -> None:
    words, code = COMMANDS[command]
    environment, redirection = CONDITIONS[condition]
    found, out, err = ended(tmp_path, words, environment, redirection)
    assert found == code, err
    assert "Traceback" not in err
    assert "Exception" not in err
    assert len(err.splitlines()) == (code == 2 and "2>&-" not in redirection)
    closed = ">&-" in redirection.replace("2>&-", "")
    assert bool(out) == (code == 0 and not closed)
    if command == "verify" and not closed:
        assert out.startswith("certified")


@pytest.mark.slow
@pytest.mark.skipif(not Path("/dev/full").exists(), reason="needs /dev/full")
def test_a_full_disk_below_the_output_is_said(tmp_path: Path) -> None:
    code, _, err = ended(tmp_path, ["verify", str(DESIGN)], {}, ">/dev/full")
    assert code == errors.EXIT_INTERNAL
    assert err == "error: standard output could not be written (No space left on device)\n"


def broken(arguments: object) -> int:
    raise KeyError("a table\nof two lines")


@pytest.mark.parametrize(
    "command", ["verify", "export", "report", "doctor", "dashboard", "sweep", "polish", "simplify"]
)
def test_an_error_of_ours_has_a_code_of_its_own(
    command: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.setattr(f"origami_lab.commands.{command}.main", broken)
    monkeypatch.setattr("tempfile.tempdir", str(tmp_path))
    assert main([command]) == 70
    out, err = capsys.readouterr()
    assert out == ""
    assert err.startswith("error: internal error: KeyError: ")
    assert err.count("\n") == 1
    (file,) = tmp_path.iterdir()
    assert err.endswith(f"; traceback in {file}\n")
    assert "in broken" in file.read_text("utf-8")


def test_where_no_traceback_can_be_kept_the_line_says_how_to_see_it(monkeypatch: pytest.MonkeyPatch) -> None:
    def nowhere(**_: object) -> None:
        raise FileNotFoundError("no usable temporary directory")

    monkeypatch.setattr("tempfile.mkstemp", nowhere)
    assert errors.internal_error("OSError", "", "") == (
        "internal error: OSError; HYDRA_FULL_ERROR=1 in the environment shows its traceback"
    )


@pytest.mark.parametrize(
    ("text", "shown"),
    [("72° → 3", b"72? ? 3"), ("a\udcffb\udce4", b"a\xffb\xe4"), ("\ud800", b"?"), ("plain", b"plain")],
)
def test_letters_that_cannot_be_shown_are_replaced(text: str, shown: bytes) -> None:
    streams.codecs.register_error(streams.SHOWN, streams._shown)
    assert text.encode("ascii", streams.SHOWN) == shown


@pytest.fixture
def machine(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """A machine whose temporary files are in a folder, and which says nothing about caches."""
    for name in ("NUMBA_CACHE_DIR", "XDG_CACHE_HOME", "XDG_CONFIG_HOME", "MPLCONFIGDIR"):
        monkeypatch.delenv(name, raising=False)
    (tmp_path / "tmp").mkdir()
    monkeypatch.setattr("tempfile.tempdir", str(tmp_path / "tmp"))
    temporary_folder.cache_clear()
    yield tmp_path
    temporary_folder.cache_clear()


def no_home() -> Path:
    raise RuntimeError("Could not determine home directory.")


def test_a_home_that_can_be_written_keeps_the_kernels(machine: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("HOME", str(machine))
    assert kernel_cache() == caches.KernelCache(machine / ".cache/origami-lab")
    settle_matplotlib()
    assert "MPLCONFIGDIR" not in os.environ
    assert "HOME" not in homeless()


@pytest.mark.parametrize("kind", ["missing", "a file", "unknown"])
def test_without_a_home_kernels_are_kept_among_the_temporary_files(
    kind: str, machine: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    if kind == "unknown":
        monkeypatch.setattr(Path, "home", no_home)
    elif kind == "a file":
        (machine / "home").touch()
    else:
        monkeypatch.setattr("os.access", lambda place, mode: Path(place).is_relative_to(machine / "tmp"))
    monkeypatch.setenv("HOME", str(machine / "home"))
    found = kernel_cache()
    place = machine / f"tmp/origami-lab-{os.getuid()}"
    assert found.base == place / "kernels"
    assert "\n" not in found.remark
    assert str(found.base) in found.remark
    assert place.stat().st_mode & 0o077 == 0
    monkeypatch.setenv("MPLCONFIGDIR", "")
    monkeypatch.delenv("MPLCONFIGDIR")
    settle_matplotlib()
    assert os.environ.pop("MPLCONFIGDIR") == str(place / "matplotlib")
    assert homeless()["HOME"] == str(place)


def test_a_folder_that_others_can_write_is_not_trusted(machine: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    name = machine / f"tmp/origami-lab-{os.getuid()}"
    name.mkdir()
    name.chmod(0o777)
    found = temporary_folder()
    assert found is not None
    assert found != name
    assert found.stat().st_mode & 0o077 == 0


def as_nobody(*words: str) -> list[str]:
    """A command of a user who stands in no list and has no home, if this one may start such and Python lets them in."""
    plain = ["setpriv", "--reuid=12345", "--regid=12345", "--clear-groups", "env", "-u", "HOME", "-u", "USER"]
    packages = ":".join([str(ROOT), *(path for path in sys.path if path.endswith("-packages"))])
    version = f"python{sys.version_info.major}.{sys.version_info.minor}"
    for python in (sys.executable, f"/usr/bin/{version}"):
        command = [*plain, "-u", "LOGNAME", f"PYTHONPATH={packages}", "PYTHONDONTWRITEBYTECODE=1", python]
        try:
            if not subprocess.run([*command, "-c", "import numpy, yaml"], capture_output=True, check=False).returncode:
                return [*command, *words]
        except OSError:
            break
    pytest.skip("needs root, setpriv, and a Python that all may use")


@pytest.mark.slow
@pytest.mark.parametrize("home", ["", "HOME=/nonexistent", "HOME=/root"])
def test_a_user_without_an_entry_can_use_it(home: str, tmp_path: Path) -> None:
    """Their install is read-only, too: the files are another user's."""
    tmp_path.chmod(0o777)
    command = as_nobody("-m", "origami_lab")
    command[-3:-3] = [home] if home else []
    for folder in tmp_path.parents[:-1]:
        if not folder.stat().st_mode & 0o001:
            folder.chmod(folder.stat().st_mode | 0o011)
    design = tmp_path / "x.fold"
    design.write_bytes(DESIGN.read_bytes())
    words: list[tuple[list[str], Callable[[str], bool]]] = [
        (["verify", "x.fold"], lambda out: out.startswith("certified")),
        (["doctor"], lambda out: "compiled kernels are kept in" in out and "problem" not in out),
        (["export", "x.fold", "--to", "html"], lambda out: out.strip().endswith(".html")),
    ]
    for asked, holds in words:
        done = subprocess.run([*command, *asked], capture_output=True, text=True, cwd=tmp_path, check=False)
        assert done.returncode == 0, done.stderr
        assert holds(done.stdout), done.stdout
        assert all(line.startswith("note: ") for line in done.stderr.splitlines()), done.stderr


@pytest.mark.slow
def test_a_daemonic_process_runs_experiments(tmp_path: Path) -> None:
    """A process of a ``multiprocessing.Pool``, which may not have children otherwise."""
    program = """
import multiprocessing

def play(folder):
    import origami_lab
    words = ["target=pyramid", "search=rdm", "budget=200", "files=designs", "tracking=none", "verbosity=quiet"]
    return origami_lab.run([*words, "seed=0..1", "workers=2", f"output={folder}"]).exit_code

if __name__ == "__main__":
    with multiprocessing.get_context("spawn").Pool(1) as pool:
        print(pool.map(play, ["out"]))
"""
    (tmp_path / "play.py").write_text(program, encoding="utf-8")
    environment = {**os.environ, "PYTHONPATH": str(ROOT)}
    done = subprocess.run(
        [sys.executable, "play.py"], env=environment, capture_output=True, text=True, cwd=tmp_path, check=False
    )
    assert done.stdout == "[0]\n", done.stderr
    assert sorted(file.name for file in tmp_path.glob("out/seed=*")) == ["seed=0", "seed=1"]
