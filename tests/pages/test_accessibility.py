"""What axe finds on our pages: needs ``npm install`` in viewer/, which has it as a dependency of its development."""

from __future__ import annotations

import json
import re
from pathlib import Path
from typing import Any
from urllib.parse import unquote

import pytest

from origami_lab.cli import main
from origami_lab.experiment.run_page import write_run_page
from tests.drawing.test_viewer import in_chromium, page, visit
from tests.report.runs import failed, trial, write_run

AXE = Path(__file__).parents[2] / "viewer/node_modules/axe-core/axe.min.js"
RUN = """
setTimeout(() => axe.run(document, {resultTypes: ["violations"]}).then(({violations}) => {
  document.documentElement.dataset.found = encodeURIComponent(JSON.stringify(
    violations.map(({id, impact, nodes}) => [id, impact, nodes[0].html])));
}), 1500);
"""


@in_chromium
@pytest.mark.slow
@pytest.mark.skipif(not AXE.is_file(), reason="axe is not installed in viewer/node_modules")
@pytest.mark.parametrize("scheme", ["light", "dark"])
def test_pages_have_no_serious_findings(scheme: str, tmp_path: Path) -> None:
    trials = [trial(-1.0, return_surface=-2.0, certificate="certified"), failed(), trial(-9.0, status="no design")]
    run = write_run(tmp_path / "run", "cube", "rdm", trials)
    write_run_page(run)
    assert main(["report", str(run), "--output", str(tmp_path / "report")]) == 0
    flags = ["--blink-settings=preferredColorScheme=0"] if scheme == "dark" else []
    for file in (run / "index.html", tmp_path / "report/index.html", page(tmp_path / "viewer.html")):
        script = f"<script>{AXE.read_text('utf-8')}\n{RUN}</script>"
        file.write_text(file.read_text("utf-8").replace("</body>", f"{script}</body>"), encoding="utf-8")
        match = re.search(r'data-found="([^"]*)"', visit(file, "--dump-dom", *flags))
        assert match is not None, file
        assert [found for found in decoded(match[1]) if found[1] in ("serious", "critical")] == [], file


def decoded(text: str) -> list[Any]:
    found: list[Any] = json.loads(unquote(text))
    return found
