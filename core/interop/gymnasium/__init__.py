"""Any Gymnasium environment with discrete actions as a game (extra `gym`)."""

REVISION = 1
"""Of what the same seed plays, as far as it is ours: the environment's own version is in its id."""
