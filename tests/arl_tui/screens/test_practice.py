"""Practice play: keys, gravity by the clock, pause, the end."""

import pytest

from arl_tui.palette import palette_for
from arl_tui.screens.covers import SmallWindowScreen
from arl_tui.screens.practice import Gravity, PracticeApp
from core.numerics.clock import ManualClock
from core.tetris.game import Primitive
from core.tetris.picture import FALLING
from core.tetris.pieces import uniform_piece

MS = 1_000_000


@pytest.fixture(autouse=True)
def _true_colour(monkeypatch: pytest.MonkeyPatch) -> None:
    """Pictures must not depend on the terminal that the tests are run in."""
    monkeypatch.setattr(
        "arl_tui.screens.practice.palette_for",
        lambda name, *_system, **_no_color: palette_for(name, "truecolor"),
    )


def app(clock: ManualClock, **options) -> PracticeApp:
    return PracticeApp(seed=4, clock=clock, fall_s=0.5, **options)


def falling_columns(practice: PracticeApp) -> list[int]:
    codes = practice.practice.game.picture().codes()
    return sorted(index % 10 for index, code in enumerate(codes) if code & FALLING)


def falling_row(practice: PracticeApp) -> int:
    falling = practice.practice.game.picture().falling
    assert falling is not None
    return falling.row


async def test_arrows_and_letters_move_the_piece():
    practice = app(ManualClock())
    async with practice.run_test() as pilot:
        before = falling_columns(practice)
        for left, right in (("left", "right"), ("a", "d")):
            await pilot.press(left)
            assert falling_columns(practice) == [column - 1 for column in before]
            await pilot.press(right)
            assert falling_columns(practice) == before


async def test_arrow_and_letters_turn_the_piece():
    practice = app(ManualClock())
    async with practice.run_test() as pilot:
        for key in ("up", "r", "w"):
            before = practice.practice.game.picture().falling
            await pilot.press(key)
            after = practice.practice.game.picture().falling
            assert before is not None
            assert after is not None
            assert (before.width, before.height) == (after.height, after.width)


async def test_arrow_space_and_letter_drop_the_piece_and_the_announced_one_enters():
    practice = app(ManualClock())
    async with practice.run_test() as pilot:
        for pieces, key in enumerate(("down", "space", "s"), start=1):
            announced = practice.practice.game.picture().counts.next_piece
            await pilot.press(key)
            picture = practice.practice.game.picture()
            assert picture.counts.pieces == pieces
            assert picture.falling is not None
            assert picture.falling.piece == announced == uniform_piece(4, pieces)


async def test_the_piece_falls_as_far_as_the_clock_says_however_late_the_timer_is():
    clock = ManualClock()
    practice = app(clock)
    async with practice.run_test():
        start = falling_row(practice)
        clock.advance_ns(499 * MS)
        practice.practice.fall()
        assert falling_row(practice) == start
        clock.advance_ns(1 * MS)
        practice.practice.fall()
        assert falling_row(practice) == start - 1
        clock.advance_ns(1600 * MS)
        practice.practice.fall()
        assert falling_row(practice) == start - 4
        clock.advance_ns(400 * MS)
        practice.practice.fall()
        assert falling_row(practice) == start - 5


async def test_a_pause_hides_the_board_stops_the_clock_and_ignores_moves():
    clock = ManualClock()
    practice = app(clock)
    async with practice.run_test() as pilot:
        clock.advance_ns(300 * MS)
        await pilot.press("p")
        before = practice.practice.game.picture()
        clock.advance_ns(60_000 * MS)
        practice.practice.fall()
        await pilot.press("left", "space", "up")
        assert practice.practice.game.picture() == before
        assert practice.practice._board.covered
        await pilot.press("p")
        assert not practice.practice._board.covered
        clock.advance_ns(199 * MS)
        practice.practice.fall()
        assert practice.practice.game.picture() == before
        clock.advance_ns(1 * MS)
        practice.practice.fall()
        assert practice.practice.game.picture() != before


async def test_the_end_is_announced_and_a_new_game_has_other_pieces():
    practice = app(ManualClock())
    async with practice.run_test() as pilot:
        screen = practice.practice
        for _ in range(10):
            screen.game.step(Primitive.DROP)
        await pilot.press("space", "space")
        assert screen.game.over
        await pilot.pause()
        lines = [screen._board.render_line(y).text for y in range(20)]
        assert any("GAME OVER" in line for line in lines)
        over = screen.game.picture()
        await pilot.press("space", "left", "p")
        assert screen.game.picture() == over
        await pilot.press("n")
        assert not screen.game.over
        assert not screen._board.covered
        assert screen.game.picture().falling is not None
        assert [uniform_piece(5, k) for k in range(5)] != [uniform_piece(4, k) for k in range(5)]
        assert screen.game.picture().counts.next_piece == uniform_piece(5, 1)


async def test_quitting_gives_back_the_lines_of_the_game():
    practice = app(ManualClock())
    async with practice.run_test() as pilot:
        await pilot.press("q")
    assert practice.return_value == 0


def test_gravity_needs_a_positive_interval():
    with pytest.raises(ValueError, match="interval_ns > 0"):
        Gravity(0, ManualClock())


def test_an_unknown_palette_is_an_error():
    with pytest.raises(ValueError, match="no palette 'pink'"):
        PracticeApp(palette="pink")


async def test_a_window_that_is_too_small_stops_the_game_until_it_grows():
    clock = ManualClock()
    practice = app(clock)
    async with practice.run_test(size=(80, 24)) as pilot:
        await pilot.resize_terminal(59, 24)
        await pilot.pause()
        assert isinstance(practice.screen, SmallWindowScreen)
        row = falling_row(practice)
        clock.advance_ns(3000 * MS)
        practice.practice.fall()
        assert falling_row(practice) == row
        await pilot.resize_terminal(60, 22)
        await pilot.pause()
        assert practice.screen is practice.practice
        clock.advance_ns(500 * MS)
        practice.practice.fall()
        assert falling_row(practice) != row


async def test_practice_ends_where_no_larger_window_can_be_had():
    practice = app(ManualClock())
    async with practice.run_test(size=(80, 24)) as pilot:
        await pilot.resize_terminal(59, 24)
        await pilot.pause()
        await pilot.press("q")
        await pilot.pause()
    assert not practice.is_running
    assert practice.return_value is not None


@pytest.mark.parametrize("size", [(80, 24), (120, 40)])
def test_practice_looks_as_it_did(snap_compare, size: tuple[int, int]):
    practice = app(ManualClock())
    keys = [*"asrdsra"]
    assert snap_compare(practice, terminal_size=size, press=keys)


def test_a_lost_game_looks_as_it_did(snap_compare):
    practice = app(ManualClock())

    async def lose(pilot) -> None:
        for _ in range(10):
            practice.practice.game.step(Primitive.DROP)
        await pilot.press("space", "space")

    assert snap_compare(practice, terminal_size=(80, 24), run_before=lose)
