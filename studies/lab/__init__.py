"""A study with participants, from one file: its timeline, its conditions, who got which order, and where each
one is.
"""
