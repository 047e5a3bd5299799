"""Coloured walls, snapshots and animated placements."""

from itertools import pairwise

import msgspec
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from core.tetris.game import FallingPiece, Primitive, landing_row, reachable_placements, settle
from core.tetris.picture import (
    CLEARED,
    FALLING,
    GHOST,
    UNKNOWN,
    Counts,
    PieceAnimation,
    Snapshot,
    Wall,
    animate,
    snapshot,
)
from core.tetris.pieces import N_PIECES, all_placements

I, O, T = 0, 1, 2
ROWS, COLUMNS = 10, 6


@st.composite
def walls(draw: st.DrawFn) -> Wall:
    """Coloured walls with holes, no row full."""
    height = draw(st.integers(0, ROWS))
    levels = []
    for _ in range(height):
        level = draw(st.lists(st.integers(0, UNKNOWN), min_size=COLUMNS, max_size=COLUMNS))
        level[draw(st.integers(0, COLUMNS - 1))] = 0
        levels.append(bytes(level))
    return Wall(ROWS, COLUMNS, tuple(levels))


def test_codes_run_from_the_highest_row_and_tell_wall_piece_and_ghost_apart():
    wall = Wall(4, 4, (bytes([3, 3, 0, 0]),))
    picture = snapshot(wall, FallingPiece(O, 0, 2, 1), counts=Counts())
    piece, ghost = FALLING + O + 1, GHOST + O + 1
    # resting on row 1, the ghost's upper half hides behind the piece
    assert picture.ghost_row == 1
    assert list(picture.codes()) == [0, piece, piece, 0, 0, piece, piece, 0, 0, ghost, ghost, 0, 3, 3, 0, 0]


def test_what_sticks_out_above_the_board_is_not_shown():
    picture = snapshot(Wall(4, 4), FallingPiece(I, 0, 3, 0), counts=Counts())
    assert [code & FALLING for code in picture.codes()].count(FALLING) == 1
    assert len(picture.codes()) == 16


def test_a_drop_is_shown_as_a_fall():
    animation = animate(Wall(12, 4), O, (0, 1), (Primitive.DROP,), counts=Counts(), drop_rows_per_tick=4)
    rows = [frame.falling.row for frame in animation.frames if frame.falling is not None]
    assert rows == [10, 6, 2, 0]
    assert [frame.tick for frame in animation.frames] == [0, 1, 2, 3, 4]


def test_moves_are_shown_one_per_tick():
    plan = (Primitive.LEFT, Primitive.ROTATE, Primitive.DROP)
    frames = animate(Wall(12, 8), T, (0, 0), plan, counts=Counts(), drop_rows_per_tick=99).frames
    path = [(f.falling.row, f.falling.column, f.falling.orientation) for f in frames if f.falling is not None]
    assert path == [(10, 2, 1), (9, 1, 1), (8, 1, 0), (0, 1, 0)]


def test_full_rows_are_shown_full_once_and_then_counted():
    wall = Wall(6, 4, (bytes([1, 1, 0, 0]), bytes([1, 1, 0, 0])))
    animation = animate(wall, O, (0, 2), None, counts=Counts(lines=5, pieces=9, next_piece=3))
    lit, final = animation.frames[-2:]
    assert lit.cleared == (0, 1)
    assert [code & CLEARED for code in lit.codes()] == [0] * 16 + [CLEARED] * 8
    assert lit.counts == Counts(lines=5, pieces=9, next_piece=3)
    assert final.counts == Counts(lines=7, pieces=10, next_piece=3)
    assert set(final.codes()) == {0}
    assert animation.wall.levels == ()
    assert animation.ticks == len(animation.frames)


def test_a_pile_above_the_board_ends_the_game_in_the_last_picture():
    wall = Wall(3, 4, (bytes([1, 0, 0, 0]),) * 3)
    animation = animate(wall, O, (0, 0), None, counts=Counts())
    assert animation.settled.over
    assert animation.frames[-1].over
    assert not any(frame.over for frame in animation.frames[:-1])


def test_a_drop_by_no_rows_is_an_error():
    with pytest.raises(ValueError, match="drop_rows_per_tick is at least 1, got 0"):
        animate(Wall(6, 4), O, (0, 0), None, counts=Counts(), drop_rows_per_tick=0)


def test_pictures_survive_the_trip_to_another_process():
    frames = animate(Wall(12, 8), T, (0, 0), None, counts=Counts(next_piece=4)).frames
    for frame in frames:
        packed = msgspec.msgpack.encode(frame)
        assert msgspec.msgpack.decode(packed, type=Snapshot) == frame
        assert len(packed) < 200


@given(wall=walls(), piece=st.integers(0, N_PIECES - 1), choice=st.integers(0, 10_000), by_plan=st.booleans())
@settings(max_examples=150)
def test_an_animation_ends_in_exactly_the_afterstate(wall: Wall, piece: int, choice: int, by_plan: bool):
    placements = all_placements(piece, COLUMNS).tolist()
    orientation, column = placements[choice % len(placements)]
    plan = reachable_placements(wall.board, piece, ROWS).get((orientation, column))
    animation = animate(wall, piece, (orientation, column), plan if by_plan else None, counts=Counts())
    row = landing_row(wall.board, piece, orientation, column)
    expected = settle(wall.board, FallingPiece(piece, orientation, row, column), ROWS)
    assert animation.settled == expected
    assert animation.wall.board == expected.board
    _check_frames(animation, wall)


def _check_frames(animation: PieceAnimation, wall: Wall) -> None:
    """In the air a piece only ever falls, and the wall stays as it was until the piece rests."""
    rows = [frame.falling.row for frame in animation.frames if frame.falling is not None]
    assert all(lower <= upper for upper, lower in pairwise(rows))
    for tick, frame in enumerate(animation.frames):
        assert frame.tick == tick
        assert len(frame.codes()) == ROWS * COLUMNS
        if frame.falling is not None:
            assert frame.cells == wall.from_top()
            assert frame.ghost_row <= frame.falling.row
    if not animation.settled.over:
        inside = sum(code != 0 for code in wall.from_top())
        left = sum(code != 0 for code in animation.frames[-1].codes())
        assert left == inside + 4 - COLUMNS * len(animation.settled.cleared)
