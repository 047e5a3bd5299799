"""Kernels on a board of column bitboards: where a piece lands, which rows fill, what is left.

A board is a row of int64 numbers, one per column, bit r = row r from the bottom. It has room for four rows
above the top, which only a terminal afterstate uses. Heights are one more than the row of a column's topmost
cell. Columns make a drop a maximum over at most four heights and full rows an AND over columns.

All kernels run as plain Python too: no product here exceeds 63 bits.
"""

import numpy as np

from core.numerics.arrays import Bools, Ints
from core.numerics.compiled import kernel, kernel_with_twin
from core.tetris.config import TetrisConfig
from core.tetris.pieces import (
    FIRST_SHAPE,
    MAX_SHAPE_SIZE,
    N_ORIENTATIONS,
    N_PIECES,
    SHAPE_BOTTOMS,
    SHAPE_COLUMNS,
    SHAPE_HEIGHTS,
    SHAPE_TOPS,
    SHAPE_WIDTHS,
    splitmix64,
)

MAX_PLACEMENTS = 64
"""No piece has more placements on 16 columns (J, L, T: 58)."""

# The working memory of a game is one array, shape (N_WORK_ROWS, WORK_WIDTH): one array and not many because
# compiled code counts references to every array it is handed inside a tuple. Its rows:
NOW, AFTER = 0, 2
"""A board takes two rows: its columns, and in the row below their heights, then zeros."""
SHAPE, LEFT, ROW, FULL = range(4, 8)
"""Of each placement: row in the SHAPE_ tables, leftmost column, landing row, mask of the rows it fills."""
COMMON_LEFT, COMMON_RIGHT = 8, 9
"""Rows filled in all columns left of c, and in all from c on."""
VALUE_LEFT, VALUE_RIGHT, NEIGHBOUR = 10, 11, 12
"""Value of the columns left of c and from c on; height of column c - 1 (0 beyond the walls)."""
FEATURES, FEATURES_BEFORE = 13, 14
"""Features of the board AFTER and of the board NOW."""
N_WORK_ROWS, WORK_WIDTH = 15, 80

# Places in the array of rules that kernels take.
ROWS, COLUMNS, OVERFLOW, CLEAR_ON_OVERFLOW, TERMINAL_BY_FEATURES, SEVEN_BAG, LINES_IN_VALUE = range(7)

# Bottom profiles with columns beyond the width so high that they never decide where a shape lands.
NEVER = 1_000
_DROP_BOTTOMS = np.where(SHAPE_COLUMNS > 0, SHAPE_BOTTOMS, NEVER)


def rule_codes(config: TetrisConfig) -> Ints:
    """Return the rules as the array that kernels take, in the order of the constants above."""
    return np.array(
        [
            config.rows,
            config.columns,
            config.game_over == "overflow",
            config.clear_on_overflow,
            config.terminal_value == "features",
            config.pieces == "seven-bag",
            config.lines_in_value,
        ],
        dtype=np.int64,
    )


def new_work(columns: tuple[int, ...] | Ints = ()) -> Ints:
    """Return working memory whose board NOW has the given columns (heights to be filled), or is empty."""
    work = np.zeros((N_WORK_ROWS, WORK_WIDTH), dtype=np.int64)
    work[NOW, : len(columns)] = columns
    return work


def _splitmix64_high(seed: int, k: int) -> int:
    """Return the upper 32 bits of draw k of splitmix64 (see `core.tetris.pieces.splitmix64`)."""
    z = np.uint64(seed) + (np.uint64(k) + np.uint64(1)) * np.uint64(0x9E3779B97F4A7C15)
    z = (z ^ (z >> np.uint64(30))) * np.uint64(0xBF58476D1CE4E5B9)
    z = (z ^ (z >> np.uint64(27))) * np.uint64(0x94D049BB133111EB)
    z = z ^ (z >> np.uint64(31))
    return np.int64(z >> np.uint64(32))  # type: ignore[return-value]


def _splitmix64_high_in_python(seed: int, k: int) -> int:
    return splitmix64(seed, k) >> 32


