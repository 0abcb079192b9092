"""How far a sheet folds with each of several last children of an extension."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from origami_lab.game.kernels.play import play_action
from origami_lab.game.kernels.state import States, copy_state
from origami_lab.jit import kernel


@kernel
def reach_of_places(
    states: States, i: int, scratch: States, rules: States, actions: NDArray[np.int32], out: NDArray[np.int32]
) -> None:
    """Write the driving angles that the motion reaches after each of the legal actions, which complete an extension.

    ``rules`` have a ``min_reach`` of 0, or what does not reach the first angle would count as what was there before.
    """
    for k in range(actions.shape[0]):
        copy_state(scratch[0], states[i])
        play_action(scratch[0], rules[0], actions[k])
        out[k] = scratch[0].reach
