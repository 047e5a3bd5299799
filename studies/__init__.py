"""Measures with core, writes files, draws. Never a screen."""
