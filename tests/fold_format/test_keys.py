"""Every key of a FOLD file present or absent: what is left out contradicts nothing."""

from __future__ import annotations

import contextlib
import copy
import itertools
import json
from collections import Counter
from pathlib import Path

import pytest

import origami_lab
from origami_lab.errors import InputError
from origami_lab.fold_format.reader import read_fold
from tests.fold_format.corpus import corpus
from tests.fold_format.dialects import DIALECTS

CORPUS = corpus()
SHEET = (
    *("frame_classes", "vertices_coords", "edges_vertices"),
    *("edges_assignment", "edges_foldAngle", "faces_vertices"),
)
STATE = ("frame_classes", "edges_foldAngle", "frame_inherit", "vertices_coords", "frame_parent")


def outcomes(path: Path, name: str, dialect: str) -> Counter[str]:
    """The verdicts of one pattern in a dialect, with each set of keys left out of its key frame, its last or all."""
    whole = DIALECTS[dialect].write(CORPUS[name])
    found: Counter[str] = Counter()
    for keys, where in ((SHEET, "key"), (STATE, "all"), (STATE, "last")):
        for count in range(len(keys) + 1):
            for gone in itertools.combinations(keys, count):
                fold = copy.deepcopy(whole)
                frames = {"key": [fold], "all": fold.get("file_frames", []), "last": fold.get("file_frames", [])[-1:]}
                for frame in frames[where]:
                    for key in gone:
                        frame.pop(key, None)
                path.write_text(json.dumps(fold), encoding="utf-8")
                try:
                    certificate = origami_lab.verify(path)
                except InputError:
                    found["input"] += 1
                    continue
                assert certificate.verdict != "refuted", (where, gone, certificate.words())
                found[certificate.verdict] += 1
                with contextlib.suppress(InputError):  # and nothing else
                    read_fold(path)
    return found


@pytest.mark.parametrize("dialect", ["children", "folded first", "chain", "folded alone", "tilted"])
def test_nothing_is_refuted_for_what_it_leaves_out(dialect: str, tmp_path: Path) -> None:
    found = outcomes(tmp_path / "a.fold", "valley", dialect)
    assert found["certified"] > found["input"], found  # most can be told without


@pytest.mark.parametrize("key", [*SHEET, "file_frames", "file_title", "file_creator", "frame_title", "edges_faces"])
def test_null_is_as_good_as_missing(key: str, tmp_path: Path) -> None:
    fold = DIALECTS["children"].write(CORPUS["valley"])
    said = []
    for change in ("null", "missing"):
        changed = copy.deepcopy(fold)
        changed[key] = None
        if change == "missing":
            del changed[key]
        (tmp_path / "a.fold").write_text(json.dumps(changed), encoding="utf-8")
        try:
            said.append(origami_lab.verify(tmp_path / "a.fold").words())
        except InputError as error:
            said.append(str(error))
    assert said[0] == said[1]


@pytest.mark.parametrize("key", SHEET)
def test_every_property_is_inherited(key: str, tmp_path: Path) -> None:
    """A property in the parent, in a grandparent or in the frame itself is the same property."""
    pattern = CORPUS["huffman (80.0, 95.0, 70.0, 115.0)"]
    fold = DIALECTS["children"].write(pattern)
    sheet = {name: fold[name] for name in SHEET}
    said = []
    for holder in range(3):
        frames = [{}, {"frame_parent": 0, "frame_inherit": True}, {"frame_parent": 1, "frame_inherit": True}]
        frames[2] |= {name: value for name, value in sheet.items() if name != key}
        frames[holder][key] = sheet[key]
        if holder == 0:
            frames[0] |= {"frame_classes": frames[0].get("frame_classes", ["graph"])}
        states = [frame | {"frame_parent": 2} for frame in fold["file_frames"]]
        (tmp_path / "a.fold").write_text(json.dumps({**frames[0], "file_frames": [*frames[1:], *states]}))
        said.append(origami_lab.verify(tmp_path / "a.fold"))
    assert {certificate.verdict for certificate in said} == {"certified"}, [c.words() for c in said]
