"""A photograph of MLflow's comparison page: ``python -m benchmarks.dashboard DIR --out docs/images/compare.png``

DIR is a multirun's folder that was tracked; the dashboard is started on its store, its runs are opened in headless
Chromium, which is driven through its debugging pipe, and the page is photographed once it has settled.
"""

from __future__ import annotations

import argparse
import base64
import io
import json
import os
import shutil
import signal
import socket
import subprocess
import sys
import tempfile
import time
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any
from urllib.parse import urlencode

from PIL import Image

from origami_lab.errors import InputError
from origami_lab.runs.multirun_folder import read_index
from origami_lab.runs.run_folder import read_note
from origami_lab.tracking.store import open_client

CHROMIUM = next(filter(None, map(shutil.which, ("chromium", "chromium-browser", "google-chrome"))), "chromium")
FLAGS = (
    "--headless",
    "--no-sandbox",
    "--disable-gpu",
    "--no-first-run",
    "--hide-scrollbars",
    "--remote-debugging-pipe",
)
WAIT_SECONDS = 60.0
ONLY_DIFFERENT = """
(() => {
  const toggle = [...document.querySelectorAll('button[role=switch]')][0];
  if (toggle && toggle.getAttribute('aria-checked') === 'false') toggle.click();
  const close = [...document.querySelectorAll('button')].find(b => b.getAttribute('aria-label') === 'Close');
  if (close) close.click();
  return Boolean(toggle) && document.querySelectorAll('.js-plotly-plot').length > 0;
})()
"""
"""Shows only the parameters that differ and closes what is in the way; whether the page is there."""


class Browser:
    """Headless Chromium, spoken to in JSON messages that end with a null byte."""

    def __init__(self, profile: str, size: tuple[int, int]) -> None:
        ours, theirs = os.pipe(), os.pipe()

        def hand_over() -> None:  # Chromium reads from 3 and writes to 4
            source, sink = os.dup(ours[0]), os.dup(theirs[1])
            os.dup2(source, 3)
            os.dup2(sink, 4)

        command = [
            CHROMIUM,
            *FLAGS,
            "--remote-debugging-pipe",
            f"--user-data-dir={profile}",
            f"--window-size={size[0]},{size[1]}",
        ]
        self.process = subprocess.Popen(
            command,
            preexec_fn=hand_over,
            close_fds=False,
            stdout=subprocess.DEVNULL,
            stderr=subprocess.DEVNULL,
        )
        os.close(ours[0])
        os.close(theirs[1])
        self.sink, self.source = os.fdopen(ours[1], "wb"), os.fdopen(theirs[0], "rb")
        self.number = 0
        self.session: str | None = None
        target = self.ask("Target.createTarget", url="about:blank")["targetId"]
        self.session = self.ask("Target.attachToTarget", targetId=target, flatten=True)["sessionId"]

    def ask(self, method: str, **params: object) -> dict[str, Any]:
        """Call a method of the DevTools protocol and return what it answers."""
        self.number += 1
        message: dict[str, object] = {"id": self.number, "method": method, "params": params}
        if self.session is not None:
            message["sessionId"] = self.session
        self.sink.write(json.dumps(message).encode() + b"\0")
        self.sink.flush()
        while True:
            answer = json.loads(self._read())
            if answer.get("id") == self.number:
                if "error" in answer:
                    raise RuntimeError(answer["error"]["message"])
                return dict(answer["result"])

    def _read(self) -> bytes:
        text = bytearray()
        while (byte := self.source.read(1)) != b"\0":
            if not byte:
                raise RuntimeError("Chromium has ended")
            text += byte
        return bytes(text)

    def value(self, script: str) -> Any:
        """What a script in the page comes to."""
        return self.ask("Runtime.evaluate", expression=script, returnByValue=True)["result"].get("value")

    def photograph(self) -> Image.Image:
        data = base64.b64decode(self.ask("Page.captureScreenshot", format="png")["data"])
        return Image.open(io.BytesIO(data)).convert("RGB")

    def close(self) -> None:
        self.process.kill()
        self.process.wait()


@contextmanager
def dashboard(store: str) -> Iterator[str]:
    """The address of `origami-lab dashboard` on a store."""
    with socket.socket() as probe:
        probe.bind(("127.0.0.1", 0))
        port = probe.getsockname()[1]
    command = [sys.executable, "-m", "origami_lab", "dashboard", "--uri", store, "--port", str(port)]
    process = subprocess.Popen(command, stdout=subprocess.PIPE, text=True)
    try:
        assert process.stdout is not None
        address = next(line.split()[0] for line in process.stdout if line.startswith("http"))
        yield address.partition("/#")[0]
    finally:
        process.send_signal(signal.SIGINT)
        process.wait()


def comparison(folder: Path) -> tuple[str, str]:
    """The store of a multirun's runs, and the address of their comparison in it."""
    index = read_index(folder)
    store = read_note(folder / index.jobs[0].folder).get("uri") if index else None
    if index is None or store is None:
        raise InputError("DIR", folder, "must be the folder of a multirun that was tracked")
    client = open_client(str(store))
    experiment = client.get_experiment_by_name(index.experiment)
    assert experiment is not None
    found = client.search_runs([experiment.experiment_id], f"tags.multirun = '{index.id}'", order_by=["start_time"])
    parents = [run.info.run_id for run in found if "seed" not in run.data.tags]
    query = urlencode({"runs": json.dumps(parents), "experiments": json.dumps([experiment.experiment_id])})
    return str(store), f"/#/compare-runs?{query}"


def photograph(address: str, size: tuple[int, int]) -> Image.Image:
    """The comparison once it has settled: two pictures a few seconds apart are the same."""
    with tempfile.TemporaryDirectory(ignore_cleanup_errors=True) as profile:
        browser = Browser(profile, size)
        try:
            browser.ask("Page.navigate", url=address)
            end = time.monotonic() + WAIT_SECONDS
            before = None
            while time.monotonic() < end:
                time.sleep(3)
                ready = browser.value(ONLY_DIFFERENT)
                now = browser.photograph()
                if ready and before is not None and now.tobytes() == before.tobytes():
                    return now
                before = now
            raise TimeoutError(f"the page has not settled within {WAIT_SECONDS:.0f} s")
        finally:
            browser.close()


def main() -> None:
    parser = argparse.ArgumentParser(description="Photograph MLflow's comparison of a multirun.")
    parser.add_argument("directory", type=Path)
    parser.add_argument("--out", type=Path, required=True)
    parser.add_argument("--size", type=int, nargs=2, default=(1500, 1500))
    options = parser.parse_args()
    store, page = comparison(options.directory)
    with dashboard(store) as address:
        picture = photograph(address + page, tuple(options.size))
    picture.quantize(128).save(options.out, optimize=True)
    print(f"{options.out}: {picture.width} x {picture.height}, {options.out.stat().st_size // 1024} kB")


if __name__ == "__main__":
    main()
