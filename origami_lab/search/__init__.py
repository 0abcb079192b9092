"""Searchers: each plays the game for a budget of interactions and reports its best designs."""
