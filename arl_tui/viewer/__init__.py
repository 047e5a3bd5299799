"""Screens of the viewer: a recorded session on a timeline (`arl watch FILE.jsonl`)."""
