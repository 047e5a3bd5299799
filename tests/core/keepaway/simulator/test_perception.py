"""What players see and believe, by hand."""

import numpy as np
import pytest
from msgspec.structs import replace

from core.keepaway.pitch import ANGLE, BODY, DASH, KIND, NECK, POWER, TURN, VX, VY, KeepawayConfig, X, Y
from core.keepaway.simulator import match as m
from core.keepaway.simulator.hearing import listen
from core.keepaway.simulator.match import new_match, open_streams
from core.keepaway.simulator.perception import FORGET_BALL, perceive
from core.keepaway.simulator.sight import measure, rounded, seen_distance
from core.numerics.streams import stream

RNG = stream(1, "perception")
SEES, BLIND = 0, 2


def scene(config=None):
    """Return a match in its middle: everybody has just seen everything; the ball is at the origin."""
    config = replace(config or KeepawayConfig(quantise=False), see_phases=(0,) * 5)
    match = new_match(config, open_streams(1, "scene"))
    match.players[:, :4] = 0.0
    match.players[:, X] = [-2, 8, 8, 4, 6]
    match.players[:, Y] = [0, 8, -8, 0, 3]
    match.players[:, BODY:] = 0.0
    match.ball[:] = 0.0
    see(match, config)
    return match, config


def see(match, config, clock=SEES):
    match.status[m.CLOCK] = clock
    perceive(match, config.rules(), RNG)


def test_distances_are_seen_in_steps_of_a_tenth():
    # ln 10 = 2.3026 -> 2.3 -> 9.974 -> 10.0; ln 3.2 = 1.163 -> 1.2 -> 3.320 -> 3.3
    assert seen_distance(10.0) == pytest.approx(10.0)
    assert seen_distance(3.2) == pytest.approx(3.3)
    assert rounded(0.25, 0.1) == pytest.approx(0.3)


@pytest.mark.parametrize("distance", np.geomspace(0.1, 40, 50))
def test_a_seen_distance_is_wrong_by_at_most_five_percent_and_five_centimetres(distance):
    assert abs(seen_distance(distance) - distance) <= 0.0513 * distance + 0.05


def test_two_that_see_each_other_measure_the_same_motion():
    a, b = np.array([0.0, 0, 0.1, 0.2]), np.array([3.0, 4, -0.3, 0.4])
    out = np.zeros(5)
    back = np.zeros(5)
    measure(a, b, True, out)
    measure(b, a, True, back)
    np.testing.assert_allclose(out[[0, 2, 3, 4]], back[[0, 2, 3, 4]])
    # Moving apart at (-0.4 * 3 + 0.2 * 4) / 5 = -0.08 per cycle: -0.016 of the distance, rounded to -0.02.
    measure(a, b, False, back)
    assert back[3] == pytest.approx(-0.08)
    assert out[3] == pytest.approx(-0.02 * out[2])


def test_two_of_three_cycles_bring_sight():
    match, config = scene()
    match.ball[X] = 0.5
    for clock, seen in ((3, True), (4, True), (5, False)):
        match.seen_ball[1, X] = 9.0
        see(match, config, clock)
        assert (abs(match.seen_ball[1, X] - 0.5) < 1e-9) == seen


def test_unseen_for_twelve_cycles_is_forgotten():
    match, config = scene()
    for cycle in range(1, 14):
        see(match, config, BLIND)
        assert match.known[0, 1] == (cycle <= 12)
        assert (match.ball_age[0] <= FORGET_BALL) == (cycle <= 10)
    assert match.known[0, 0]


def test_the_opponent_fastest_to_the_ball_is_thought_to_come_nearer_and_others_to_fall_back():
    match, config = scene()
    see(match, config, BLIND)
    # Keepers: taker 3, 4 m from the resting ball, comes 0.3 m; taker 4 drops back by 0.25 m along x.
    assert match.seen_players[0, 3, X] == pytest.approx(3.7)
    assert match.seen_players[0, 4, X] == pytest.approx(5.75)
    # Takers play towards -x: for them keeper 0 comes, keeper 1 falls back towards +x.
    assert match.seen_players[3, 0, X] == pytest.approx(-1.7)
    assert match.seen_players[3, 1, X] == pytest.approx(8.25)


