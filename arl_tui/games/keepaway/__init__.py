"""Keepaway in the app."""
