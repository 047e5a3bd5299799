"""Any Gymnasium environment with discrete actions as a game, and Tetris as one of Gymnasium's (extra `gym`).

Protocols are read through this package, so it does not import Gymnasium. Where a program has imported it
before, `arl/Tetris-v0` is known to it from here on; otherwise import `core.interop.gymnasium.envs`.
"""

import sys

REVISION = 1
"""Of what the same seed plays, as far as it is ours: the environment's own version is in its id."""

if "gymnasium" in sys.modules:
    import core.interop.gymnasium.envs  # noqa: F401
