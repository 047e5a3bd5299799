"""Widgets draw."""
