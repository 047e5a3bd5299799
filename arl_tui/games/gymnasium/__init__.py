"""Gymnasium environments in the app."""
