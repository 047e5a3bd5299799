"""The seven tetrominoes as tables, and the streams that say which piece comes k-th.

Nothing here needs compiled code, so the screen may import it. Rows count from the bottom, columns from the
left; bit 0 is the lowest row or the leftmost column. The order of pieces and orientations is that of MDPTetris
(Thiery & Scherrer): successive orientations are quarter turns counter-clockwise, and that order breaks ties.
"""

import numpy as np
from numpy.typing import NDArray

from core.streams import MASK_64

PIECE_NAMES: tuple[str, ...] = ("I", "O", "T", "Z", "S", "J", "L")
"""Names by piece id 0..6."""

N_PIECES = len(PIECE_NAMES)

ORIENTATION_ROWS: tuple[tuple[tuple[int, ...], ...], ...] = (
    ((1, 1, 1, 1), (15,)),
    ((3, 3),),
    ((1, 3, 1), (7, 2), (2, 3, 2), (2, 7)),
    ((1, 3, 2), (6, 3)),
    ((2, 3, 1), (3, 6)),
    ((7, 1), (3, 2, 2), (4, 7), (1, 1, 3)),
    ((1, 7), (3, 1, 1), (7, 4), (2, 2, 3)),
)
"""ORIENTATION_ROWS[piece][orientation]: rows of the shape from the bottom up, bit 0 = its leftmost cell."""

MAX_SHAPE_SIZE = 4
"""No shape is wider or higher than this."""


def _frozen(values: list[int] | list[list[int]]) -> NDArray[np.int64]:
    table = np.array(values, dtype=np.int64)
    table.flags.writeable = False
    return table


def _column_masks(rows: tuple[int, ...]) -> list[int]:
    """Return the shape's columns as bit masks, padded with zeros to MAX_SHAPE_SIZE."""
    return [
        sum(((row >> column) & 1) << level for level, row in enumerate(rows))
        for column in range(MAX_SHAPE_SIZE)
    ]


def _lowest_bit(mask: int) -> int:
    return (mask & -mask).bit_length() - 1 if mask else 0


_SHAPES = [rows for orientations in ORIENTATION_ROWS for rows in orientations]
_MASKS = [_column_masks(rows) for rows in _SHAPES]

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
SHAPE_BOTTOMS = _frozen([[_lowest_bit(mask) for mask in masks] for masks in _MASKS])
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


_GOLDEN = 0x9E3779B97F4A7C15
_MIX_1 = 0xBF58476D1CE4E5B9
_MIX_2 = 0x94D049BB133111EB


def splitmix64(seed: int, k: int) -> int:
    """Return the k-th output (k >= 0) of the generator splitmix64 with this seed, in [0, 2**64).

    Random access: no state between draws. Source of the constants: Steele, Lea & Flood 2014.
    """
    z = (int(seed) + (int(k) + 1) * _GOLDEN) & MASK_64
    z = ((z ^ (z >> 30)) * _MIX_1) & MASK_64
    z = ((z ^ (z >> 27)) * _MIX_2) & MASK_64
    return z ^ (z >> 31)


def _below(seed: int, k: int, bound: int) -> int:
    """Return draw k as a number below `bound`; no value is favoured by more than 2**-32."""
    return ((splitmix64(seed, k) >> 32) * bound) >> 32


def uniform_piece(seed: int, k: int) -> int:
    """Return the k-th piece (k >= 0) of an episode: independent, each of the seven equally likely.

    Args:
        seed: the episode's seed, in [0, 2**63).
        k: number of the piece, from 0.
    """
    return _below(seed, k, N_PIECES)


def seven_bag_piece(seed: int, k: int) -> int:
    """Return the k-th piece (k >= 0) where each seven in a row, from 7 b on, are the seven pieces shuffled."""
    bag, place = divmod(int(k), N_PIECES)
    order = list(range(N_PIECES))
    # Fisher-Yates; bag b owns the six draws from 6 b on.
    for last in range(N_PIECES - 1, 0, -1):
        other = _below(seed, bag * (N_PIECES - 1) + (N_PIECES - 1 - last), last + 1)
        order[last], order[other] = order[other], order[last]
    return order[place]
