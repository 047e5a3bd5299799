"""Tetris as we mean it: boards as arrays of booleans, row 0 at the bottom, one obvious step after the
other."""

import itertools
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from core.tetris.config import TetrisConfig
from core.tetris.pieces import ORIENTATION_ROWS

Board = NDArray[np.bool_]
ROOM_ABOVE = 4


def empty_board(config: TetrisConfig) -> Board:
    return np.zeros((config.rows + ROOM_ABOVE, config.columns), dtype=bool)


def board_from_columns(columns, config: TetrisConfig) -> Board:
    board = empty_board(config)
    for column, mask in enumerate(columns):
        for row in range(len(board)):
            board[row, column] = bool(int(mask) >> row & 1)
    return board


def shape_cells(piece: int, orientation: int) -> Board:
    rows = ORIENTATION_ROWS[piece][orientation]
    width = max(row.bit_length() for row in rows)
    return np.array([[bool(row >> column & 1) for column in range(width)] for row in rows])


def heights(board: Board) -> list[int]:
    return [
        max((row + 1 for row in range(len(board)) if board[row, c]), default=0) for c in range(board.shape[1])
    ]


def clear_full_rows(board: Board) -> tuple[Board, int]:
    kept = [row for row in board if not row.all()]
    lines = len(board) - len(kept)
    empty = [np.zeros(board.shape[1], dtype=bool)] * lines
    return np.array(kept + empty).reshape(board.shape), lines


@dataclass
class Outcome:
    """What one placement leads to."""

    orientation: int
    column: int
    landing_row: int
    board: Board
    """After full rows are removed."""
    lines: int
    eroded: int
    fits: bool
    """Whether the piece lies fully inside, before full rows are removed."""
    above: bool
    """Whether the wall is higher than the board afterwards."""
    piece_height: int


def overlaps(board: Board, shape: Board, row: int, column: int) -> bool:
    height, width = shape.shape
    return bool((board[row : row + height, column : column + width] & shape).any())


def drop(board: Board, piece: int, orientation: int, column: int, config: TetrisConfig) -> Outcome:
    shape = shape_cells(piece, orientation)
    height, width = shape.shape
    row = config.rows  # from above the top
    while row > 0 and not overlaps(board, shape, row - 1, column):
        row -= 1
    after = board.copy()
    after[row : row + height, column : column + width] |= shape
    fits = row + height <= config.rows
    lines = eroded = 0
    if fits or config.clear_on_overflow:
        full = after.all(axis=1)
        eroded = int(full.sum()) * sum(int(shape[i].sum()) for i in range(height) if full[row + i])
        after, lines = clear_full_rows(after)
    above = max(heights(after)) > config.rows
    return Outcome(orientation, column, row, after, lines, eroded, fits, above, height)


def all_outcomes(board: Board, piece: int, config: TetrisConfig) -> list[Outcome]:
    """Every placement, allowed or not, orientation by orientation."""
    return [
        drop(board, piece, orientation, column, config)
        for orientation in range(len(ORIENTATION_ROWS[piece]))
        for column in range(config.columns - shape_cells(piece, orientation).shape[1] + 1)
    ]


def allowed_outcomes(board: Board, piece: int, config: TetrisConfig) -> list[Outcome]:
    outcomes = all_outcomes(board, piece, config)
    return [o for o in outcomes if o.fits] if config.game_over == "fit-before-clear" else outcomes


def holes(board: Board) -> list[tuple[int, int]]:
    tops = heights(board)
    return [(row, c) for c in range(board.shape[1]) for row in range(tops[c]) if not board[row, c]]


def bertsekas(board: Board) -> list[float]:
    tops = heights(board)
    return [*tops, *differences(board), max(tops), len(holes(board))]


def differences(board: Board) -> list[int]:
    tops = heights(board)
    return [abs(a - b) for a, b in itertools.pairwise(tops)]


def paper(board: Board) -> list[float]:
    tops = heights(board)
    return [max(tops), sum(tops) / len(tops), len(holes(board)), *differences(board)]


def row_transitions(board: Board, rows: int) -> int:
    top = max(heights(board))
    changes = 0
    for row in range(top):
        walled = [True, *board[row], True]
        changes += sum(a != b for a, b in itertools.pairwise(walled))
    return changes + 2 * (rows - top)


def column_transitions(board: Board) -> int:
    changes = 0
    for column in range(board.shape[1]):
        stack = [True, *board[:, column], False]
        changes += sum(a != b for a, b in itertools.pairwise(stack))
    return changes


def is_well_cell(board: Board, row: int, column: int) -> bool:
    left = column == 0 or board[row, column - 1]
    right = column == board.shape[1] - 1 or board[row, column + 1]
    return bool(not board[row, column] and left and right)


def empty_run_down(board: Board, row: int, column: int) -> int:
    """The cell itself, if empty, and the empty cells directly below it."""
    run = 0
    while row - run >= 0 and not board[row - run, column]:
        run += 1
    return run


def well_sums(board: Board) -> int:
    return sum(
        empty_run_down(board, row, column)
        for row in range(max(heights(board)))
        for column in range(board.shape[1])
        if is_well_cell(board, row, column)
    )


def well_sums_fast(board: Board) -> int:
    """MDPTetris' variant: all empty cells under a well cell count as well cells."""
    total = 0
    for column in range(board.shape[1]):
        row = max(heights(board)) - 1
        while row >= 0:
            if is_well_cell(board, row, column):
                run = empty_run_down(board, row, column)
                total += run * (run + 1) // 2
                row -= run
            else:
                row -= 1
    return total


def hole_depth(board: Board) -> int:
    total = 0
    for row, column in holes(board):
        above = row + 1
        while above < len(board) and board[above, column]:
            total += 1
            above += 1
    return total


def rows_with_holes(board: Board) -> int:
    return len({row for row, _ in holes(board)})


def diversity(board: Board) -> int:
    tops = heights(board)
    return len({a - b for a, b in itertools.pairwise(tops)} & {-2, -1, 0, 1, 2})


def dellacherie_thiery(board: Board, config: TetrisConfig, outcome: Outcome | None) -> list[float]:
    landing = 0.0 if outcome is None else outcome.landing_row + (outcome.piece_height - 1) / 2
    eroded = 0 if outcome is None else outcome.eroded
    return [
        landing,
        eroded,
        row_transitions(board, config.rows),
        column_transitions(board),
        len(holes(board)),
        well_sums(board),
        hole_depth(board),
        rows_with_holes(board),
        diversity(board),
    ]


def well_depth(board: Board, column: int) -> int:
    """Scan from the top: starts at the first cell between two filled ones, ends at the next filled one."""
    depth = 0
    for row in reversed(range(len(board))):
        if depth > 0 and board[row, column]:
            break
        if depth > 0 or is_well_cell(board, row, column):
            depth += 1
    return depth


def tamer(board: Board, config: TetrisConfig) -> list[float]:
    from_top = [config.rows - top for top in heights(board)]
    wells = [well_depth(board, column) for column in range(config.columns)]
    first = [*from_top, min(from_top)]
    rest = [*differences(board), len(holes(board)), max(wells), sum(wells)]
    return [*first, *rest, *[x * x / 100 for x in first], *[x * x for x in rest]]


def features(name: str, board: Board, config: TetrisConfig, outcome: Outcome | None) -> list[float]:
    if name == "bertsekas-21":
        return bertsekas(board)
    if name == "paper-12":
        return paper(board)
    if name == "dellacherie-thiery":
        return dellacherie_thiery(board, config, outcome)
    return tamer(board, config)
