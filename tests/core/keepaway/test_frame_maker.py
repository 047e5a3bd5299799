"""The frame maker: pictures of a match that is played cycle by cycle."""

import numpy as np
import pytest

from core.keepaway.frame_maker import TRAIL_CYCLES, FrameMaker
from core.keepaway.picture import PitchFrame
from core.keepaway.pitch import KICK_DISTANCE, NO_PLAYER, ONGOING, KeepawayConfig
from core.keepaway.simulator.game import next_episode, step_cycle
from core.keepaway.simulator.match import ACTION, TARGET, Match, Streams, new_match, open_streams
from core.keepaway.simulator.policies import HAND_CODED

CONFIG = KeepawayConfig(exact_state=True)


@pytest.fixture(scope="module")
def filmed() -> list[tuple[Match, PitchFrame]]:
    """Return copies of a match and its pictures: three episodes of the hand-coded policy."""
    streams: Streams = open_streams(3, "film")
    match, rules, frame_maker = new_match(CONFIG, streams), CONFIG.rules(), FrameMaker(CONFIG)
    film = []

    def look() -> None:
        film.append((Match(*(np.copy(array) for array in match)), frame_maker.look(match)))

    look()
    while film[-1][1].episode < 4:
        if step_cycle(match, rules, HAND_CODED, streams):
            look()
            next_episode(match, rules, streams)
        look()
    return film


def test_pictures_show_the_match(filmed: list[tuple[Match, PitchFrame]]):
    for match, frame in filmed:
        assert [(p.x_m, p.y_m, p.body_deg) for p in frame.players] == [
            tuple(row[[0, 1, 4]]) for row in match.players
        ]
        assert frame.ball == tuple(match.ball[:2])
        assert frame.ended == match.status[3]
        assert frame.time_s == pytest.approx(0.1 * frame.cycle)


def test_the_player_with_the_ball_is_the_nearest_in_reach(filmed: list[tuple[Match, PitchFrame]]):
    for match, frame in filmed:
        distances = np.hypot(*(match.players[:, :2] - match.ball[:2]).T)
        if frame.holder == NO_PLAYER:
            assert distances.min() >= KICK_DISTANCE
        else:
            assert distances[frame.holder] == distances.min() < KICK_DISTANCE
    assert {frame.taken for _, frame in filmed} == {True, False}


def test_an_option_stays_on_screen_until_the_next_decision(filmed: list[tuple[Match, PitchFrame]]):
    shown, n_passes = (NO_PLAYER, NO_PLAYER), 0
    for match, frame in filmed:
        if frame.cycle == 0:
            shown = (NO_PLAYER, NO_PLAYER)
        elif match.deciding.any():
            (keeper,) = np.flatnonzero(match.deciding)
            row = match.options[keeper]
            shown = (keeper, row[TARGET] if row[ACTION] > 0 else NO_PLAYER)
            n_passes += row[ACTION] > 0
        assert (frame.decider, frame.target) == shown
    assert n_passes > 10


def test_the_trail_is_where_the_ball_was_in_this_episode(filmed: list[tuple[Match, PitchFrame]]):
    for k, (_, frame) in enumerate(filmed):
        n_before = min(frame.cycle, TRAIL_CYCLES)
        assert frame.trail == tuple(earlier.ball for _, earlier in filmed[k - n_before : k])


def test_looking_twice_changes_nothing():
    streams = open_streams(4, "film")
    match, frame_maker = new_match(CONFIG, streams), FrameMaker(CONFIG)
    step_cycle(match, CONFIG.rules(), HAND_CODED, streams)
    assert frame_maker.look(match) == frame_maker.look(match)
    assert frame_maker.look(match).ended == ONGOING
