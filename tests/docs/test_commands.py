"""Each command that a page shows is run as it stands, but for a small budget."""

from __future__ import annotations

import shutil
from pathlib import Path

import pytest

from origami_lab.cli import main
from origami_lab.commands import COMMANDS
from origami_lab.config import build_parts, compose_settings
from tests.docs.page_blocks import PAGES, ROOT, Command, commands
from tests.small_runs import inside

ALL = [command for page in PAGES if page.name not in ("own-parts.md", "gallery.md") for command in commands(page)]
"""Parts of your own are run with their page's files by test_programs; designs of the gallery are composed below."""
SHOWN = list({command.words: command for command in reversed(ALL)}.values())[::-1]
"""Each once, though several pages may show it."""
SERVERS = {"dashboard", "studio"}
"""Commands that wait for a browser: their options are tested here, they themselves elsewhere."""
QUICK = ("budget=150", "seed=0", "files=designs", "tracking=none", "verbosity=quiet", "workers=1")
SMALLER = {
    "polish": ("--steps", "40", "--best", "1"),
    "sweep": ("workers=1", "budget=150", "seeds=0..1", "trials=2", "held_out.seeds=1000..1001", "tracking=none"),
}


@pytest.fixture(scope="module")
def desk(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A working directory with all that the pages' commands name."""
    folder = tmp_path_factory.mktemp("desk")
    for name in ("docs/parts", "results/beyond", "sweeps"):
        shutil.copytree(ROOT / name, folder / name)
    for name in ("part.stl", "bracket.stl"):
        shutil.copy(ROOT / "docs" / "parts" / "bracket.stl", folder / name)
    for name in ("best.fold", "anyones.fold", "best_bowl.fold"):
        shutil.copy(ROOT / "results" / "beyond" / "designs" / "bowl" / "best.fold", folder / name)
    run = ("target=bowl", "files=designs", "tracking=none", "verbosity=quiet", "workers=1", "budget=600", "seed=0..3")
    with inside(folder):
        for search in ("bfts", "lns"):
            assert main([*run, f"search={search}", f"output=results/bowl/{search}/TIME"]) == 0
        assert main([*run, "budget=100", "seed=0..1", "output=DIR"]) == 0
    return folder


def composes(words: tuple[str, ...]) -> None:
    """Check that settings are valid, of a multirun the first job's."""
    first = [word.partition(",")[0] if "[" not in word else word for word in words if word != "-m"]
    first = ["target=bowl" if word == "..." else word for word in first]  # what the reader is to say
    settings = compose_settings([word for word in first if not word.startswith("hydra")])
    build_parts(settings)


@pytest.mark.slow
@pytest.mark.parametrize("command", SHOWN, ids=str)
def test_a_command_of_a_page_runs(
    command: Command, desk: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.chdir(desk)
    word, *options = command.words
    if word in SERVERS and "--sync" not in options:
        if word not in COMMANDS:
            pytest.skip("there is no such command yet")
        assert main([word, "--help"]) == 0
        taken = capsys.readouterr().out
        assert all(option in taken for option in options if option.startswith("--"))
    elif command.composed and word == "sweep":
        assert (desk / options[0]).is_file()
    elif command.composed:
        composes(command.words)
    elif word in COMMANDS:
        assert main([*command.words, *SMALLER.get(word, ())]) in (0, 1 if word in ("verify", "doctor") else 0)
    elif "--help" in command.words or "--cfg" in command.words:
        assert main(command.words) == 0
    else:
        quick = [setting for setting in QUICK if "resume=true" not in command.words or "seed" not in setting]
        if any(setting.startswith("polish") for setting in command.words):
            quick.append("polish=30")
        if not any(setting.startswith("output=") for setting in command.words):
            quick.append(f"output=runs/{command.page.stem}-{command.line}")
        assert main([*command.words, *quick]) == 0


def test_commands_were_found_and_few_are_only_composed() -> None:
    assert len(SHOWN) > 40
    composed = [command for command in SHOWN if command.composed]
    assert 4 <= len(composed) <= 12, "those that need a cluster or a server"
    assert {command.words[0] for command in SHOWN} >= set(COMMANDS) - {"doctor"}


@pytest.mark.parametrize("command", dict.fromkeys(commands(ROOT / "docs" / "gallery.md")), ids=str)
def test_a_command_of_the_gallery_can_be_run(command: Command, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(ROOT)
    composes(command.words)
