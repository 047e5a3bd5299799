"""Keepaway soccer: a simulator of the RoboCup subtask, in compiled kernels."""

REVISION = 2
"""Of what the same seed plays: one more whenever that changes, so that a recording can say by which it was
played."""