# uint64 arithmetic wraps when compiled, but warns as numpy scalars: plain Python takes the plain function.
draw_32 = kernel_with_twin(_splitmix64_high, _splitmix64_high_in_python)


@kernel
def piece_at(seed: int, k: int, seven_bag: int) -> int:
    """Return the k-th piece of an episode; the twin of `uniform_piece` and `seven_bag_piece`."""
    if seven_bag == 0:
        return (draw_32(seed, k) * N_PIECES) >> 32
    bag = k // N_PIECES
    order = 0o6543210  # one octal digit per place of the bag
    for last in range(N_PIECES - 1, 0, -1):
        draw = draw_32(seed, bag * (N_PIECES - 1) + (N_PIECES - 1 - last))
        other = (draw * (last + 1)) >> 32
        swapped = ((order >> (3 * last)) ^ (order >> (3 * other))) & 7
        order ^= (swapped << (3 * last)) | (swapped << (3 * other))
    return (order >> (3 * (k % N_PIECES))) & 7


@kernel
def cell_count(mask: int) -> int:
    """Return the number of bits set."""
    count = 0
    while mask != 0:
        mask &= mask - 1
        count += 1
    return count


@kernel
def height_of(column: int) -> int:
    """Return one more than the row of the topmost cell; 0 for an empty column."""
    # Every bit below the highest one is set; no loop whose length the processor would have to guess.
    column |= column >> 1
    column |= column >> 2
    column |= column >> 4
    column |= column >> 8
    column |= column >> 16
    column |= column >> 32
    return cell_count(column)


@kernel
def fill_heights(work: Ints, board: int, n_columns: int) -> None:
    """Write the height of each column of a board (NOW or AFTER)."""
    for column in range(n_columns):
        work[board + 1, column] = height_of(work[board, column])


@kernel
def wall_height(work: Ints, board: int, n_columns: int) -> int:
    """Return the height of the highest column."""
    highest = 0
    for column in range(n_columns):
        highest = max(highest, work[board + 1, column])
    return highest


@kernel
def count_holes(work: Ints, board: int, n_columns: int) -> int:
    """Return the number of empty cells with a filled cell somewhere above in their column."""
    holes = 0
    for column in range(n_columns):
        holes += work[board + 1, column] - cell_count(work[board, column])
    return holes


@kernel
def without_rows(column: int, full: int) -> int:
    """Return the column after the rows set in `full` are removed and those above have come down."""
    rest = full
    removed = 0
    while rest != 0:
        lowest = rest & -rest
        below = (lowest >> removed) - 1
        column = (column & below) | ((column >> 1) & ~below)
        rest ^= lowest
        removed += 1
    return column


@kernel
def scan_placements(work: Ints, rules: Ints, piece: int) -> int:
    """List where the piece can be dropped on the board NOW: by orientation, then by column.

    Placements that stick out above the board are listed too; whether they are allowed is another question.

    Args:
        work: rows SHAPE, LEFT, ROW and FULL are written. FULL holds the rows that will be removed.
        rules: see `rule_codes`.
        piece: id, 0..6.

    Returns:
        How many there are.
    """
    n_columns = rules[COLUMNS]
    # A piece above the top clears nothing unless the rules say so.
    last_clearing_row = rules[ROWS] if rules[CLEAR_ON_OVERFLOW] == 0 else NEVER
    _fill_common(work, n_columns)
    n = 0
    for shape in range(FIRST_SHAPE[piece], FIRST_SHAPE[piece] + N_ORIENTATIONS[piece]):
        width, height = SHAPE_WIDTHS[shape], SHAPE_HEIGHTS[shape]
        bottom_0, bottom_1 = _DROP_BOTTOMS[shape, 0], _DROP_BOTTOMS[shape, 1]
        bottom_2, bottom_3 = _DROP_BOTTOMS[shape, 2], _DROP_BOTTOMS[shape, 3]
        for left in range(n_columns - width + 1):
            row = max(
                max(work[NOW + 1, left] - bottom_0, work[NOW + 1, left + 1] - bottom_1),
                max(work[NOW + 1, left + 2] - bottom_2, work[NOW + 1, left + 3] - bottom_3),
            )
            row = max(row, 0)
            # Unsigned, or the compiler would look at each for a count from the end.
            at, right = np.uint64(n + left), np.uint64(left + width)
            full = work[COMMON_LEFT, left] & work[COMMON_RIGHT, right] & (15 << row)
            if full != 0:
                if row + height > last_clearing_row:
                    full = 0
                for offset in range(width):
                    full &= work[NOW, left + offset] | (SHAPE_COLUMNS[shape, offset] << row)
            work[SHAPE, at] = shape
            work[LEFT, at] = left
            work[ROW, at] = row
            work[FULL, at] = full
        n += n_columns - width + 1
    return n


