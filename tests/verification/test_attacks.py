"""Files that are made to be certified falsely are not, honest ones beside them are, and a dense look agrees."""

from __future__ import annotations

import math
from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest

import origami_lab
from tests.known_designs.fold_documents import write
from tests.verification.attacks import ATTACKS, Attack, gate, rounded, star, with_flap
from tests.verification.dense import STEPS, first_crossing, random_pattern

KINDS = pytest.mark.parametrize("attack", ATTACKS, ids=[attack.__name__ for attack in ATTACKS])
CERTIFICATES = Path(__file__).with_name("cases") / "certificates"


def look(attack: Attack, path: Path) -> None:
    """Fail where a file has the wrong verdict, and leave the file behind."""
    certificate = origami_lab.verify(write(path / "attack.fold", attack.fold))
    assert (certificate.verdict == "certified") == attack.honest, f"{attack.name}\n{certificate.words()}"


@KINDS
def test_a_few_of_each_attack(attack: Callable[[np.random.Generator], Attack], tmp_path: Path) -> None:
    rng = np.random.default_rng([7, ATTACKS.index(attack)])
    for _ in range(3):
        look(attack(rng), tmp_path)


@pytest.mark.slow
@KINDS
def test_a_hundred_of_each_attack(attack: Callable[[np.random.Generator], Attack], tmp_path: Path) -> None:
    rng = np.random.default_rng([8, ATTACKS.index(attack)])
    for _ in range(100):
        look(attack(rng), tmp_path)


@pytest.mark.parametrize(
    ("name", "verdicts"),
    [
        ("tunnel_xy_-1", {"refuted"}),
        ("two_branches_same_angle", {"refuted", "not certifiable"}),
        ("flat_miura_4x4", {"not certifiable"}),
        ("garbage_last_frame_2d", {"refuted", "not certifiable"}),
        ("refuted_1_3", {"certified", "not certifiable"}),
        ("refuted_7_11", {"certified", "not certifiable"}),
    ],
)
def test_verdicts_that_were_wrong(name: str, verdicts: set[str]) -> None:
    assert origami_lab.verify(CERTIFICATES / f"{name}.fold").verdict in verdicts


def test_the_size_is_that_of_the_vertices_in_use(tmp_path: Path) -> None:
    near, far = (origami_lab.verify(write(tmp_path / "gate.fold", gate(1e-4, far, "unused"))) for far in (3.0, 30000.0))
    assert near.verdict == far.verdict == "refuted"
    assert near["sheet valid"].numbers["size"] == far["sheet valid"].numbers["size"]
    # where the flaps' tips meet: 1 + 1.0001·cos θ = 0
    meets = math.degrees(math.acos(-1.0 / 1.0001))
    assert near.angle == pytest.approx(meets, abs=1e-3)
    assert far.angle == pytest.approx(meets, abs=1e-3)
    assert near["crossing"].numbers["first"]


def test_a_flat_vertex_folds_and_a_blocked_one_does_not(tmp_path: Path) -> None:
    """Three creases cannot fold at all, four can; both have a freedom to first order in every state."""
    rng = np.random.default_rng(0)
    for count, verdict in ((3, "certified"), (4, "refuted")):
        fold = with_flap(star(np.arange(count) * 2 * math.pi / count + 0.1 * np.arange(count) ** 2, ["U"]), [30.0], rng)
        certificate = origami_lab.verify(write(tmp_path / "star.fold", fold))
        freedom = certificate["degrees of freedom"]
        assert freedom.numbers["freedoms_when_driven"] == count - 2
        assert certificate.verdict == verdict, certificate.words()


def test_rounding_narrows_what_is_certified(tmp_path: Path) -> None:
    """An open gate whose flaps come as near as a ten-thousandth: with five decimals that is too imprecise to tell."""
    fold = gate(-5e-5, 3.0, "unused", 179.5)
    assert origami_lab.verify(write(tmp_path / "gate.fold", fold)).verdict == "certified"
    certificate = origami_lab.verify(write(tmp_path / "gate.fold", rounded(fold, 5)))
    assert certificate.verdict == "not certifiable"
    assert "too imprecise to tell" in certificate.reason


def agrees(seed: int) -> tuple[str, bool]:
    """The verdict on a random pattern, which must be that of a dense look, and whether the game's rules made it."""
    rng = np.random.default_rng([9, seed])
    collisions = bool(seed % 3)
    pattern = random_pattern(rng, collisions=collisions)
    certificate = origami_lab.verify(pattern.design())
    near = [] if certificate.angle is None else [math.radians(certificate.angle)]
    try:
        first = first_crossing(pattern, STEPS, near)
    except ValueError:  # between two of its angles the game's motion does not exist
        assert certificate.verdict != "certified", certificate.words()
        return certificate.verdict, collisions
    if certificate.verdict == "certified":
        assert math.isinf(first), f"{seed}: {math.degrees(first)}\n{certificate.words()}"
    elif certificate.verdict == "refuted":
        assert math.isfinite(first), f"{seed}\n{certificate.words()}"
        if certificate["crossing"].numbers["first"]:
            assert certificate.angle == pytest.approx(math.degrees(first), abs=0.01), f"{seed}\n{certificate.words()}"
        else:
            assert certificate.angle >= math.degrees(first) - 0.01, f"{seed}\n{certificate.words()}"
            assert "before" in certificate.reason
    return certificate.verdict, collisions


def test_verdicts_agree_with_a_dense_look() -> None:
    assert {verdict for verdict, _ in map(agrees, range(12))} >= {"certified", "refuted"}


@pytest.mark.slow
def test_two_hundred_verdicts_agree_with_a_dense_look() -> None:
    found = [agrees(seed) for seed in range(100, 300)]
    of_the_game = [verdict for verdict, collisions in found if collisions]
    assert of_the_game.count("not certifiable") <= 2
