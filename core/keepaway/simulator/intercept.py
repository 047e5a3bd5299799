"""Going to the ball: where to meet it, and what to do this cycle."""

import math

from core.keepaway.pitch import (
    BODY,
    DASH_RATE,
    INERTIA,
    KICK_DISTANCE,
    KICK_MARGIN,
    PLAYER_SPEED_MAX,
    TOUCH_DISTANCE,
    VX,
    VY,
    X,
    Y,
)
from core.keepaway.simulator.arrivals import LONGEST_INTERCEPT
from core.keepaway.simulator.motion import RADIANS, length, wrap_deg
from core.keepaway.simulator.prediction import (
    BALL_POWER,
    BALL_ROLL,
    HORIZON,
    PLAYER_ROLL,
    ROLL_OUT_CYCLES,
    can_arrive,
    dash_power,
    move_command,
    send_dash,
    send_turn,
)
from core.numerics.arrays import Floats
from core.numerics.compiled import inner_kernel

NEVER = HORIZON - 1
"""A player that cannot meet the ball in time goes to where it will come to rest."""
CLOSE_CYCLES = 3
"""Interceptions sooner than this use the close routine."""
QUIET_DISTANCE = 3.0
"""With no opponent nearer than this, a player takes its time."""
SAFE_DISTANCE = 0.8 * KICK_DISTANCE
NEARLY_TURNED = 30.0
NO_NEED_TO_MOVE = 0.5

# A player's memory of where it last meant to meet the ball.
MEET_X = 0
MEET_Y = 1
MEET_CYCLE = 2
"""Cycle of that decision; negative for none."""
MEET_COLUMNS = 3
WORSE_CYCLES = 2
SURE_DISTANCE = 0.70 * KICK_DISTANCE
CLOSE_DISTANCE = 0.50 * KICK_DISTANCE
MEET_STEP = 0.6
"""The old point is kept only while the ball moves faster than this at the meeting."""


@inner_kernel
def meeting_cycle(me: Floats, ball: Floats, meet: Floats, now: int) -> int:
    """Return in how many cycles to meet the ball; -1 where it cannot be met.

    The first cycle at which the simulated player has the ball in reach, unless the point of the last cycle is
    still good and not more than two cycles worse. A point that was good is left for the next one where only
    that one has the ball close to the body. (Read from the logs: 243 of 245 cycles in which the two differ.)
    """
    speed = length(ball[VX], ball[VY])
    first = -1
    for n in range(LONGEST_INTERCEPT + 1):
        bx = ball[X] + BALL_ROLL[n] * ball[VX]
        by = ball[Y] + BALL_ROLL[n] * ball[VY]
        if can_arrive(me, bx, by, n, KICK_DISTANCE):
            first = n
            break
    if first < 0 or meet[MEET_CYCLE] != now - 1:
        return first
    for n in range(first, min(first + WORSE_CYCLES, LONGEST_INTERCEPT) + 1):
        if speed * BALL_POWER[n] <= MEET_STEP:
            break
        bx = ball[X] + BALL_ROLL[n] * ball[VX]
        by = ball[Y] + BALL_ROLL[n] * ball[VY]
        if length(bx - meet[MEET_X], by - meet[MEET_Y]) < 1.0 and can_arrive(me, bx, by, n, SURE_DISTANCE):
            return n + _is_left(me, ball, n)
    return first


@inner_kernel
def _is_left(me: Floats, ball: Floats, n: int) -> bool:
    """Return whether only the meeting after that in n cycles has the ball close to the body."""
    if n == LONGEST_INTERCEPT:
        return False
    bx, by = ball[X] + BALL_ROLL[n] * ball[VX], ball[Y] + BALL_ROLL[n] * ball[VY]
    if can_arrive(me, bx, by, n, CLOSE_DISTANCE):
        return False
    bx, by = ball[X] + BALL_ROLL[n + 1] * ball[VX], ball[Y] + BALL_ROLL[n + 1] * ball[VY]
    return can_arrive(me, bx, by, n + 1, CLOSE_DISTANCE)


@inner_kernel
def go_to_ball(
    me: Floats, ball: Floats, meet: Floats, now: int, rival_distance: float, facing: float, command: Floats
) -> None:
    """GoToBall: intercept a moving ball, or walk to one at rest.

    Args:
        me: own row.
        ball: as believed.
        meet: memory of the last meeting point, in place.
        now: cycle.
        rival_distance: of the nearest opponent to me.
        facing: direction the team plays in, degrees: a player with time turns that way.
        command: out.
    """
    n = meeting_cycle(me, ball, meet, now)
    if n < 0:
        n = NEVER
    bx = ball[X] + BALL_ROLL[n] * ball[VX]
    by = ball[Y] + BALL_ROLL[n] * ball[VY]
    meet[MEET_X], meet[MEET_Y], meet[MEET_CYCLE] = bx, by, now
    if n < CLOSE_CYCLES and close_intercept(me, ball, rival_distance, facing, command):
        return
    roll = PLAYER_ROLL[min(n, ROLL_OUT_CYCLES)]
    if length(me[X] + roll * me[VX] - bx, me[Y] + roll * me[VY] - by) < NO_NEED_TO_MOVE:
        send_turn(facing - me[BODY], length(me[VX], me[VY]), command)
        return
    move_command(me, bx, by, n, command)