def test_opponents_are_thought_to_advance_with_the_ball():
    match, config = scene()
    match.ball[VX] = 1.5
    see(match, config)
    see(match, config, BLIND)
    assert match.seen_players[0, 4, X] == pytest.approx(6.5)


def test_a_team_mate_is_thought_to_roll_out():
    match, config = scene()
    match.players[1, VX] = 0.4
    see(match, config)
    see(match, config, BLIND)
    assert match.seen_players[0, 1, X] == pytest.approx(8.4)
    assert match.seen_players[0, 1, VX] == pytest.approx(0.16)


def test_a_ball_in_an_opponents_reach_is_thought_to_lie_still():
    match, config = scene()
    match.ball[:] = 4.5, 0.0, 1.0, 0.0
    see(match, config)
    assert match.seen_ball[0, VX] == 0.0
    # The taker itself, in whose reach it is, sees it move; the keepers are its opponents.
    assert match.seen_ball[3, VX] == pytest.approx(1.0)


def test_ones_own_turn_is_believed_as_meant_until_seen():
    match, config = scene()
    match.commands[0, [KIND, ANGLE]] = TURN, 90.0
    match.players[0, BODY] = 97.0
    see(match, config, BLIND)
    assert match.seen_players[0, 0, BODY] == pytest.approx(90.0)
    match.commands[:] = 0.0
    see(match, config)
    assert match.seen_players[0, 0, BODY] == 97.0


def test_with_90_degrees_only_what_lies_before_the_neck_is_seen():
    match, config = scene(KeepawayConfig(view_angle_deg=90.0, quantise=False))
    match.player_age[:] = 5
    match.players[0, NECK] = 0.0
    see(match, config)
    # Keeper 0 at (-2, 0) looks along x: takers within 45 degrees, keepers at 38.7 degrees are seen.
    assert (match.player_age[0, 1:] == 0).all()
    match.player_age[:] = 5
    match.players[0, NECK] = 90.0
    see(match, config)
    assert match.player_age[0, 2] > 0
    assert match.player_age[0, 3] > 0


def test_exact_state_needs_no_belief():
    match = new_match(KeepawayConfig(exact_state=True), open_streams(1, "scene"))
    perceive(match, KeepawayConfig(exact_state=True).rules(), RNG)
    assert match.known.all()
    assert not match.seen_players.any()
    assert match.players[:, VY].tolist() == [0] * 5


def test_who_collides_unseeing_believes_it_went_as_far_as_it_meant_to():
    match, config = scene()
    match.commands[3, [KIND, POWER]] = DASH, 100.0
    match.players[3, :4] = 4.1, 0.0, -0.024, 0.0  # stopped after 0.1 m; -0.1 of 0.24 is left
    match.hit[4] = True
    see(match, config, BLIND)
    assert match.seen_players[3, 3, :3] == pytest.approx([4.6, 0.0, -0.024])
    # The next message corrects it.
    match.commands[:] = 0.0
    match.hit[:] = False
    see(match, config, SEES)
    assert match.seen_players[3, 3, X] == pytest.approx(4.1)


def test_fresher_news_of_the_ball_is_believed_only_where_it_contradicts():
    match, _ = scene(KeepawayConfig(view_angle_deg=90.0, quantise=False))
    match.player_age[:3, :3] = 0
    for age, velocity, believed in ((0, 1.0, 0.0), (1, 0.2, 0.0), (1, 1.0, 1.0), (4, 0.2, 0.2)):
        match.seen_ball[:3] = 0.0
        match.ball_age[:3] = 9
        match.ball_age[0] = age
        for mate in (1, 2):
            match.seen_ball[mate, VX] = velocity
            match.ball_age[mate] = 0
        listen(match, 0, 0, 3, RNG)
        assert match.seen_ball[0, VX] == believed, (age, velocity)
