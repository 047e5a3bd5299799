"""The seven tetrominoes as arrays, for kernels; see `core.tetris.shapes` for what they mean."""

import numpy as np
from numpy.typing import NDArray

from core.tetris.shapes import (
    MAX_SHAPE_SIZE,
    N_PIECES,
    ORIENTATION_ROWS,
    PIECE_NAMES,
    column_masks,
    lowest_bit,
    seven_bag_piece,
    splitmix64,
    uniform_piece,
)

__all__ = [
    "FIRST_SHAPE",
    "MAX_SHAPE_SIZE",
    "N_ORIENTATIONS",
    "N_PIECES",
    "N_SHAPES",
    "ORIENTATION_ROWS",
    "PIECE_NAMES",
    "SHAPE_BOTTOMS",
    "SHAPE_COLUMNS",
    "SHAPE_HEIGHTS",
    "SHAPE_TOPS",
    "SHAPE_WIDTHS",
    "all_placements",
    "seven_bag_piece",
    "shape_index",
    "splitmix64",
    "uniform_piece",
]


def _frozen(values: list[int] | list[list[int]]) -> NDArray[np.int64]:
    table = np.array(values, dtype=np.int64)
    table.flags.writeable = False
    return table


_SHAPES = [rows for orientations in ORIENTATION_ROWS for rows in orientations]
_MASKS = [column_masks(rows) for rows in _SHAPES]

N_SHAPES = len(_SHAPES)
"""Pieces in all their orientations: 19."""
N_ORIENTATIONS = _frozen([len(orientations) for orientations in ORIENTATION_ROWS])
"""Orientations of each piece, shape (7,)."""
FIRST_SHAPE = _frozen([sum(map(len, ORIENTATION_ROWS[:piece])) for piece in range(N_PIECES)])
"""Row of each piece's orientation 0 in the SHAPE_ tables, shape (7,); orientation o is o rows further."""
SHAPE_WIDTHS = _frozen([max(rows).bit_length() for rows in _SHAPES])
"""Columns covered, shape (19,)."""
SHAPE_HEIGHTS = _frozen([len(rows) for rows in _SHAPES])
"""Rows covered, shape (19,)."""
SHAPE_COLUMNS = _frozen(_MASKS)
"""Cells per column as bit masks (bit 0 = lowest row of the shape), shape (19, 4); zero beyond the width."""
SHAPE_BOTTOMS = _frozen([[lowest_bit(mask) for mask in masks] for masks in _MASKS])
"""Bottom profile: row of the lowest cell per column, shape (19, 4); zero beyond the width."""
SHAPE_TOPS = _frozen([[mask.bit_length() for mask in masks] for masks in _MASKS])
"""One more than the row of the highest cell per column, shape (19, 4); zero beyond the width."""


def shape_index(piece: int, orientation: int) -> int:
    """Return the row of a piece's orientation in the SHAPE_ tables.

    Raises:
        ValueError: the piece has no such orientation.
    """
    if not 0 <= piece < N_PIECES or not 0 <= orientation < len(ORIENTATION_ROWS[piece]):
        raise ValueError(
            f"there is no orientation {orientation} of piece {piece}: pieces are 0..{N_PIECES - 1}"
        )
    return int(FIRST_SHAPE[piece]) + orientation


def all_placements(piece: int, columns: int) -> NDArray[np.int64]:
    """Return every (orientation, leftmost column) on an empty board, in the order that breaks ties.

    Args:
        piece: id, 0..6.
        columns: width of the board, >= 4.

    Returns:
        Shape (n, 2): orientation ascending, then column ascending.
    """
    pairs = [
        [orientation, column]
        for orientation in range(len(ORIENTATION_ROWS[piece]))
        for column in range(columns - int(SHAPE_WIDTHS[shape_index(piece, orientation)]) + 1)
    ]
    return np.array(pairs, dtype=np.int64)
