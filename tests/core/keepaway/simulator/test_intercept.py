"""Who goes to the ball and how, by hand: rules that were read from the reference's logs."""

import numpy as np
import pytest

from core.keepaway.pitch import BODY, DASH, KIND, NECK_TURN, POWER, VX, X, Y
from core.keepaway.simulator.arrivals import fastest_to_ball, keeper_to_go
from core.keepaway.simulator.intercept import close_intercept, meeting_cycle
from core.keepaway.simulator.match import GET_OPEN, GO_TO_BALL, HOLD_BALL
from core.keepaway.simulator.options import turn_neck

AT_REST = np.zeros(4)
EVERYBODY = np.ones(5, np.bool_)
HURRIED = 1.0


def players(*places):
    """Return players at rest at (x, y), facing the origin."""
    rows = np.zeros((len(places), 6))
    for row, (x, y) in zip(rows, places, strict=True):
        row[X], row[Y], row[BODY] = x, y, np.degrees(np.arctan2(-y, -x))
    return rows


def runner(body, facing):
    """Return the command of a hurried player at full speed, 1.15 m from a resting ball that it faces."""
    me, command = np.zeros(6), np.zeros(4)
    direction = np.radians(body)
    me[:2] = -1.15 * np.cos(direction), -1.15 * np.sin(direction)
    me[2:4] = 0.4 * np.cos(direction), 0.4 * np.sin(direction)
    me[BODY] = body
    assert close_intercept(me, AT_REST, HURRIED, facing, command)
    return command


@pytest.mark.parametrize(("body", "facing"), [(30.0, 0.0), (150.0, 180.0), (-100.0, 180.0)])
def test_a_hurried_player_who_runs_upfield_runs_into_the_ball(body, facing):
    command = runner(body, facing)
    assert command[KIND] == DASH
    assert command[POWER] == 100  # 1.15 + 0.50 m would need 208


@pytest.mark.parametrize(("body", "facing"), [(150.0, 0.0), (30.0, 180.0), (-80.0, 180.0)])
def test_a_hurried_player_who_runs_back_stops_short_of_the_ball(body, facing):
    # 1.15 m less the circle's radius of 0.385 + 0.7 / 6 = 0.5017: 0.6483 m, 0.4 of them by its own speed.
    command = runner(body, facing)
    assert command[KIND] == DASH
    assert command[POWER] == 41


@pytest.mark.parametrize(
    ("ball_x", "last_x", "cycles"),
    [(6.0, None, 2), (6.0, 9.0, 2), (6.0, 2.1, 3), (5.7, 1.8, 2), (6.15, 2.3, 2)],
    ids=["no point before", "a point far away", "good, not close", "close enough", "not good enough"],
)
def test_a_good_meeting_is_left_for_a_close_one_a_cycle_later(ball_x, last_x, cycles):
    # In two cycles the ball rolls 1.94 * 2 = 3.88 m, and two full dashes take the player 0.6 + 0.84 = 1.44 m
    # towards it: 0.68 m are left from 6 m, 0.38 from 5.7 m and 0.83 from 6.15 m. Good is less than 0.760 m,
    # close less than 0.543 m; in three it is there.
    ball = np.array([ball_x, 0.0, -2.0, 0.0])
    meet = np.array([last_x or 0.0, 0.0, -2.0 if last_x is None else 4.0])
    assert meeting_cycle(np.zeros(6), ball, meet, 5) == cycles


def test_of_equally_fast_keepers_the_last_goes():
    both = players((-5, 0), (5, 0), (0, 19), (0, 15), (0, 17))
    assert fastest_to_ball(AT_REST, both, EVERYBODY, 0, 3, 30)[0] == 1
    assert keeper_to_go(AT_REST, both, EVERYBODY, 3) == 1


def test_where_a_taker_comes_first_the_keeper_nearest_to_that_place_goes():
    # The ball rolls from keeper 0 past the takers to keeper 1, who waits for it far away.
    ball = np.array([0.0, 0.0, 1.5, 0.0])
    alone = players((-2.0, 0), (14, 0), (-9, 9), (-9, -9), (-8, -9))
    assert keeper_to_go(ball, alone, EVERYBODY, 3) == 1
    with_taker = players((-2.0, 0), (14, 0), (-9, 9), (3.5, 0.0), (-8, -9))
    assert keeper_to_go(ball, with_taker, EVERYBODY, 3) == 0
    unknown = EVERYBODY.copy()
    unknown[3] = False
    assert keeper_to_go(ball, with_taker, unknown, 3) == 1


def test_nobody_goes_to_a_ball_that_nobody_can_reach():
    ball = np.array([0.0, 0.0, 2.8, 0.0])
    behind = players((-9, 9), (-9, -9), (-9, 0), (-8, 9), (-8, -9))
    assert keeper_to_go(ball, behind, EVERYBODY, 3) == -1


def test_the_neck_turns_from_where_the_player_will_be_to_where_the_ball_will_be():
    me = np.array([0.0, 0.0, 0.0, 0.0, 0.0, 0.0])
    ball = np.array([4.0, 0.0, 0.0, 4.0])
    command = np.array([DASH, 0.0, 0.0, 0.0])
    turn_neck(command, GO_TO_BALL, ball, me)
    assert command[NECK_TURN] == 45
    me[VX] = 1.0  # a metre on, the ball lies at (3, 4) from there: 53.1 degrees, cut
    command[NECK_TURN] = 0.0
    turn_neck(command, GO_TO_BALL, ball, me)
    assert command[NECK_TURN] == 53


def test_who_gets_open_looks_at_the_centre_and_who_has_the_ball_keeps_its_neck():
    me = np.array([-5.0, -5.0, 0.0, 0.0, 0.0, 0.0])
    ball = np.array([-6.0, -5.0, 0.0, 0.0])
    for option, turned in ((GET_OPEN, 45), (HOLD_BALL, 0)):
        command = np.zeros(4)
        turn_neck(command, option, ball, me)
        assert command[NECK_TURN] == turned
