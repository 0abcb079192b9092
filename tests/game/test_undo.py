"""Taking actions back, against copies made before they were played."""

from __future__ import annotations

import numpy as np
import pytest

from origami_lab.game.game import Game
from origami_lab.game.kernels.play import copy_to
from origami_lab.game.kernels.state import States
from origami_lab.game.kernels.undo import note_dtype, step_back, step_noted
from origami_lab.game.start_patterns import Crease, Panel, Rectangle, Square, Start

GAMES: list[tuple[int, str, Start, float | None]] = [
    (9, "none", Square("choose"), None),
    (9, "x", Square("choose"), None),
    (13, "y", Square(2), 3.0),
    (13, "xy", Square("choose"), None),
    (25, "xyd", Square("choose"), 2.9),
    (13, "none", Crease("choose"), None),
    (13, "y", Crease("choose"), 4.0),
    (9, "none", Rectangle(), None),
    (9, "x", Rectangle(), None),
    (9, "none", Crease(ends="choose"), 4.0),
    (11, "xy", Square("choose"), -4.0),
    (11, "none", Crease(0), -4.0),
    (11, "y", Panel(((0, 2), (-2, 1), (-1, -2), (1, -2), (2, 1)), (0, 0, 1, 0, 0)), None),
]


def used_part(game: Game, states: States) -> bytes:
    """All that a copy keeps of a state: its used rows, and nothing else."""
    out = np.zeros(1, dtype=game.rules.dtype)
    copy_to(out, 0, states, 0)
    return out.tobytes()


@pytest.mark.parametrize(("size", "symmetry", "start", "length"), GAMES)
def test_an_action_taken_back_leaves_no_trace(size: int, symmetry: str, start: Start, length: float | None) -> None:
    sources = length is None or length > 0 or "boundary"  # a negative length: sources anywhere, too
    game = Game(size, symmetry, start, max_crease_length=length and abs(length), source_action=sources)
    rng = np.random.default_rng(7)
    legal = np.empty(game.rules.max_legal, dtype=np.int32)
    notes = np.empty(200, dtype=note_dtype(len(game.angles)))
    completed = 0
    for _ in range(60):
        states = game.new_states(1)
        before: list[bytes] = []
        for _ in range(120):
            choices = game.legal(states)
            back = len(before) > 0 and (len(choices) == 0 or rng.random() < 0.3)
            if back:
                for _ in range(int(rng.integers(1, 1 + min(len(before), 6)))):
                    expected = before.pop()
                    step_back(states, 0, notes, len(before))
                    assert used_part(game, states) == expected
                continue
            # terminating is seldom interesting
            action = int(rng.choice(choices[choices != 3 * game.rules.points] if len(choices) > 1 else choices))
            before.append(used_part(game, states))
            _, complete = step_noted(states, 0, game.rules.record, action, notes, len(before) - 1, legal)
            completed += complete
        while before:
            expected = before.pop()
            step_back(states, 0, notes, len(before))
            assert used_part(game, states) == expected
    assert completed > 300  # moves that had overwritten something
