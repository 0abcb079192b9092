"""The keys that FOLD has no word for, written under our namespace."""

from __future__ import annotations

CREATOR = "origami-lab"
ANGLE = "origami_lab:driving_angle"
ACTIONS = "origami_lab:actions"
METADATA = "origami_lab:metadata"
MODE = "vertices_origami_lab:mode"
DRIVEN = "edges_origami_lab:driven"
