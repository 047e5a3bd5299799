"""Tetris in the app."""
