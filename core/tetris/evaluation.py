"""Kernels that value every placement of a piece under linear weights.

Values are defined as the sum over features, in their order, of weight times feature, with weights on the
binary grid of `core.numerics.fixed_point`. For the 21 features that sum is an exact integer times a power of
two, however it is added up; so a board's unchanged columns are summed once per piece instead of once per
placement.
"""

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from core.numerics.arrays import Floats, Ints
from core.numerics.compiled import inner_kernel, kernel
from core.numerics.fixed_point import fixed_point_shifts
from core.tetris.board import (
    COLUMNS,
    FEATURES,
    FEATURES_BEFORE,
    FULL,
    LEFT,
    LINES_IN_VALUE,
    NEIGHBOUR,
    NOW,
    ROW,
    SHAPE,
    VALUE_LEFT,
    VALUE_RIGHT,
    WORK_WIDTH,
    cell_count,
    count_holes,
    height_of,
    rule_codes,
    without_rows,
)
from core.tetris.config import TetrisConfig
from core.tetris.features import (
    BERTSEKAS_21,
    DELLACHERIE_THIERY,
    NO_MOVE,
    PAPER_12,
    FeatureSet,
    feature_set,
    fill_after,
    fill_features,
)
from core.tetris.pieces import (
    MAX_SHAPE_SIZE,
    N_SHAPES,
    SHAPE_BOTTOMS,
    SHAPE_COLUMNS,
    SHAPE_HEIGHTS,
    SHAPE_TOPS,
    SHAPE_WIDTHS,
)

# Rows of a policy's table of integers. For the 21 features, where [shape, c] is a shape with leftmost column
# c:
WEIGHTS, EDGES = 0, 1
"""Weights, the cleared line's last; weight of the difference between columns c - 1 and c, 0 at the walls."""
PER_ROW = 2
"""[shape, c]: what each row higher is worth: to the columns covered, and in holes."""
OUTLINE = PER_ROW + N_SHAPES
"""[shape, c]: value of the shape's own outline, lying in row 0, and of the cells below it."""
_N_TABLE_ROWS = OUTLINE + N_SHAPES

# Rows of a policy's table of numbers; UNIT has one entry, the power of two in which the integers count.
NUMBERS, DENOMINATORS, UNIT = range(3)

_LAST_TOPS = SHAPE_TOPS[np.arange(N_SHAPES), SHAPE_WIDTHS - 1]
_BOTTOM_SUMS = SHAPE_BOTTOMS.sum(axis=1)


class LinearPolicy(NamedTuple):
    """Weights of F features and of a cleared line, as the kernels take them."""

    code: int
    """Feature set."""
    table: Ints
    """Integers, in the rows WEIGHTS, EDGES, PER_ROW.., OUTLINE.."""
    numbers: Floats
    """Weights and denominators as numbers, and the unit, in the rows NUMBERS, DENOMINATORS, UNIT."""


def empty_policy(features: FeatureSet) -> LinearPolicy:
    """Return a policy whose weights are yet to be set by `set_weights`."""
    numbers = np.ones((3, WORK_WIDTH))
    numbers[DENOMINATORS, : len(features.names)] = features.denominators
    return LinearPolicy(features.code, np.zeros((_N_TABLE_ROWS, WORK_WIDTH), dtype=np.int64), numbers)


def grid_weights(weights: Floats, per_line: float) -> tuple[Ints, Floats]:
    """Return policies as kernels take them.

    Args:
        weights: one policy per row, shape (n, F).
        per_line: what a cleared line adds to a value (`TetrisConfig.lines_in_value`).

    Returns:
        Integers, shape (n, F + 1), and the unit of each row, shape (n,).
    """
    with_lines = np.column_stack([weights, np.full(len(weights), per_line)])
    shifts = fixed_point_shifts(with_lines)
    # In C's order also where one policy is repeated: another order would be another type, compiled once more.
    integers = np.rint(np.ldexp(with_lines, shifts[:, None])).astype(np.int64, order="C")
    units = np.ldexp(1.0, -shifts)
    return integers, units


