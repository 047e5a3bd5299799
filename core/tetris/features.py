"""What a learner sees of a board: four sets of features, computed as integers.

A feature's value is its integer divided by its denominator (1 for nearly all), so that kernels, recordings
and plain Python agree exactly. All sets describe the afterstate: the board after the placement and the
removal of full rows. Rows count from the bottom; on a terminal afterstate rows above the board count too.
"""

from dataclasses import dataclass
from functools import lru_cache

import numpy as np
from numpy.typing import NDArray

from core.numerics.arrays import Ints
from core.numerics.compiled import kernel
from core.tetris.board import (
    AFTER,
    COLUMNS,
    FEATURES,
    FULL,
    ROW,
    ROWS,
    SHAPE,
    cell_count,
    count_holes,
    eroded_cells,
    place_on_copy,
    wall_height,
)
from core.tetris.config import FEATURE_SETS
from core.tetris.pieces import SHAPE_HEIGHTS

BERTSEKAS_21, PAPER_12, DELLACHERIE_THIERY, TAMER_46 = range(4)
"""Codes of the feature sets, in the order of `core.tetris.config.FEATURE_SETS`."""

NO_MOVE = -1
"""In place of a shape, for a board that stands by itself."""

# Squares of the first 11 features (column heights, maximum) are divided by this.
_HEIGHT_SQUARE_SCALE = 100

_DT_NAMES = (
    "landing height",
    "eroded cells",
    "row transitions",
    "column transitions",
    "holes",
    "well sums",
    "hole depth",
    "rows with holes",
    "diversity",
)

DELLACHERIE_WEIGHTS: tuple[float, ...] = (-1.0, 1.0, -1.0, -1.0, -4.0, -1.0, 0.0, 0.0, 0.0)
"""Dellacherie's hand-made controller (Fahey 2003; Thiery & Scherrer 2009), in "dellacherie-thiery" order."""
DT_10_WEIGHTS: tuple[float, ...] = (-2.18, 2.42, -2.17, -3.31, 0.95, -2.22, -0.81, -9.65, 1.27)
"""DT-10: found by CBMPI on 10x10 (Gabillon, Ghavamzadeh & Scherrer 2013)."""
DT_20_WEIGHTS: tuple[float, ...] = (-2.68, 1.38, -2.41, -6.32, 2.03, -2.71, -0.43, -9.48, 0.89)
"""DT-20: found by CBMPI on 10x20 (Gabillon, Ghavamzadeh & Scherrer 2013)."""


@dataclass(frozen=True, slots=True, eq=False)
class FeatureSet:
    """A set of F features for a board of a given width."""

    code: int
    """Which set, for kernels."""
    names: tuple[str, ...]
    """Name of each feature, length F."""
    denominators: NDArray[np.float64]
    """What each integer is divided by, shape (F,), > 0."""


@lru_cache
def feature_set(name: str, columns: int) -> FeatureSet:
    """Return the feature set called `name` for a board of `columns` columns.

    bertsekas-21: heights, absolute differences of neighbours, maximum, holes (Bertsekas & Ioffe 1996 without
    the constant, in the order of Thiery & Scherrer's files). paper-12: maximum, mean height, holes,
    differences (Sridharan & Aerolla 2011, section 4). dellacherie-thiery: the eight of BCTS (Thiery &
    Scherrer 2009) and diversity. tamer-46: Knox's 23 and their squares (Knox & Stone 2009); heights as row
    index from the top.

    Raises:
        ValueError: there is no such set.
    """
    if name not in FEATURE_SETS:
        raise ValueError(f"no feature set {name!r}: known are {', '.join(FEATURE_SETS)}")
    heights = tuple(f"height {column}" for column in range(columns))
    differences = tuple(f"difference {column}-{column + 1}" for column in range(columns - 1))
    knox = (*heights, "maximum", *differences, "holes", "deepest well", "well depths")
    names = {
        "bertsekas-21": (*heights, *differences, "maximum", "holes"),
        "paper-12": ("maximum", "mean height", "holes", *differences),
        "dellacherie-thiery": _DT_NAMES,
        "tamer-46": (*knox, *(f"{feature} squared" for feature in knox)),
    }[name]
    denominators = np.ones(len(names))
    if name == "paper-12":
        denominators[1] = columns
    elif name == "dellacherie-thiery":
        denominators[0] = 2
    elif name == "tamer-46":
        denominators[len(knox) : len(knox) + columns + 1] = _HEIGHT_SQUARE_SCALE
    denominators.flags.writeable = False
    return FeatureSet(FEATURE_SETS.index(name), names, denominators)


@kernel
def fill_features(
    code: int, work: Ints, board: int, out: int, rules: Ints, shape: int, row: int, full: int
) -> None:
    """Write the integers of a board's features.

    Args:
        code: BERTSEKAS_21, PAPER_12, DELLACHERIE_THIERY or TAMER_46.
        work: memory with the board and its heights.
        board: which board, NOW or AFTER.
        out: row of `work` to write, FEATURES or FEATURES_BEFORE.
        rules: see `core.tetris.board.rule_codes`.
        shape: what was placed to get there, or NO_MOVE: the features of the move then are 0.
        row: landing row of the placement.
        full: mask of the rows it filled.
    """
    if code == BERTSEKAS_21:
        fill_bertsekas(work, board, out, rules[COLUMNS])
    elif code == PAPER_12:
        _fill_paper(work, board, out, rules[COLUMNS])
    elif code == DELLACHERIE_THIERY:
        _fill_board_shape(work, board, out, rules)
        work[out, 0] = work[out, 1] = 0
        if shape != NO_MOVE:
            work[out, 0] = 2 * row + SHAPE_HEIGHTS[shape] - 1
            work[out, 1] = eroded_cells(shape, row, full)
    else:
        _fill_tamer(work, board, out, rules)


