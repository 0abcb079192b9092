"""Small files of other programs' kinds, and the verdict that each deserves."""

from __future__ import annotations

from pathlib import Path

import pytest

import origami_lab
from origami_lab.verification.certificate import Certificate

CASES = Path(__file__).with_name("cases")


def verified(name: str) -> Certificate:
    return origami_lab.verify(CASES / f"{name}.fold")


@pytest.mark.parametrize(
    "name",
    [
        "inherited_classes",
        "inherited_classes_control",
        "tiny_z",
        "auxiliary_line",
        "auxiliary_line_control",
        "miura_exact",
        "miura_6",
    ],
)
def test_certified(name: str) -> None:
    certificate = verified(name)
    assert certificate.verdict == "certified", certificate.words()


def test_an_auxiliary_line_is_remarked_on() -> None:
    assert any("edge 5" in remark for remark in verified("auxiliary_line").remarks)


def test_nothing_is_contradicted() -> None:
    certificate = verified("folded_without_faces")
    assert certificate.exit_code == 3
    assert "faces_vertices" in certificate.reason
