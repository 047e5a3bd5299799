"""A person's game: the rules of play."""

import pytest

from core.tetris.game import Primitive
from core.tetris.picture import CLEARED
from core.tetris.pieces import seven_bag_piece, uniform_piece
from core.tetris.practice import Practice

LEFT, RIGHT, ROTATE, DROP = Primitive.LEFT, Primitive.RIGHT, Primitive.ROTATE, Primitive.DROP


def seed_of(*pieces: int) -> int:
    """Return the first seed whose game begins with these pieces."""
    return next(
        seed
        for seed in range(100_000)
        if all(uniform_piece(seed, k) == piece for k, piece in enumerate(pieces))
    )


def test_a_primitive_does_not_make_the_piece_fall_and_gravity_does():
    game = Practice(seed_of(1))
    before = game.picture().falling
    assert before is not None
    after = game.step(LEFT).falling
    assert after is not None
    assert (after.row, after.column) == (before.row, before.column - 1)
    lower = game.step(None).falling
    assert lower is not None
    assert (lower.row, lower.column) == (after.row - 1, after.column)


def test_a_piece_that_cannot_fall_settles_with_the_next_fall():
    game = Practice(seed_of(1), rows=4)
    game.step(None)
    game.step(None)
    assert game.pieces == 0
    game.step(LEFT)
    game.step(None)
    assert game.pieces == 1
    assert game.picture().falling is not None


def test_full_rows_are_shown_until_the_next_fall_and_no_key_hurries_them():
    # two squares side by side fill a board of four columns
    game = Practice(seed_of(1, 1), columns=4)
    game.step(LEFT)
    game.step(DROP)
    game.step(RIGHT)
    lit = game.step(DROP)
    assert lit.falling is None
    assert sum(code & CLEARED != 0 for code in lit.codes()) == 8
    assert lit.counts.lines == 2
    for primitive in (LEFT, ROTATE, DROP):
        assert game.step(primitive) == lit
    gone = game.step(None)
    assert gone.falling is not None
    assert not any(gone.cells)


def test_the_piece_announced_is_the_piece_that_comes():
    game = Practice(11, pieces="seven-bag")
    for k in range(8):
        picture = game.picture()
        if picture.falling is None:
            picture = game.step(None)
        assert picture.falling is not None
        assert picture.falling.piece == seven_bag_piece(11, k)
        assert picture.counts.next_piece == seven_bag_piece(11, k + 1)
        game.step(LEFT if k % 2 else RIGHT)
        game.step(DROP)


def test_a_pile_above_the_board_ends_the_game_and_nothing_moves_any_more():
    game = Practice(seed_of(1, 1, 1), rows=4, columns=6)
    game.step(DROP)
    game.step(DROP)
    assert not game.over
    last = game.step(DROP)
    assert game.over
    assert last.over
    assert game.step(None) == game.step(LEFT) == game.step(DROP) == last
    assert game.pieces == 3


def test_equal_seeds_give_equal_games_and_other_seeds_others():
    def play(seed: int) -> list[bytes]:
        game = Practice(seed)
        return [game.step(primitive).codes() for primitive in [LEFT, ROTATE, DROP, None, RIGHT, DROP] * 6]

    assert play(3) == play(3)
    assert play(3) != play(4)


def test_a_board_too_small_for_the_pieces_is_an_error():
    with pytest.raises(ValueError, match="at least 4 rows and 4 columns, got 3 x 10"):
        Practice(0, rows=3)
