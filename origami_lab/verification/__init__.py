"""Checking a folded design from its file alone, with nothing of the game's kinematics or collision code."""
