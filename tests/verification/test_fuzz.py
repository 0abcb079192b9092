"""Malformed, huge and hostile files: a verdict or one line, never a traceback, a hang, or more than a gigabyte."""

from __future__ import annotations

import json
import subprocess
import sys
from collections import Counter
from pathlib import Path

import pytest

from tests.verification.fuzz import MUTATIONS, files, sources

ROOT = Path(__file__).parents[2]


@pytest.mark.slow
@pytest.mark.skipif(not Path("/proc/self/status").exists(), reason="memory is read where Linux says it")
def test_spoiled_files_are_judged_or_refused_in_one_line(tmp_path: Path) -> None:
    spoiled = list(files())
    assert (len(sources()), len(MUTATIONS), len(spoiled)) == (20, 10, 200)
    assert max(len(data) for _, data in spoiled) > 2**20
    for number, (name, data) in enumerate(spoiled):
        (tmp_path / f"{number:03} {name}.fold").write_bytes(data)
    command = [sys.executable, "-m", "tests.verification.fuzz", str(tmp_path)]
    done = subprocess.run(command, cwd=ROOT, capture_output=True, text=True, check=False)
    lines = done.stdout.splitlines()
    assert done.returncode == 0, f"exit code {done.returncode} at {lines[-1:]}: {done.stderr[-2000:]}"
    decoder, codes = json.JSONDecoder(), Counter[tuple[str, int]]()
    for line in lines:
        about, end = decoder.raw_decode(line)
        found = json.loads(line[end:])
        code, said = found["code"], found["said"].splitlines()
        codes[about["command"], code] += 1
        assert code in ((0, 1, 2, 3) if about["command"] == "verify" else (0, 2)), line
        if code == 2:
            assert len(said) == 1, line
            assert said[0].startswith("error: "), line
            assert len(said[0]) < 500, line
        else:
            assert all(note.startswith("note: ") for note in said), line
        assert found["memory"] < 2**30, line
    assert sum(codes.values()) == 2 * 200
    # all kinds of ends were met
    assert min(codes["verify", code] for code in (0, 1, 2)) > 5, codes
    assert min(codes["export", code] for code in (0, 2)) >= 20, codes
