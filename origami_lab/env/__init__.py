"""The game as a Gymnasium environment. Importing this registers ``origami_lab/RigidOrigami-v0``.

``gymnasium.make("origami_lab.env:origami_lab/RigidOrigami-v0", overrides=["target=bowl"])`` imports it by itself;
``gymnasium.make_vec`` of the same id makes the vectorised form. See docs/gymnasium.md.
"""

from __future__ import annotations

try:
    import gymnasium
except ImportError as error:
    raise ImportError("origami_lab.env needs Gymnasium: pip install 'origami-lab[gym]'") from error

from origami_lab.env.environment import RigidOrigamiEnv
from origami_lab.env.vector_environment import RigidOrigamiVectorEnv

__all__ = ["ENV_ID", "RigidOrigamiEnv", "RigidOrigamiVectorEnv"]

ENV_ID = "origami_lab/RigidOrigami-v0"

if ENV_ID not in gymnasium.registry:
    gymnasium.register(
        ENV_ID,
        entry_point="origami_lab.env.environment:RigidOrigamiEnv",
        vector_entry_point="origami_lab.env.vector_environment:RigidOrigamiVectorEnv",
    )
