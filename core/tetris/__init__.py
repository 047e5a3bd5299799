"""Tetris: pieces, board kernels, features, primitive actions, compiled play."""
