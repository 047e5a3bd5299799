"""What a screen shows of a Gymnasium environment: its own picture, made small, or its own text."""

from typing import Any

import msgspec

from core.plugins import View

NO_ACTION = -(2**62)
"""Before the first step: an environment may number its actions from any number on."""


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
    action: int = NO_ACTION
    """The environment's own number of the last action; `NO_ACTION` before any in this game."""


def smaller(picture: Any, widest: int, highest: int) -> Any:
    """Return a picture of at most `widest` x `highest` pixels: means of blocks, shape (height, width, 3),
    bytes.

    Args:
        picture: shape (height, width, 3 or more), at least one pixel.
        widest: pixels, >= 1.
        highest: pixels, >= 1.
    """
    import numpy as np  # here, not above: a protocol is read without arrays

    height, width = picture.shape[:2]
    scale = max(1.0, width / widest, height / highest)
    rows = np.linspace(0, height, max(1, round(height / scale)) + 1).astype(int)
    columns = np.linspace(0, width, max(1, round(width / scale)) + 1).astype(int)
    sums = np.add.reduceat(np.add.reduceat(picture[..., :3].astype(float), rows[:-1]), columns[:-1], axis=1)
    sizes = np.diff(rows)[:, None, None] * np.diff(columns)[None, :, None]
    return (sums / sizes).astype(np.uint8)