@kernel
def _fill_common(work: Ints, n_columns: int) -> None:
    common = -1
    for column in range(n_columns):
        work[COMMON_LEFT, column] = common
        common &= work[NOW, column]
    common = -1
    for column in range(n_columns, 0, -1):
        work[COMMON_RIGHT, column] = common
        common &= work[NOW, column - 1]


@kernel
def put_down(work: Ints, board: int, action: int) -> int:
    """Put the piece down on a board (NOW or AFTER) as placement `action` says; return the rows to be
    removed.
    """
    shape, left, row = work[SHAPE, action], work[LEFT, action], work[ROW, action]
    for offset in range(SHAPE_WIDTHS[shape]):
        column = np.uint64(left + offset)
        work[board, column] |= SHAPE_COLUMNS[shape, offset] << row
        work[board + 1, column] = row + SHAPE_TOPS[shape, offset]
    return int(work[FULL, action])


@kernel
def remove_rows(work: Ints, board: int, n_columns: int, full: int) -> int:
    """Remove the rows set in `full` from a board; return how many there were."""
    for column in range(n_columns):
        left_over = without_rows(work[board, column], full)
        work[board, column] = left_over
        work[board + 1, column] = height_of(left_over)
    return cell_count(full)


@kernel
def place(work: Ints, board: int, n_columns: int, action: int) -> int:
    """Put the piece down, remove full rows; return the lines cleared."""
    return remove_rows(work, board, n_columns, put_down(work, board, action))


@kernel
def place_on_copy(work: Ints, n_columns: int, action: int) -> int:
    """Write the board AFTER placement `action`; return the lines it clears."""
    for column in range(n_columns):
        work[AFTER, column] = work[NOW, column]
        work[AFTER + 1, column] = work[NOW + 1, column]
    return place(work, AFTER, n_columns, action)


@kernel
def eroded_cells(shape: int, row: int, full: int) -> int:
    """Return lines cleared times cells of the piece in the cleared rows (Dellacherie's eroded piece
    cells).
    """
    cells = 0
    for offset in range(MAX_SHAPE_SIZE):
        cells += cell_count((SHAPE_COLUMNS[shape, offset] << row) & full)
    return cell_count(full) * cells


@kernel
def mark_above(work: Ints, rules: Ints, n: int, above: Bools) -> int:
    """Mark the placements that end above the top; return how many there are.

    Where a piece must fit that is before full rows are removed (the placement is not allowed), else after
    (the game is over).
    """
    n_above = 0
    for action in range(n):
        ends = work[ROW, action] + SHAPE_HEIGHTS[work[SHAPE, action]] > rules[ROWS]
        if ends and work[FULL, action] != 0 and rules[OVERFLOW] != 0:
            place_on_copy(work, rules[COLUMNS], action)
            ends = wall_height(work, AFTER, rules[COLUMNS]) > rules[ROWS]
        above[action] = ends
        n_above += ends
    return n_above


@kernel
def allow_all(ruled_out: Bools, n: int) -> int:
    """Rule out none of the first n placements; return n."""
    for action in range(n):
        ruled_out[action] = False
    return n


@kernel
def mark_ruled_out(work: Ints, rules: Ints, n: int, ruled_out: Bools) -> int:
    """Mark the placements that are not allowed or have a value of minus infinity; return how many remain."""
    if rules[TERMINAL_BY_FEATURES] != 0:
        return allow_all(ruled_out, n)
    return n - mark_above(work, rules, n, ruled_out)