@kernel
def fill_after(code: int, work: Ints, rules: Ints, action: int) -> int:
    """Write the board AFTER placement `action` and its features; return the lines it clears."""
    lines = place_on_copy(work, rules[COLUMNS], action)
    shape, row, full = work[SHAPE, action], work[ROW, action], work[FULL, action]
    fill_features(code, work, AFTER, FEATURES, rules, shape, row, full)
    return lines


@kernel
def fill_bertsekas(work: Ints, board: int, out: int, n_columns: int) -> None:
    """Write heights, absolute differences, maximum, holes: 2 * n_columns + 1 numbers."""
    heights = board + 1
    for column in range(n_columns):
        work[out, column] = work[heights, column]
    for column in range(n_columns - 1):
        work[out, n_columns + column] = abs(work[heights, column] - work[heights, column + 1])
    work[out, 2 * n_columns - 1] = wall_height(work, board, n_columns)
    work[out, 2 * n_columns] = count_holes(work, board, n_columns)


@kernel
def _fill_paper(work: Ints, board: int, out: int, n_columns: int) -> None:
    heights = board + 1
    total = 0
    for column in range(n_columns):
        total += work[heights, column]
    work[out, 0] = wall_height(work, board, n_columns)
    work[out, 1] = total
    work[out, 2] = count_holes(work, board, n_columns)
    for column in range(n_columns - 1):
        work[out, 3 + column] = abs(work[heights, column] - work[heights, column + 1])


@kernel
def _fill_board_shape(work: Ints, board: int, out: int, rules: Ints) -> None:
    """Write what "dellacherie-thiery" says of the board itself: all but the first two features."""
    n_columns = rules[COLUMNS]
    column_transitions = holes = hole_depth = rows_with_holes = differences = 0
    for column in range(n_columns):
        cells, height = work[board, column], work[board + 1, column]
        holes_here = ((1 << height) - 1) & ~cells
        holes += cell_count(holes_here)
        rows_with_holes |= holes_here
        # The floor is filled, above the topmost cell all is empty.
        column_transitions += cell_count(((cells << 1) | 1) ^ cells)
        # Every filled cell but those that stand on the floor has a hole below its run.
        hole_depth += cell_count(cells & (cells + 1))
        if column + 1 < n_columns:
            difference = height - work[board + 1, column + 1]
            if -2 <= difference <= 2:
                differences |= 1 << (difference + 2)
    highest = wall_height(work, board, n_columns)
    work[out, 2] = _row_transitions(work, board, n_columns, highest) + 2 * (rules[ROWS] - highest)
    work[out, 3] = column_transitions
    work[out, 4] = holes
    work[out, 5] = _well_sums(work, board, n_columns, highest)
    work[out, 6] = hole_depth
    work[out, 7] = cell_count(rows_with_holes)
    work[out, 8] = cell_count(differences)


@kernel
def _row_transitions(work: Ints, board: int, n_columns: int, highest: int) -> int:
    """Return the changes between filled and empty along the wall's rows, side walls filled."""
    wall = (1 << highest) - 1
    transitions = cell_count(wall ^ work[board, 0]) + cell_count(wall ^ work[board, n_columns - 1])
    for column in range(n_columns - 1):
        transitions += cell_count(work[board, column] ^ work[board, column + 1])
    return transitions


@kernel
def _well_sums(work: Ints, board: int, n_columns: int, highest: int) -> int:
    """Return, over empty cells between two filled ones, 1 + the number of empty cells directly below."""
    wall = (1 << highest) - 1
    total = 0
    for column in range(n_columns):
        left = work[board, column - 1] if column > 0 else wall
        right = work[board, column + 1] if column + 1 < n_columns else wall
        cells = work[board, column]
        run = 0
        for row in range(highest):
            run = 0 if (cells >> row) & 1 else run + 1
            if ((left & right & ~cells) >> row) & 1:
                total += run
    return total


@kernel
def _fill_tamer(work: Ints, board: int, out: int, rules: Ints) -> None:
    n_columns, n_rows = rules[COLUMNS], rules[ROWS]
    first_difference, n_plain = n_columns + 1, 2 * n_columns + 3
    deepest = depths = 0
    for column in range(n_columns):
        height = work[board + 1, column]
        work[out, column] = n_rows - height
        if column + 1 < n_columns:
            work[out, first_difference + column] = abs(height - work[board + 1, column + 1])
        depth = _well_depth(work, board, n_columns, column)
        deepest = max(deepest, depth)
        depths += depth
    work[out, n_columns] = n_rows - wall_height(work, board, n_columns)
    work[out, 2 * n_columns] = count_holes(work, board, n_columns)
    work[out, 2 * n_columns + 1] = deepest
    work[out, 2 * n_columns + 2] = depths
    for feature in range(n_plain):
        work[out, n_plain + feature] = work[out, feature] * work[out, feature]


@kernel
def _well_depth(work: Ints, board: int, n_columns: int, column: int) -> int:
    """Return the number of empty cells from the column's highest well cell down to the next filled one.

    A well cell is empty and has both neighbours filled (walls count); one under an overhang is a well cell
    too.
    """
    between = -1
    if column > 0:
        between &= work[board, column - 1]
    if column + 1 < n_columns:
        between &= work[board, column + 1]
    wells = between & ~work[board, column]
    row = -1
    while wells != 0:
        wells >>= 1
        row += 1
    depth = 0
    while row >= 0 and (work[board, column] >> row) & 1 == 0:
        depth += 1
        row -= 1
    return depth
