"""Learners: arrays in, policies out; none of them knows a game."""
