"""The program's own games as Gymnasium environments: importing this module makes them known to Gymnasium.

`gymnasium.make("core.interop.gymnasium.envs:arl/Tetris-v0")` imports it by itself. (Gymnasium looks for no
entry points since 1.0.) The game is imported when it is made.
"""

from gymnasium.envs.registration import register, registry

TETRIS = "arl/Tetris-v0"


def register_envs() -> None:
    """Make the program's environments known to Gymnasium; a second call changes nothing."""
    if TETRIS not in registry:
        register(id=TETRIS, entry_point="core.interop.gymnasium.tetris_env:TetrisEnv")


register_envs()
