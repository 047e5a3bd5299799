"""Pictures of Tetris for programs without this program's screens: text, and pixels."""

import numpy as np
from numpy.typing import NDArray

from core.tetris.picture import CLEARED, FALLING, GHOST, Snapshot
from core.tetris.shapes import PIECE_NAMES

CELL = 16
"""Pixels across a cell."""
COLOURS = np.array(
    [
        (24, 24, 28),
        (86, 180, 233),
        (240, 228, 66),
        (204, 121, 167),
        (213, 94, 0),
        (0, 158, 115),
        (0, 114, 178),
        (230, 159, 0),
        (150, 150, 150),
    ],
    np.uint8,
)
"""Of an empty cell, of each piece by id, and of a cell whose piece nobody knows (Okabe & Ito 2008)."""


def _kinds(picture: Snapshot) -> NDArray[np.int64]:
    """Return piece id + 1 of each cell that is filled, 0 of others, shape (rows, columns), from the top."""
    codes = np.frombuffer(picture.codes(), np.uint8).astype(np.int64) & ~CLEARED
    codes = np.where(codes & GHOST, 0, codes & ~FALLING)
    return codes.reshape(picture.rows, picture.columns)


def picture_text(picture: Snapshot) -> str:
    """Return a picture as text: a letter for each filled cell, dots for empty ones, figures below."""
    letters = np.array([".", *PIECE_NAMES, "#"])
    lines = ["|" + "".join(row) + "|" for row in letters[_kinds(picture)].tolist()]
    counts = picture.counts
    following = PIECE_NAMES[counts.next_piece] if counts.next_piece >= 0 else "-"
    about = "game over" if picture.over else f"next {following}"
    floor = "+" + "-" * picture.columns + "+"
    return "\n".join([*lines, floor, f"lines {counts.lines}  pieces {counts.pieces}  {about}"]) + "\n"


def picture_pixels(picture: Snapshot) -> NDArray[np.uint8]:
    """Return a picture as pixels, shape (16 rows, 16 columns, 3), with a dark line between cells."""
    pixels = COLOURS[_kinds(picture)].repeat(CELL, axis=0).repeat(CELL, axis=1)
    pixels[CELL - 1 :: CELL] = 0
    pixels[:, CELL - 1 :: CELL] = 0
    return pixels
