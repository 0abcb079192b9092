"""``NUMBA_DISABLE_JIT=1`` plays whole searches as the compiled kernels do."""

from __future__ import annotations

import json
import os
import subprocess
import sys
from pathlib import Path
from typing import Any

import pytest

from tests.search.both_ways import SEARCHES

pytestmark = pytest.mark.slow


def test_compiled_and_plain_searches_are_the_same(tmp_path: Path) -> None:
    found: list[dict[str, Any]] = []
    for off in ("0", "1"):
        file, environment = tmp_path / f"{off}.json", os.environ | {"NUMBA_DISABLE_JIT": off}
        subprocess.run([sys.executable, "-m", "tests.search.both_ways", str(file)], check=True, env=environment)
        found.append(json.loads(file.read_text()))
    compiled, plain = found
    assert compiled.keys() == plain.keys() == {*SEARCHES, "episodes"}
    assert sum(bool(one["actions"]) for one in compiled.values()) > len(compiled) // 2
    for name, one in compiled.items():
        other = plain[name]
        assert one["actions"] == other["actions"], name
        assert one.get("counts") == other.get("counts"), name
        assert one["returns"] == pytest.approx(other["returns"], abs=1e-9, rel=0), name
        assert one.get("report", {}) == pytest.approx(other.get("report", {}), abs=1e-9, rel=0), name
