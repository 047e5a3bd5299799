"""Playing at any speed: which picture is due when."""

import msgspec
import pytest

from arl_tui.games.keepaway.playback import MOST_CYCLES, Playback
from core.keepaway.picture import PitchFrame
from core.keepaway.pitch import OUT
from core.numerics.clock import ManualClock
from tests.arl_tui.pitches import HOLDING

MS = 1_000_000
START = msgspec.structs.replace(HOLDING, ball=(0.0, 0.0), cycle=0, time_s=0.0, episode=1)


class Rolling:
    """A source in which the ball rolls a metre per cycle and is out after `length` cycles."""

    def __init__(self, length: int = 5) -> None:
        self.frame = START
        self.length = length

    def step(self) -> PitchFrame:
        if self.frame.ended:
            return self.next_episode()
        cycle = self.frame.cycle + 1
        self.frame = msgspec.structs.replace(
            self.frame,
            cycle=cycle,
            time_s=cycle / 10,
            ball=(float(cycle), 0.0),
            ended=OUT if cycle == self.length else 0,
        )
        return self.frame

    def next_episode(self) -> PitchFrame:
        self.frame = msgspec.structs.replace(START, episode=self.frame.episode + 1)
        return self.frame

    def values(self) -> tuple[tuple[str, float], ...]:
        return (("Hold", float(self.frame.cycle)),)


@pytest.fixture
def clock() -> ManualClock:
    return ManualClock()


def playback(clock: ManualClock, length: int = 5, **options: float) -> Playback:
    return Playback(Rolling(length), clock, **options)


def test_between_two_cycles_the_ball_is_where_the_clock_says(clock: ManualClock):
    shown = playback(clock)
    assert shown.picture().ball == (0.0, 0.0)
    clock.advance_ns(25 * MS)
    assert shown.picture().ball == pytest.approx((0.25, 0.0))
    clock.advance_ns(150 * MS)
    assert shown.picture().ball == pytest.approx((1.75, 0.0))
    assert shown.picture().cycle == 1


@pytest.mark.parametrize("speed", [0.1, 0.5, 2.0])
def test_slow_motion_stretches_the_clock_not_the_games_time(clock: ManualClock, speed: float):
    shown = playback(clock, speed=speed)
    clock.advance_ns(round(150 * MS / speed))
    picture = shown.picture()
    assert picture.time_s == pytest.approx(0.15)
    assert picture.ball == pytest.approx((1.5, 0.0))


def test_however_often_one_looks_the_same_time_passes(clock: ManualClock):
    often, once = playback(clock, 50), playback(clock, 50)
    for _ in range(37):
        clock.advance_ns(33 * MS)
        often.picture()
    assert often.picture() == once.picture()


def test_the_last_picture_stays_a_while_and_the_next_episode_begins_at_its_start(clock: ManualClock):
    shown = playback(clock, length=2, speed=0.5, rest_s=1.0)
    clock.advance_ns(400 * MS)
    assert shown.picture().ended == OUT
    assert shown.ends == [(0.2, OUT)]
    clock.advance_ns(999 * MS)
    assert shown.picture().ended == OUT
    clock.advance_ns(1 * MS)
    picture = shown.picture()
    assert (picture.episode, picture.ball, picture.time_s) == (2, (0.0, 0.0), 0.0)


def test_a_pause_stops_time(clock: ManualClock):
    shown = playback(clock)
    clock.advance_ns(130 * MS)
    shown.paused = True
    before = shown.picture()
    clock.advance_ns(10_000 * MS)
    assert shown.picture() == before
    shown.paused = False
    clock.advance_ns(20 * MS)
    assert shown.picture().ball == pytest.approx((1.5, 0.0))


def test_single_steps_show_whole_cycles(clock: ManualClock):
    shown = playback(clock, length=3)
    clock.advance_ns(130 * MS)
    for cycle in (2, 3):
        shown.step()
        assert shown.paused
        assert shown.picture().ball == (float(cycle), 0.0)
        assert shown.values == (("Hold", float(cycle)),)
    assert shown.picture().ended == OUT
    shown.step()
    assert (shown.picture().episode, shown.picture().cycle) == (2, 0)
    assert shown.ends == [(0.3, OUT)]


def test_the_next_episode_comes_at_once_and_is_never_skipped(clock: ManualClock):
    shown = playback(clock, length=3)
    clock.advance_ns(130 * MS)
    shown.next_episode()
    assert (shown.picture().episode, shown.picture().ball) == (2, (0.0, 0.0))
    clock.advance_ns(300 * MS)
    assert shown.picture().ended == OUT
    shown.next_episode()
    assert (shown.picture().episode, shown.picture().cycle) == (3, 0)
    assert shown.ends == [(0.3, OUT)]


def test_who_was_away_for_long_does_not_see_a_minute_fly_by(clock: ManualClock):
    shown = playback(clock, length=10_000)
    clock.advance_ns(60_000 * MS)
    assert shown.picture().cycle == MOST_CYCLES


def test_keys_go_through_the_speeds_and_stop_at_the_ends(clock: ManualClock):
    shown = playback(clock, speed=0.3)
    shown.faster()
    assert shown.speed == 0.5
    for _ in range(20):
        shown.faster()
    assert shown.speed == 8.0
    for _ in range(20):
        shown.slower()
    assert shown.speed == 0.1


def test_a_speed_of_nothing_is_an_error(clock: ManualClock):
    with pytest.raises(ValueError, match=r"0.02 to 20 times real time, got 0"):
        playback(clock, speed=0.0)
