"""The seven tetrominoes as plain numbers, and the streams that say which piece comes k-th.

No numerical library is imported, so the screen may import this. Rows count from the bottom, columns from the
left; bit 0 is the lowest row or the leftmost column. The order of pieces and orientations is that of
MDPTetris (Thiery & Scherrer): successive orientations are quarter turns counter-clockwise, and that order
breaks ties.
"""

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


def column_masks(rows: tuple[int, ...]) -> list[int]:
    """Return the shape's columns as bit masks, padded with zeros to MAX_SHAPE_SIZE."""
    return [
        sum(((row >> column) & 1) << level for level, row in enumerate(rows))
        for column in range(MAX_SHAPE_SIZE)
    ]


def lowest_bit(mask: int) -> int:
    """Return the place of the lowest bit set; 0 if there is none."""
    return (mask & -mask).bit_length() - 1 if mask else 0


_MASK_64 = (1 << 64) - 1
_GOLDEN = 0x9E3779B97F4A7C15
_MIX_1 = 0xBF58476D1CE4E5B9
_MIX_2 = 0x94D049BB133111EB


def splitmix64(seed: int, k: int) -> int:
    """Return the k-th output (k >= 0) of the generator splitmix64 with this seed, in [0, 2**64).

    Random access: no state between draws. Source of the constants: Steele, Lea & Flood 2014.
    """
    z = (int(seed) + (int(k) + 1) * _GOLDEN) & _MASK_64
    z = ((z ^ (z >> 30)) * _MIX_1) & _MASK_64
    z = ((z ^ (z >> 27)) * _MIX_2) & _MASK_64
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
    """Return the k-th piece (k >= 0) where each seven in a row, from 7 b on, are the seven pieces
    shuffled.
    """
    bag, place = divmod(int(k), N_PIECES)
    order = list(range(N_PIECES))
    # Fisher-Yates; bag b owns the six draws from 6 b on.
    for last in range(N_PIECES - 1, 0, -1):
        other = _below(seed, bag * (N_PIECES - 1) + (N_PIECES - 1 - last), last + 1)
        order[last], order[other] = order[other], order[last]
    return order[place]