def linear_policy(
    weights: NDArray[np.float64], config: TetrisConfig, features: str, per_line: float = 0.0
) -> LinearPolicy:
    """Return one policy ready for the kernels.

    Args:
        weights: shape (F,), finite.
        config: board and rules.
        features: name of the feature set with F features.
        per_line: what a cleared line adds to a value.

    Raises:
        ValueError: the number of weights is not that of the features.
    """
    features_seen = feature_set(features, config.columns)
    if np.shape(weights) != (len(features_seen.names),):
        raise ValueError(
            f"{features} on {config.columns} columns needs {len(features_seen.names)} weights, "
            f"got shape {np.shape(weights)}"
        )
    policy = empty_policy(features_seen)
    integers, units = grid_weights(np.asarray(weights, dtype=np.float64)[None, :], per_line)
    set_weights(policy.code, policy.table, policy.numbers, rule_codes(config), integers[0], units[0])
    return policy


@kernel
def set_weights(code: int, table: Ints, numbers: Floats, rules: Ints, integers: Ints, unit: float) -> None:
    """Take over weights (in units of the grid, the line's last) and work out the tables for the 21
    features.
    """
    n_columns = rules[COLUMNS]
    numbers[UNIT, 0] = unit
    for feature in range(len(integers)):
        table[WEIGHTS, feature] = integers[feature]
        numbers[NUMBERS, feature] = integers[feature] * unit
    if code != BERTSEKAS_21:
        return
    table[EDGES, 0] = table[EDGES, n_columns] = 0
    for column in range(1, n_columns):
        table[EDGES, column] = integers[n_columns + column - 1]
    per_hole = integers[2 * n_columns]
    for shape in range(N_SHAPES):
        width = SHAPE_WIDTHS[shape]
        for left in range(n_columns - width + 1):
            per_row = per_hole * width
            outline = per_hole * _BOTTOM_SUMS[shape]
            for offset in range(width):
                per_row += integers[left + offset]
                outline += integers[left + offset] * SHAPE_TOPS[shape, offset]
                if offset > 0:
                    step = abs(SHAPE_TOPS[shape, offset] - SHAPE_TOPS[shape, offset - 1])
                    outline += table[EDGES, left + offset] * step
            table[PER_ROW + shape, left] = per_row
            table[OUTLINE + shape, left] = outline


@inner_kernel
def fill_values(
    code: int, table: Ints, numbers: Floats, work: Ints, rules: Ints, n: int, relative: bool, values: Floats
) -> None:
    """Write the value of each of the first n placements.

    Args:
        code: of the policy, as the next two.
        table: see `LinearPolicy`.
        numbers: see `LinearPolicy`.
        work: with the board NOW, its heights and the placements of the decision.
        rules: see `core.tetris.board.rule_codes`.
        n: number of placements.
        relative: value the change from the board before to the afterstate instead of the afterstate.
        values: written, shape (>= n,).
    """
    if code != BERTSEKAS_21:
        fill_values_any(code, numbers, work, rules, n, relative, values)
        return
    before = fill_sums(table, work, rules[COLUMNS])
    if fill_values_21(table, numbers, work, rules[COLUMNS], n, before * relative, values):
        fill_values_of_clearing(table, numbers, work, rules[COLUMNS], n, before * relative, values)


@kernel
def n_features_of(code: int, n_columns: int) -> int:
    """Return how many features a set has."""
    if code == BERTSEKAS_21:
        return 2 * n_columns + 1
    if code == PAPER_12:
        return n_columns + 2
    if code == DELLACHERIE_THIERY:
        return 9
    return 4 * n_columns + 6


@kernel
def fill_values_any(
    code: int, numbers: Floats, work: Ints, rules: Ints, n: int, relative: bool, values: Floats
) -> None:
    """Do what `fill_values` says for any feature set, one afterstate after the other."""
    n_features = n_features_of(code, rules[COLUMNS])
    if relative:
        fill_features(code, work, NOW, FEATURES_BEFORE, rules, NO_MOVE, 0, 0)
    for action in range(n):
        lines = fill_after(code, work, rules, action)
        total = 0.0
        for feature in range(n_features):
            number = work[FEATURES, feature]
            if relative:
                number -= work[FEATURES_BEFORE, feature]
            total += numbers[NUMBERS, feature] * (number / numbers[DENOMINATORS, feature])
        if rules[LINES_IN_VALUE] != 0:
            total += numbers[NUMBERS, n_features] * lines
        values[action] = total


