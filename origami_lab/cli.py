"""The command `origami-lab`.

An override always holds ``=`` or starts with ``-``, ``+`` or ``~``, so a bare word is a subcommand; without
one the command is a Hydra application. Every error of the user's is one line on stderr and exit code 2.
"""

from __future__ import annotations

import os
import sys
import traceback
from collections.abc import Sequence
from difflib import get_close_matches
from importlib import import_module
from pathlib import Path

from origami_lab.about import __version__
from origami_lab.addresses import hidden, hidden_word
from origami_lab.commands import COMMANDS
from origami_lab.errors import EXIT_INPUT, EXIT_INTERNAL, EXIT_INTERRUPTED, InputError, internal_error
from origami_lab.streams import make_robust, trouble_of_output
from origami_lab.workers.interrupts import process_interrupts

FLAGS_WITH_VALUE = (
    *("--config-path", "-cp", "--config-name", "-cn", "--config-dir", "-cd"),
    *("--cfg", "-c", "--package", "-p", "--info", "-i", "--experimental-rerun"),
)
HELP = {"--help", "-h"}
FLAGS = (
    *HELP,
    "--hydra-help",
    "--resolve",
    "--run",
    "-r",
    "--multirun",
    "-m",
    "--shell-completion",
    "-sc",
)


SECRET_TYPED = (
    "the command holds an address with a password, a token or a query, which others on this machine can see while it"
    " runs; it is written nowhere (docs/tracking.md says where else to give it)"
)


def main(arguments: Sequence[str] | None = None) -> int:
    """Run the command and return its exit code.

    Without ``arguments`` this process is the command itself: signals that end it make the exit code 130, and nothing
    that its standard streams cannot take ends it or changes its exit code, but a full disk below its output.
    """
    if arguments is not None:
        return _run(list(arguments))
    make_robust()
    with process_interrupts():
        code = _run(sys.argv[1:])
        if trouble := trouble_of_output():
            print(f"error: standard output could not be written ({trouble.strerror})", file=sys.stderr)
            return EXIT_INTERNAL
        return code


def _run(typed: list[str]) -> int:
    arguments = [hidden_word(word) for word in typed]
    if typed != arguments:
        print(f"warning: {SECRET_TYPED}", file=sys.stderr)
    try:
        return _dispatch(arguments)
    except SystemExit as ended:  # argparse's: --help, or it has said what is wrong
        return ended.code if isinstance(ended.code, int) else EXIT_INPUT if ended.code else 0
    except KeyboardInterrupt:
        print("interrupted", file=sys.stderr)
        return EXIT_INTERRUPTED
    except InputError as error:
        print(f"error: {error}", file=sys.stderr)
        return EXIT_INPUT
    except Exception as error:
        if _wants_traceback(arguments):
            sys.stderr.write(hidden(traceback.format_exc()))
        line = internal_error(type(error).__name__, hidden(str(error)), hidden(traceback.format_exc()))
        print(f"error: {line}", file=sys.stderr)
        return EXIT_INTERNAL


def _dispatch(arguments: list[str]) -> int:
    if "--version" in arguments:
        print(f"origami-lab {__version__}")
        return 0
    words, overrides, flags = _sort(arguments)
    if words and words[0] in COMMANDS:
        rest = list(arguments)
        rest.remove(words[0])
        return int(import_module(f"origami_lab.commands.{words[0]}").main(rest))
    if HELP & set(flags):
        from origami_lab.commands.help_pages import help_text

        print(help_text([*(word for word in words if word not in flags), *overrides], flags))
        return 0
    configuration = len(words) == 1 and words[0].endswith((".yaml", ".yml"))
    if words and not configuration:  # before its flags, which are another command's perhaps
        raise _no_command(words[0])
    for flag in flags:
        if flag.startswith("-") and flag.partition("=")[0] not in (*FLAGS, *FLAGS_WITH_VALUE):
            raise InputError("flag", flag, "there is no such flag; see --help")
    from origami_lab.commands import run as experiment

    return experiment.rerun(words[0], overrides, flags) if words else experiment.run(overrides, flags)


def _no_command(word: str) -> InputError:
    """The error for a bare word, with the command or setting that it may have been meant for."""
    from origami_lab.config.option_files import groups

    expected = f"must be {' or '.join(sorted(COMMANDS))}, a config.yaml, or settings like target=bowl"
    if Path(word).suffix.lower() in (".stl", ".obj", ".ply", ".off", ".glb", ".gltf"):
        return InputError("command", word, f"a mesh file is given as target=mesh target.path={word}")
    if word == "help":
        return InputError("command", word, f"did you mean --help? {expected}")
    found = get_close_matches(word, COMMANDS, n=1)
    if found:
        return InputError("command", word, f"{expected}; did you mean {found[0]}?")
    for group, folder in groups().items():
        if (folder / f"{word}.yaml").is_file():
            return InputError("command", word, f"{expected}; did you mean {group}={word}?")
        if get_close_matches(word, [group], cutoff=0.8):
            return InputError("command", word, f"{expected}; {group}=... sets the {group}")
    return InputError("command", word, expected)


def _sort(arguments: Sequence[str]) -> tuple[list[str], list[str], list[str]]:
    """Bare words, overrides, and flags with their values: Hydra's parser wants overrides in one piece."""
    words: list[str] = []
    overrides: list[str] = []
    flags: list[str] = []
    wants_value = False
    for argument in arguments:
        if (wants_value and "=" not in argument and not argument.startswith("-")) or argument.startswith("-"):
            flags.append(argument)
        elif "=" in argument or argument.startswith(("+", "~")):
            overrides.append(argument)
        else:
            words.append(argument)
        wants_value = argument in FLAGS_WITH_VALUE
    return words, overrides, flags


def _wants_traceback(arguments: Sequence[str]) -> bool:
    return "verbosity=verbose" in arguments or os.environ.get("HYDRA_FULL_ERROR") == "1"


if __name__ == "__main__":
    raise SystemExit(main())
