"""Pieces: their shapes, and the streams that deal them."""

import subprocess
import sys

import numpy as np
import pytest

from core.tetris.pieces import (
    FIRST_SHAPE,
    N_ORIENTATIONS,
    N_PIECES,
    N_SHAPES,
    ORIENTATION_ROWS,
    PIECE_NAMES,
    SHAPE_BOTTOMS,
    SHAPE_COLUMNS,
    SHAPE_HEIGHTS,
    SHAPE_TOPS,
    SHAPE_WIDTHS,
    all_placements,
    seven_bag_piece,
    shape_index,
    splitmix64,
    uniform_piece,
)


def cells_of(rows: tuple[int, ...]) -> set[tuple[int, int]]:
    return {(level, column) for level, row in enumerate(rows) for column in range(4) if row >> column & 1}


def turned_counter_clockwise(cells: set[tuple[int, int]]) -> set[tuple[int, int]]:
    # (row up, column right) -> a quarter turn left: right becomes up, up becomes left
    turned = {(column, -row) for row, column in cells}
    lowest, leftmost = min(row for row, _ in turned), min(column for _, column in turned)
    return {(row - lowest, column - leftmost) for row, column in turned}


def test_every_shape_has_four_cells():
    assert N_SHAPES == 19
    assert all(len(cells_of(rows)) == 4 for rows_of_piece in ORIENTATION_ROWS for rows in rows_of_piece)


@pytest.mark.parametrize("piece", range(N_PIECES))
def test_the_next_orientation_is_a_quarter_turn_counter_clockwise(piece):
    shapes = [cells_of(rows) for rows in ORIENTATION_ROWS[piece]]
    for here, following in zip(shapes, shapes[1:] + shapes[:1], strict=True):
        assert turned_counter_clockwise(here) == following


def test_j_lies_on_three_with_its_hook_on_the_left():
    # bottom XXX, top X..
    assert PIECE_NAMES[5] == "J"
    assert ORIENTATION_ROWS[5][0] == (0b111, 0b001)


def test_the_tables_describe_the_same_cells_as_the_rows():
    for piece, orientations in enumerate(ORIENTATION_ROWS):
        assert N_ORIENTATIONS[piece] == len(orientations)
        for orientation, rows in enumerate(orientations):
            shape = shape_index(piece, orientation)
            assert shape == FIRST_SHAPE[piece] + orientation
            cells = cells_of(rows)
            assert SHAPE_HEIGHTS[shape] == 1 + max(row for row, _ in cells)
            assert SHAPE_WIDTHS[shape] == 1 + max(column for _, column in cells)
            for column in range(4):
                levels = sorted(row for row, c in cells if c == column)
                assert SHAPE_COLUMNS[shape, column] == sum(1 << row for row in levels)
                assert SHAPE_BOTTOMS[shape, column] == (levels[0] if levels else 0)
                assert SHAPE_TOPS[shape, column] == (levels[-1] + 1 if levels else 0)


def test_the_numbers_of_placements_on_ten_columns_are_those_of_the_reference():
    counts = dict(zip(PIECE_NAMES, [len(all_placements(p, 10)) for p in range(N_PIECES)], strict=True))
    assert counts == {"I": 17, "O": 9, "T": 34, "Z": 17, "S": 17, "J": 34, "L": 34}


def test_placements_come_orientation_by_orientation_then_column_by_column():
    assert all_placements(0, 4).tolist() == [[0, 0], [0, 1], [0, 2], [0, 3], [1, 0]]


def test_an_unknown_orientation_is_refused():
    with pytest.raises(ValueError, match="orientation 2 of piece 0"):
        shape_index(0, 2)


def test_splitmix64_gives_the_published_sequence():
    # The generator's reference output for seed 1234567.
    assert [splitmix64(1234567, k) for k in range(5)] == [
        6457827717110365317,
        3203168211198807973,
        9817491932198370423,
        4593380528125082431,
        16408922859458223821,
    ]


@pytest.mark.statistical
def test_uniform_pieces_are_equally_likely_and_independent():
    pieces = np.array([uniform_piece(20110801, k) for k in range(70_000)])
    counts = np.bincount(pieces, minlength=7)
    # sd of a count = sqrt(70000 * 1/7 * 6/7) = 92.6; of a pair's count sqrt(70000 * 1/49 * 48/49) = 37.4
    assert np.abs(counts - 10_000).max() < 4 * 92.6
    pairs = np.bincount(pieces[:-1] * 7 + pieces[1:], minlength=49)
    assert np.abs(pairs - 70_000 / 49).max() < 4.5 * 37.4


def test_two_seeds_deal_different_pieces_and_one_seed_the_same():
    first, second = ([uniform_piece(seed, k) for k in range(40)] for seed in (1, 2))
    assert first != second
    assert first == [uniform_piece(1, k) for k in range(40)]


def test_every_bag_holds_the_seven_pieces_once():
    for bag in range(200):
        assert sorted(seven_bag_piece(5, 7 * bag + place) for place in range(7)) == list(range(7))


@pytest.mark.statistical
def test_every_place_in_the_bag_is_taken_by_every_piece_equally_often():
    counts = np.zeros((7, 7))
    for bag in range(7_000):
        for place in range(7):
            counts[place, seven_bag_piece(11, 7 * bag + place)] += 1
    # sd of a count = sqrt(7000 * 1/7 * 6/7) = 29.3
    assert np.abs(counts - 1_000).max() < 4 * 29.3


def test_the_screen_can_import_the_pieces_without_compiled_code():
    code = "import sys, core.tetris.pieces; sys.exit('numba' in sys.modules)"
    assert subprocess.run([sys.executable, "-c", code], check=False).returncode == 0
