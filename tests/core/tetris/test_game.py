"""Moves by primitives: by hand, against the twin, invariants."""

import gzip
import json

import msgspec
import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from core.tetris.game import (
    Board,
    FallingPiece,
    Primitive,
    at_rest,
    fallen,
    fits,
    flight,
    landing_row,
    moved,
    reachable_mask,
    reachable_placements,
    settle,
    spawn,
)
from core.tetris.pieces import N_PIECES, ORIENTATION_ROWS, PIECE_NAMES, all_placements
from tests.data_folder import data_folder
from tests.naive import tetris_game as naive

I, O, T, Z, S, J, L = range(7)
LEFT, RIGHT, ROTATE, DROP = Primitive.LEFT, Primitive.RIGHT, Primitive.ROTATE, Primitive.DROP
EMPTY: Board = (0,) * 10
ROWS = 20


def cells_of(board: Board) -> naive.Cells:
    return frozenset(
        (row, column) for column, bits in enumerate(board) for row in range(64) if bits >> row & 1
    )


def board_of(cells: naive.Cells, columns: int) -> Board:
    return tuple(sum(1 << row for row, c in cells if c == column) for column in range(columns))


def columns_of(rows: list[int]) -> Board:
    """Return a board given as rows from the bottom, bit 0 = leftmost column."""
    return tuple(sum(1 << row for row, bits in enumerate(rows) if bits >> column & 1) for column in range(10))


def pictured(*lines: str) -> Board:
    """Return the board drawn by these lines, the lowest last."""
    return tuple(
        sum(1 << row for row, line in enumerate(reversed(lines)) if line[column] == "X")
        for column in range(len(lines[0]))
    )


@st.composite
def boards(draw: st.DrawFn, rows: int = 12) -> Board:
    """Boards with holes and overhangs, of any usual width, without full rows."""
    columns = draw(st.integers(4, 10))
    height = draw(st.integers(0, rows))
    bits = [draw(st.integers(0, (1 << height) - 1)) for _ in range(columns)]
    full = (1 << rows) - 1
    for column in bits:
        full &= column
    bits[draw(st.integers(0, columns - 1))] &= ~full
    return tuple(bits)


pieces = st.integers(0, N_PIECES - 1)
plans = st.lists(st.sampled_from([LEFT, RIGHT, ROTATE, DROP, None]), max_size=40)


# --- by hand ------------------------------------------------------------------------------------------------


def test_pieces_enter_flat_in_the_middle_of_the_highest_rows():
    assert spawn(EMPTY, I, ROWS) == FallingPiece(I, 1, 19, 3)
    assert spawn(EMPTY, O, ROWS) == FallingPiece(O, 0, 18, 4)
    # orientation 1 of T and 2 of L have three cells below and one above
    assert spawn(EMPTY, T, ROWS) == FallingPiece(T, 1, 18, 3)
    assert spawn(EMPTY, L, ROWS) == FallingPiece(L, 2, 18, 3)


def test_a_pile_in_the_way_makes_a_piece_enter_higher():
    tower = (0, 0, 0, 0, (1 << 19) - 1, 0, 0, 0, 0, 0)
    assert spawn(tower, O, ROWS) == FallingPiece(O, 0, 19, 4)
    assert spawn(tower, S, ROWS).row == 19


def test_a_turn_is_clockwise():
    upright_t = spawn(EMPTY, T, ROWS)
    assert sorted(upright_t.cells()) == [(18, 3), (18, 4), (18, 5), (19, 4)]
    # the stem that pointed up points right
    turned = moved(EMPTY, upright_t, ROTATE)
    assert sorted(turned.cells()) == [(18, 3), (19, 3), (19, 4), (20, 3)]


def test_turning_a_long_piece_keeps_its_middle():
    upright = moved(EMPTY, spawn(EMPTY, I, ROWS), ROTATE)
    assert upright == FallingPiece(I, 0, 19, 4)
    assert moved(EMPTY, upright, ROTATE) == spawn(EMPTY, I, ROWS)


def test_a_turn_beside_the_wall_pushes_the_piece_inside():
    assert moved(EMPTY, FallingPiece(I, 0, 5, 9), ROTATE) == FallingPiece(I, 1, 5, 6)


def test_a_blocked_primitive_does_nothing():
    at_wall = FallingPiece(O, 0, 5, 0)
    assert moved(EMPTY, at_wall, LEFT) == at_wall
    between = pictured("X..X", "X..X", "X..X", "X..X")
    stuck = FallingPiece(T, 2, 0, 1)
    assert fits(between, stuck)
    assert moved(between, stuck, ROTATE) == stuck
    assert moved(between, stuck, RIGHT) == stuck


def test_a_drop_stops_on_the_pile():
    assert moved(pictured("....", "X...", "X..."), FallingPiece(O, 0, 9, 0), DROP).row == 2


