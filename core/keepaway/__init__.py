"""Keepaway soccer: a simulator of the RoboCup subtask, in compiled kernels."""
