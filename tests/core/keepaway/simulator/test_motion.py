"""Bodies in motion, by hand."""

import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from core.keepaway.pitch import BODY, DASH, KICK, TURN, VX, X, Y
from core.keepaway.simulator.motion import apply_commands, collide, kick_rate, move_all, wrap_deg
from core.numerics.streams import stream

TURN_RNG, KICK_RNG = stream(1, "turn"), stream(1, "kick")


def scene(*players):
    """Return ball at rest at the origin, and players (x, y, body)."""
    rows = np.zeros((len(players), 6))
    for row, (x, y, body) in zip(rows, players, strict=True):
        row[X], row[Y], row[BODY] = x, y, body
    n = len(players)
    return np.zeros(4), rows, np.zeros((n, 4)), np.zeros((n + 1, 2))


def obey(ball, players, commands, push):
    apply_commands(ball, players, commands, push, TURN_RNG, KICK_RNG)


def test_a_full_dash_accelerates_by_0_6_along_the_body():
    ball, players, commands, push = scene((5, 0, 90))
    commands[0, :2] = DASH, 100
    obey(ball, players, commands, push)
    np.testing.assert_allclose(push, [[0, 0], [0, 0.6]], atol=1e-12)


def test_a_backward_dash_is_as_strong():
    ball, players, commands, push = scene((5, 0, 0))
    commands[0, :2] = DASH, -100
    obey(ball, players, commands, push)
    assert push[1, X] == pytest.approx(-0.6)


def test_a_moving_player_turns_less_by_its_inertia():
    # Speed 0.4: 1 + 5 * 0.4 = 3, so a moment of 90 turns by 30 degrees, give or take 10 %.
    ball, players, commands, push = scene((5, 0, 0))
    players[0, VX] = 0.4
    commands[0, [0, 2]] = TURN, 90
    obey(ball, players, commands, push)
    assert 27 <= players[0, BODY] <= 33


def test_a_kick_is_strongest_straight_ahead_and_touching():
    assert kick_rate(0.385, 0.0) == pytest.approx(0.027)
    assert kick_rate(1.085, 0.0) == pytest.approx(0.027 * 0.75)
    assert kick_rate(1.085, 180.0) == pytest.approx(0.027 * 0.5)


def test_a_kick_from_beyond_reach_does_nothing():
    ball, players, commands, push = scene((1.09, 0, 180))
    commands[0, :2] = KICK, 100
    obey(ball, players, commands, push)
    assert not push.any()


def test_a_kick_pushes_the_ball_in_its_direction_within_the_noise():
    ball, players, commands, push = scene((-0.385, 0, 0))
    commands[0, :3] = KICK, 50, 90
    obey(ball, players, commands, push)
    # 0.027 * 50 to the left; noise of at most 0.1 * 0.5 * (0.5 + 0.5).
    assert math.hypot(push[0, X], push[0, Y] - 1.35) <= 0.05 + 1e-12


def test_kicks_of_two_players_add_up():
    ball, players, commands, push = scene((-0.385, 0, 0), (0.385, 0, 180))
    commands[:, :2] = KICK, 50
    obey(ball, players, commands, push)
    assert np.hypot(*push[0]) <= 0.1 + 1e-12


def test_the_ball_rolls_on_with_0_94_of_its_speed():
    ball, players, _, push = scene((5, 5, 0))
    ball[VX] = 1.0
    move_all(ball, players, push, stream(1, "movement"))
    # The noise has at most 5 % of the speed and stays in the velocity.
    assert abs(ball[X] - 1.0) <= 0.05
    np.testing.assert_allclose(ball[2:], 0.94 * ball[:2], atol=1e-12)


def test_a_player_keeps_0_4_of_its_speed():
    ball, players, _, push = scene((0, 5, 0))
    push[1, X] = 0.6
    move_all(ball, players, push, stream(1, "movement"))
    assert abs(players[0, X] - 0.6) <= 0.06
    np.testing.assert_allclose(players[0, VX:BODY], 0.4 * (players[0, :2] - [0, 5]), atol=1e-12)


def test_a_body_at_rest_stays():
    ball, players, _, push = scene((1, 2, 3))
    move_all(ball, players, push, stream(1, "movement"))
    assert not ball.any()
    assert players[0].tolist() == [1, 2, 0, 0, 3, 0]


def run_into(ball, players):
    n = len(players)
    hit = np.zeros(n + 1, bool)
    collide(ball, players, np.zeros((n + 1, 3)), hit)
    return hit.tolist()


def test_a_collision_parts_two_bodies_evenly_and_throws_them_back():
    ball, players, *_ = scene((5, 0, 0), (5.4, 0, 0))
    players[:, VX] = 0.3, -0.2
    assert run_into(ball, players) == [False, True, True]
    np.testing.assert_allclose(players[:, X], [4.9, 5.5])
    np.testing.assert_allclose(players[:, VX], [-0.03, 0.02])


def test_bodies_that_just_touch_do_not_collide():
    ball, players, *_ = scene((0.385, 0, 0))
    assert run_into(ball, players) == [False, False]


@given(st.lists(st.tuples(st.floats(-1, 1), st.floats(-1, 1), st.just(0.0)), min_size=1, max_size=3))
def test_parting_keeps_the_centre_of_two_bodies(places):
    ball, players, *_ = scene(*places[:1])
    ball[:2] = 0.05, 0.02
    before = ball[:2] + players[0, :2]
    if run_into(ball, players)[0]:
        np.testing.assert_allclose(ball[:2] + players[0, :2], before, atol=1e-9)
        assert np.hypot(*(ball[:2] - players[0, :2])) == pytest.approx(0.385)


@given(st.floats(-2000, 2000))
def test_a_direction_is_wrapped_to_one_turn(angle):
    wrapped = wrap_deg(angle)
    assert -180 < wrapped <= 180
    assert math.cos(math.radians(wrapped)) == pytest.approx(math.cos(math.radians(angle)), abs=1e-9)
