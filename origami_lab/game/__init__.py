"""The origami game: a board, its rules, and finished designs."""