@inner_kernel
def gap_after(me: Floats, ball: Floats, n: int) -> float:
    """Return the distance between player and ball when both roll on for n cycles."""
    dx = ball[X] + BALL_ROLL[n] * ball[VX] - me[X] - PLAYER_ROLL[n] * me[VX]
    dy = ball[Y] + BALL_ROLL[n] * ball[VY] - me[Y] - PLAYER_ROLL[n] * me[VY]
    return length(dx, dy)


@inner_kernel
def close_intercept(me: Floats, ball: Floats, rival_distance: float, facing: float, command: Floats) -> bool:
    """Have the ball in reach within two cycles: by a turn where it comes by itself, else by one dash.

    With time, in this order: turn where the ball comes by itself; run into the ball on purpose, which stops
    it; stop and wait for it. Hurried, dash.

    Returns:
        False where nothing works; `command` is untouched then.
    """
    speed = length(me[VX], me[VY])
    off = wrap_deg(facing - me[BODY])
    next_gap, comes = gap_after(me, ball, 1), gap_after(me, ball, 2) < SAFE_DISTANCE
    done = False
    if rival_distance > QUIET_DISTANCE:
        turned = abs(off) - 180.0 / (1.0 + INERTIA * speed) < NEARLY_TURNED
        if comes or next_gap < TOUCH_DISTANCE or (next_gap < SAFE_DISTANCE and turned):
            send_turn(off, speed, command)
            return True
        done = _run_into(me, ball, command) or _stop_for(me, ball, command)
        comes = next_gap < SAFE_DISTANCE
        if not done and comes:
            send_turn(off, speed, command)
            return True
    done = done or _one_dash(me, ball, facing, command)
    if not done and comes:
        send_turn(off, speed, command)
    return done or comes


@inner_kernel
def _axial(me: Floats, ball: Floats, n: int) -> tuple[float, float, float]:
    """Return where the ball will be after n cycles, along the body's axis and across it, and the axial
    speed.
    """
    dx, dy = ball[X] + BALL_ROLL[n] * ball[VX] - me[X], ball[Y] + BALL_ROLL[n] * ball[VY] - me[Y]
    cos_body, sin_body = math.cos(me[BODY] * RADIANS), math.sin(me[BODY] * RADIANS)
    axial_speed = cos_body * me[VX] + sin_body * me[VY]
    return cos_body * dx + sin_body * dy, cos_body * dy - sin_body * dx, axial_speed


@inner_kernel
def _gap_after_dash(me: Floats, ball: Floats, power: float) -> float:
    accel = DASH_RATE * power
    dx = ball[X] + ball[VX] - me[X] - me[VX] - accel * math.cos(me[BODY] * RADIANS)
    dy = ball[Y] + ball[VY] - me[Y] - me[VY] - accel * math.sin(me[BODY] * RADIANS)
    return length(dx, dy)


@inner_kernel
def _run_into(me: Floats, ball: Floats, command: Floats) -> bool:
    """Dash so that the ball hits the body in the next cycle, where one dash can do that."""
    reach = length(ball[VX], ball[VY]) + PLAYER_SPEED_MAX
    if length(ball[X] - me[X], ball[Y] - me[Y]) > reach:
        return False
    forward, _, axial_speed = _axial(me, ball, 1)
    power = dash_power(forward, axial_speed, 1)
    if _gap_after_dash(me, ball, power) >= TOUCH_DISTANCE:
        return False
    send_dash(power, command)
    return True


@inner_kernel
def _stop_for(me: Floats, ball: Floats, command: Floats) -> bool:
    """Stop where the ball will come near enough in two cycles."""
    dx, dy = ball[X] + BALL_ROLL[2] * ball[VX] - me[X], ball[Y] + BALL_ROLL[2] * ball[VY] - me[Y]
    if length(dx, dy) >= SAFE_DISTANCE:
        return False
    send_dash(dash_power(0.0, _axial(me, ball, 1)[2], 1), command)
    return True


@inner_kernel
def _one_dash(me: Floats, ball: Floats, facing: float, command: Floats) -> bool:
    """Dash to where the body's line meets a circle around the ball, where that brings the ball into reach.

    Of the two points the one farther ahead in the direction of play, on this side of the ball or behind it: a
    player who runs the way its team plays runs into the ball, one who runs back stops short of it. (Read from
    the logs: 170 of 171.)
    """
    forward, offset, axial_speed = _axial(me, ball, 1)
    radius = TOUCH_DISTANCE + KICK_MARGIN / 6.0
    if abs(offset) < radius:
        half = math.sqrt(radius * radius - offset * offset)
        upfield = abs(wrap_deg(me[BODY] - facing)) < 90.0
        forward = forward + half if upfield else forward - half
    power = dash_power(forward, axial_speed, 1)
    if _gap_after_dash(me, ball, power) >= 0.95 * KICK_DISTANCE:
        return False
    send_dash(power, command)
    return True
