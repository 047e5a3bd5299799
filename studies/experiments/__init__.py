"""Experiments: sweeps as data, runs, reports."""