@kernel
def fill_sums(table: Ints, work: Ints, n_columns: int) -> int:
    """Write the rows VALUE_LEFT, VALUE_RIGHT and NEIGHBOUR; return the value of the board NOW.

    A hole more costs the same everywhere, so the cells a placement would bury are counted in here: those up
    to its landing row less those up to the heights of the columns it covers.
    """
    heights, per_hole = NOW + 1, table[WEIGHTS, 2 * n_columns]
    left = buried = highest = previous = 0
    work[VALUE_LEFT, 0] = work[NEIGHBOUR, 0] = 0
    for column in range(n_columns):
        height = work[heights, column]
        # The difference to a column belongs to neither side of a placement between the two.
        left += table[EDGES, column] * abs(height - previous) + table[WEIGHTS, column] * height
        buried += per_hole * height
        highest = max(highest, height)
        work[VALUE_LEFT, column + 1] = left + buried
        work[NEIGHBOUR, column + 1] = height
        previous = height
    work[NEIGHBOUR, n_columns + 1] = 0
    # What all placements share: the present holes, and the wall's height unless they raise it.
    shared = table[WEIGHTS, 2 * n_columns - 1] * highest + per_hole * count_holes(work, NOW, n_columns)
    right = shared
    for column in range(n_columns, 0, -1):
        work[VALUE_RIGHT, column] = right - buried
        height = work[heights, column - 1]
        buried -= per_hole * height
        right += (
            table[EDGES, column] * abs(work[heights, column] - height) + table[WEIGHTS, column - 1] * height
        )
    return int(right)


@kernel
def fill_values_21(
    table: Ints, numbers: Floats, work: Ints, n_columns: int, n: int, base: int, values: Floats
) -> bool:
    """Do what `fill_values` says for the 21 features, as if no rows were removed.

    Args:
        table: of the policy, as `numbers`.
        numbers: of the policy.
        work: memory, after `fill_sums`.
        n_columns: width of the board.
        n: number of placements.
        base: value in units of the grid that counts as 0.
        values: written, shape (>= n,).

    Returns:
        Whether placements do remove rows: their values are left to `fill_values_of_clearing`. (Apart, because
        only a kernel that calls no other can do without counting references to its arrays.)
    """
    per_height, unit = table[WEIGHTS, 2 * n_columns - 1], numbers[UNIT, 0]
    highest = 0
    for column in range(n_columns):
        highest = max(highest, work[NOW + 1, column])
    clearing = 0
    action = 0
    while action < n:
        shape = work[SHAPE, action]
        width, raised = SHAPE_WIDTHS[shape], SHAPE_HEIGHTS[shape] - highest
        first_top, last_top = SHAPE_TOPS[shape, 0], _LAST_TOPS[shape]
        for left in range(n_columns - width + 1):
            # Unsigned, or the compiler would look at each for a count from the end.
            at, right, beyond = np.uint64(action + left), np.uint64(left + width), np.uint64(left + width + 1)
            row = work[ROW, at]
            clearing |= work[FULL, at]
            value = work[VALUE_LEFT, left] + work[VALUE_RIGHT, right] - base
            value += row * table[PER_ROW + shape, left] + table[OUTLINE + shape, left]
            value += table[EDGES, left] * abs(work[NEIGHBOUR, left] - row - first_top)
            value += table[EDGES, right] * abs(work[NEIGHBOUR, beyond] - row - last_top)
            value += per_height * max(0, row + raised)
            values[at] = value * unit
        action += n_columns - width + 1
    return clearing != 0


@kernel
def fill_values_of_clearing(
    table: Ints, numbers: Floats, work: Ints, n_columns: int, n: int, base: int, values: Floats
) -> None:
    """Write the values of the placements that remove rows, after `fill_values_21`; the same arguments."""
    per_line = table[WEIGHTS, 2 * n_columns + 1]
    per_height, per_hole = table[WEIGHTS, 2 * n_columns - 1], table[WEIGHTS, 2 * n_columns]
    for action in range(n):
        full = work[FULL, action]
        if full == 0:
            continue
        shape, left, row = work[SHAPE, action], work[LEFT, action], work[ROW, action]
        value = per_line * cell_count(full) - base
        highest = previous = 0
        for column in range(n_columns):
            cells = work[NOW, column]
            if left <= column < left + MAX_SHAPE_SIZE:
                cells |= SHAPE_COLUMNS[shape, column - left] << row
            cells = without_rows(cells, full)
            height = height_of(cells)
            value += table[WEIGHTS, column] * height + table[EDGES, column] * abs(height - previous)
            value += per_hole * (height - cell_count(cells))
            highest = max(highest, height)
            previous = height
        values[action] = (value + per_height * highest) * numbers[UNIT, 0]