def test_moves_cost_height():
    # three columns to the left, then the drop: entering at row 18, the piece is dropped from row 15
    plan = reachable_placements(EMPTY, O, ROWS)[0, 1]
    assert plan == (LEFT, LEFT, LEFT, DROP)
    assert [falling.row for falling in flight(EMPTY, spawn(EMPTY, O, ROWS), plan)] == [18, 17, 16, 15, 0]


def test_a_plan_may_end_by_gravity():
    # two rows: the bar moves left, and then has nowhere to fall
    assert flight((0,) * 6, spawn((0,) * 6, O, 2), (LEFT,))[-1] == FallingPiece(O, 0, 0, 1)
    assert reachable_placements((0,) * 6, O, 2)[0, 1] == (LEFT,)


def test_a_plan_that_does_not_bring_the_piece_to_rest_is_an_error():
    with pytest.raises(ValueError, match="still in the air"):
        flight(EMPTY, spawn(EMPTY, O, ROWS), (LEFT, LEFT))
    with pytest.raises(ValueError, match="rests after tick 1 of a plan of 2"):
        flight(EMPTY, spawn(EMPTY, O, ROWS), (DROP, LEFT))


def test_a_wall_up_to_the_top_closes_one_side():
    # column 3 is full up to row 19: pieces enter above it, and come down on either side only if they move at
    # once
    tower = (0, 0, 0, (1 << 20) - 1, 0, 0, 0, 0, 0, 0)
    plans = reachable_placements(tower, O, ROWS)
    # entering at row 18 in columns 4 and 5, beside the tower: the three columns left of it cannot be reached
    assert sorted(column for _, column in plans) == [4, 5, 6, 7, 8]
    assert reachable_mask(tower, O, all_placements(O, 10), ROWS).tolist() == [False] * 4 + [True] * 5


def test_sliding_below_an_overhang_is_not_the_placement_of_that_column():
    # the only way to column 0 is below the overhang, but dropped from above a piece would lie on it
    overhang = pictured("XX..........", "............", "............", "............")
    for (orientation, column), plan in reachable_placements(overhang, O, 4).items():
        rest = flight(overhang, spawn(overhang, O, 4), plan)[-1]
        assert rest.row == landing_row(overhang, O, orientation, column)
    assert (0, 0) not in reachable_placements(overhang, O, 4)


def test_full_rows_go_and_what_was_above_comes_down():
    board = pictured("X.......", "XXXX....", "X.X.XXXX", "XXXX....")
    settled = settle(board, FallingPiece(I, 1, 0, 4), 8)
    assert settled.cleared == (0,)
    assert settled.board == pictured("X.......", "XXXX....", "X.X.XXXX")
    settled = settle(pictured("XX.", "X..", "XX."), FallingPiece(I, 0, 0, 2), 8)
    assert settled.cleared == (0, 2)
    assert settled.board == pictured("..X", "X.X")


def test_a_piece_that_sticks_out_clears_nothing_unless_told_to():
    board = pictured("XXX.", "XXX.", "XXX.")
    sticking_out = FallingPiece(I, 0, 0, 3)
    assert settle(board, sticking_out, 3) == settle(board, sticking_out, 3, clear_on_overflow=False)
    assert settle(board, sticking_out, 3).over
    assert settle(board, sticking_out, 3).cleared == ()
    overflow = settle(board, sticking_out, 3, clear_on_overflow=True)
    assert (overflow.board, overflow.cleared, overflow.over) == ((0, 0, 0, 1), (0, 1, 2), False)


def test_settling_inside_the_pile_is_an_error():
    with pytest.raises(ValueError, match="does not fit"):
        settle((1,) * 10, FallingPiece(O, 0, 0, 0), ROWS)


def test_falling_pieces_survive_the_trip_to_another_process():
    falling = FallingPiece(L, 2, 18, 3)
    assert msgspec.msgpack.decode(msgspec.msgpack.encode(falling), type=FallingPiece) == falling


# --- against the twin ---------------------------------------------------------------------------------------


@given(board=boards(), piece=pieces, plan=plans)
@settings(max_examples=150)
def test_every_tick_agrees_with_the_twin(board: Board, piece: int, plan: list[Primitive | None]):
    wall, columns = cells_of(board), len(board)
    falling, twin = spawn(board, piece, 12), naive.enters(wall, PIECE_NAMES[piece], 12, columns)
    assert frozenset(falling.cells()) == twin
    for primitive in plan:
        after = falling if primitive is None else moved(board, falling, primitive)
        twin = naive.acted(wall, twin, primitive, columns)
        assert frozenset(after.cells()) == twin
        falling, twin = fallen(board, after), naive.pushed(wall, twin, -1, 0, columns)
        assert frozenset(falling.cells()) == twin


@given(board=boards(rows=8), piece=pieces)
@settings(max_examples=60)
def test_reachable_placements_and_their_lengths_agree_with_the_twin(board: Board, piece: int):
    wall, columns = cells_of(board), len(board)
    ticks = naive.ticks_to_reach(wall, PIECE_NAMES[piece], 8, columns)
    wanted = naive.straight_drops(wall, PIECE_NAMES[piece], columns, above=20)
    found = {}
    for (orientation, column), plan in reachable_placements(board, piece, 8).items():
        row = landing_row(board, piece, orientation, column)
        found[frozenset(FallingPiece(piece, orientation, row, column).cells())] = len(plan)
    assert found == {cells: ticks[cells] for cells in wanted if cells in ticks}


