"""What a folded shape is scored by: targets and objectives."""
