"""`origami-lab studio`: a page on this machine to design by hand, with the searchers as partners."""

from __future__ import annotations

import sys
import webbrowser
from collections.abc import Sequence
from contextlib import suppress
from importlib.util import find_spec
from pathlib import Path

from origami_lab.commands import whole
from origami_lab.commands.parser import Parser
from origami_lab.errors import InputError
from origami_lab.files import expanded

NEEDS = ("starlette", "uvicorn", "websockets")


def main(arguments: Sequence[str]) -> int:
    """Serve the page until Ctrl-C; returns the exit code."""
    parser = Parser(
        "origami-lab studio",
        description="Design by hand, in your browser: play the game, see the sheet fold, and let searchers go on, "
        "improve and repair. Only this machine can open the page, by the address that is printed.",
        epilog="Ctrl-C ends it. Nothing is written before you save, and then below output=DIR only.",
    )
    parser.add_argument(
        "words",
        nargs="*",
        metavar="WHAT",
        help="settings of a run (target=bowl), a saved design (a run, a trial, best.fold), or a mesh (part.stl);"
        " nothing for a gallery; output=DIR to save below it (default: results/studio/TIME)",
    )
    parser.add_argument("-cd", "--config-dir", metavar="DIR", help="a folder with options of your own, as for a run")
    parser.add_argument("--port", metavar="N", help="port to listen on (default: 8642, or any free one)")
    parser.add_argument("--no-open", action="store_true", help="print the address, and open no browser")
    options = parser.parse_intermixed_args(arguments)
    missing = [name for name in NEEDS if find_spec(name) is None]
    if missing:
        raise InputError("studio", ", ".join(missing), "is not installed: pip install 'origami-lab[studio]'")
    port = whole("--port", options.port)
    if port is not None and port > 65535:
        raise InputError("--port", port, "must be at most 65535")
    outputs = [word for word in options.words if word.startswith("output=")]
    words = [word for word in options.words if word not in outputs]
    own = None if options.config_dir is None else expanded(options.config_dir)
    if own is not None and not own.is_dir():
        raise InputError("--config-dir", options.config_dir, "there is no such folder")
    output = _folder(outputs[-1].removeprefix("output=")) if outputs else None

    from origami_lab.config.compose import working_directory_importable
    from origami_lab.studio.opening import open_design
    from origami_lab.studio.server import StudioServer, listen, serve_studio

    with listen(port) as listening, working_directory_importable():
        opened = open_design(words, own) if words else None
        if opened is not None:
            for line in opened.settings.part_lines:
                print(line, file=sys.stderr)
        studio = StudioServer(opened, output, listening.getsockname()[1], own)

        def ready() -> None:
            print(f"the studio: {studio.address}", flush=True)
            print("Ctrl-C ends it", flush=True)
            if not options.no_open:
                webbrowser.open(studio.address)

        with suppress(KeyboardInterrupt):
            serve_studio(studio, listening, ready)
    return 0


def _folder(text: str) -> Path:
    path = expanded(text)
    if not text.strip() or (path.exists() and not path.is_dir()):
        raise InputError("output", text, "must be a folder")
    return path