@given(board=boards(), piece=pieces, plan=plans, clear_on_overflow=st.booleans())
@settings(max_examples=150)
def test_settling_agrees_with_the_twin(
    board: Board, piece: int, plan: list[Primitive | None], clear_on_overflow: bool
):
    falling = spawn(board, piece, 12)
    for primitive in plan:
        falling = fallen(board, falling if primitive is None else moved(board, falling, primitive))
    falling = at_rest(board, falling)
    filled = cells_of(board) | frozenset(falling.cells())
    if clear_on_overflow or all(row < 12 for row, _ in falling.cells()):
        after, full = naive.cleared(filled, len(board))
    else:
        after, full = filled, []
    settled = settle(board, falling, 12, clear_on_overflow=clear_on_overflow)
    assert settled.board == board_of(after, len(board))
    assert settled.cleared == tuple(full)
    assert settled.over == any(row >= 12 for row, _ in after)


# --- against the reference's games --------------------------------------------------------------------------


def test_dropped_pieces_settle_as_in_the_reference():
    paths = sorted(data_folder("tetris_oracle").glob("afterstates*.jsonl.gz"))
    assert paths
    for path in paths:
        with gzip.open(path, "rt") as lines:
            header, *records = [json.loads(line) for line in lines]
        assert records
        for record in records:
            _compare_with_reference(record, header["clear_on_overflow"])


def _compare_with_reference(record: dict, clear_on_overflow: bool) -> None:
    board = columns_of(record["board"])
    for action in record["actions"]:
        orientation, column = action["orientation"], action["column"]
        row = landing_row(board, record["piece"], orientation, column)
        settled = settle(
            board,
            FallingPiece(record["piece"], orientation, row, column),
            ROWS,
            clear_on_overflow=clear_on_overflow,
        )
        assert row == action["landing_row"]
        assert settled.board == columns_of(action["board"] + action.get("above", []))
        assert len(settled.cleared) == action["lines"]
        assert settled.over == bool(action["game_over"])


# --- invariants ---------------------------------------------------------------------------------------------


@given(board=boards(), piece=pieces, plan=plans)
@settings(max_examples=150)
def test_a_piece_keeps_its_four_cells_and_never_overlaps(
    board: Board, piece: int, plan: list[Primitive | None]
):
    wall = cells_of(board)
    falling = spawn(board, piece, 12)
    for primitive in plan:
        after = falling if primitive is None else moved(board, falling, primitive)
        falling = fallen(board, after)
        for position in (after, falling):
            cells = set(position.cells())
            assert len(cells) == 4
            assert not cells & wall
            assert all(row >= 0 and 0 <= column < len(board) for row, column in cells)
            assert position.orientation < len(ORIENTATION_ROWS[piece])


@given(board=boards(), piece=pieces)
@settings(max_examples=100)
def test_a_plan_brings_about_exactly_the_placement(board: Board, piece: int):
    for (orientation, column), plan in reachable_placements(board, piece, 12).items():
        rest = flight(board, spawn(board, piece, 12), plan)[-1]
        assert rest == FallingPiece(
            piece, orientation, landing_row(board, piece, orientation, column), column
        )
        assert settle(board, rest, 12).board == settle(board, at_rest(board, rest), 12).board


@pytest.mark.parametrize("piece", range(N_PIECES))
@pytest.mark.parametrize("columns", [4, 10, 16])
def test_everything_can_be_reached_on_an_empty_board_of_usual_height(piece: int, columns: int):
    placements = all_placements(piece, columns)
    assert reachable_mask((0,) * columns, piece, placements, ROWS).all()
    assert len(reachable_placements((0,) * columns, piece, ROWS)) == len(placements)


@given(board=boards(rows=8), piece=pieces, rows=st.integers(4, 8))
@settings(max_examples=300)
def test_the_mask_says_which_placements_have_a_plan(board: Board, piece: int, rows: int):
    board = tuple(bits & ((1 << rows) - 1) for bits in board)
    placements = all_placements(piece, len(board))
    plans = reachable_placements(board, piece, rows)
    mask = reachable_mask(board, piece, placements, rows)
    assert mask.tolist() == [place in plans for place in map(tuple, placements.tolist())]


def test_the_mask_keeps_the_order_of_the_placements():
    tower = (0, 0, 0, (1 << 20) - 1, 0, 0, 0, 0, 0, 0)
    placements = all_placements(T, 10)
    shuffled = np.random.default_rng(1).permutation(len(placements))
    mask = reachable_mask(tower, T, placements, ROWS)
    assert 0 < mask.sum() < len(mask)
    assert (reachable_mask(tower, T, placements[shuffled], ROWS) == mask[shuffled]).all()
    assert reachable_mask(tower, T, placements[:0], ROWS).shape == (0,)
