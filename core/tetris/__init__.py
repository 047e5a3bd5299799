"""Tetris: pieces, board kernels, features, primitive actions, compiled play."""

REVISION = 1
"""Of what the same seed plays: one more whenever that changes, so that a recording can say by which it was
played."""
