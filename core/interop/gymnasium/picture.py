"""What a screen shows of a Gymnasium environment: its own picture, made small, or its own text."""

import msgspec

from core.plugins import View


class EnvPicture(msgspec.Struct, View, frozen=True, kw_only=True, array_like=True, tag="gymnasium"):
    """One picture."""

    width: int = 0
    """Pixels across; 0 where there is text only."""
    height: int = 0
    """Pixels down."""
    pixels: bytes = b""
    """width x height x (red, green, blue), row by row from the top."""
    text: str = ""
    """The environment's text, where it draws none."""
    reward: float = 0.0
    """Sum of rewards so far in this game."""
    steps: int = 0
    """Steps so far in this game."""
