"""Skills of a player that can kick: hold the ball, pass it, and the small kicks both are made of."""

import math

from core.keepaway.pitch import (
    ANGLE,
    BALL_ACCEL_MAX,
    BALL_DECAY,
    BALL_SPEED_MAX,
    BODY,
    KICK_DISTANCE,
    KICK_MARGIN,
    KICK_RATE,
    MAX_POWER,
    POWER,
    TOUCH_DISTANCE,
    VX,
    VY,
    X,
    Y,
)
from core.keepaway.simulator.motion import DEGREES, RADIANS, direction_deg, length, wrap_deg
from core.keepaway.simulator.prediction import (
    own_kick_rate,
    send_kick,
    turn_body_to,
)
from core.numerics.arrays import Bools, Floats
from core.numerics.compiled import inner_kernel

PASS_END_SPEED = 1.2
"""Wanted speed of a pass on arrival, metres per cycle."""
WHEN_TO_KICK = 0.85
DANGER_DISTANCE = 5.0
KEEPER_HOLD_RATIO = 0.7
TAKER_HOLD_RATIO = 0.3
REPOSITION_RATIO = 0.16
HURRY_DISTANCE = 2.0
"""A taker this near to the ball makes a passer content with less than the wanted speed."""
HOLD_FACING_X = 52.5
"""A holder with the ball in place faces (+-52.5, 0), the opponents' goal of the full pitch."""


@inner_kernel
def nearest_to(x: float, y: float, players: Floats, known: Bools, first: int, last: int) -> tuple[int, float]:
    """Return (index, distance) of the known player in [first, last) nearest to a point; (-1, inf) for
    none.
    """
    best, best_distance = -1, math.inf
    for j in range(first, last):
        if known[j]:
            distance = length(players[j, X] - x, players[j, Y] - y)
            if distance < best_distance:
                best, best_distance = j, distance
    return best, best_distance


@inner_kernel
def freeze_ball(me: Floats, ball: Floats, command: Floats) -> None:
    """Stop the ball, or drive it to a point nearer to me when it would stop out of safe reach.

    Where it would stop follows from the kick as it is sent, an integer power and angle. Where the drive is
    too much for one kick, what moves the ball past the point is taken away first, as in a pass.
    """
    rate = own_kick_rate(me, ball)
    next_x, next_y = me[X] + me[VX], me[Y] + me[VY]
    send_kick(length(ball[VX], ball[VY]) / rate, direction_deg(-ball[VX], -ball[VY]), me[BODY], command)
    way = (me[BODY] + command[ANGLE]) * RADIANS
    stop_x = ball[X] + ball[VX] + command[POWER] * rate * math.cos(way)
    stop_y = ball[Y] + ball[VY] + command[POWER] * rate * math.sin(way)
    if length(stop_x - next_x, stop_y - next_y) < 0.8 * KICK_DISTANCE:
        return
    dx, dy = ball[X] - next_x, ball[Y] - next_y
    distance = length(dx, dy)
    reach = min(0.7 * KICK_DISTANCE, distance - 0.1) / distance
    step_x, step_y = next_x + reach * dx - ball[X], next_y + reach * dy - ball[Y]
    push_x, push_y = step_x - ball[VX], step_y - ball[VY]
    power, push = length(push_x, push_y) / rate, direction_deg(push_x, push_y)
    if power > MAX_POWER:
        push = capped_direction(ball, direction_deg(step_x, step_y), MAX_POWER * rate)
    send_kick(power, push, me[BODY], command)


@inner_kernel
def kick_close(me: Floats, ball: Floats, relative: float, ratio: float, command: Floats) -> None:
    """Bring the ball next cycle to `relative` degrees off my body at TOUCH_DISTANCE + ratio * KICK_MARGIN."""
    reach = TOUCH_DISTANCE + ratio * KICK_MARGIN
    direction = (me[BODY] + relative) * RADIANS
    wish_x = me[X] + me[VX] + reach * math.cos(direction) - ball[X]
    wish_y = me[Y] + me[VY] + reach * math.sin(direction) - ball[Y]
    push_x, push_y = wish_x - ball[VX], wish_y - ball[VY]
    power = length(push_x, push_y) / own_kick_rate(me, ball)
    if power > MAX_POWER and length(ball[VX], ball[VY]) > 0.1:
        freeze_ball(me, ball, command)
    else:
        send_kick(power, direction_deg(push_x, push_y), me[BODY], command)


@inner_kernel
def hold_ball(
    me: Floats,
    ball: Floats,
    players: Floats,
    known: Bools,
    first_opponent: int,
    last_opponent: int,
    ratio: float,
    facing: float,
    command: Floats,
) -> None:
    """HoldBall: keep the ball on the side away from the nearest opponent; turn upfield when it is there."""
    relative = 0.0
    rival, distance = nearest_to(ball[X], ball[Y], players, known, first_opponent, last_opponent)
    if rival >= 0 and distance < DANGER_DISTANCE:
        away = direction_deg(me[X] - players[rival, X], me[Y] - players[rival, Y])
        side = -45.0 if wrap_deg(players[rival, BODY] - away) >= 0.0 else 45.0
        relative = wrap_deg(away + side - me[BODY])
    # The reference adds the relative angle to the team's direction of play, not to the body's; kept, since
    # holding depends on it.
    spot = (facing + relative) * RADIANS
    spot_x = me[X] + ratio * math.cos(spot)
    spot_y = me[Y] + ratio * math.sin(spot)
    if length(ball[X] - spot_x, ball[Y] - spot_y) < 0.3:
        gap = length(
            ball[X] + ball[VX] - me[X] - me[VX],
            ball[Y] + ball[VY] - me[Y] - me[VY],
        )
        if gap < WHEN_TO_KICK * KICK_DISTANCE:
            goal_x = HOLD_FACING_X if facing == 0.0 else -HOLD_FACING_X
            turn_body_to(me, goal_x, 0.0, 1, command)
            return
    kick_close(me, ball, relative, ratio, command)


@inner_kernel
def pass_speed(distance: float) -> float:
    """Return the speed a pass starts with, so that about PASS_END_SPEED is left after `distance` metres."""
    growth = 1.0 / BALL_DECAY
    cycles = float(round(math.log(1.0 + distance * (growth - 1.0) / PASS_END_SPEED) / math.log(growth)))
    return PASS_END_SPEED * float(growth**cycles)


@inner_kernel
def capped_direction(ball: Floats, direction: float, accel: float) -> float:
    """Return where to push with `accel` so that the ball, moving already, leaves in `direction` (degrees)."""
    side = float(ball[VY]) * math.cos(direction * RADIANS) - float(ball[VX]) * math.sin(direction * RADIANS)
    if accel <= abs(side):
        return direction - (90.0 if side > 0.0 else -90.0)
    return direction - math.asin(side / accel) * DEGREES


@inner_kernel
def _clear_of_body(me: Floats, ball: Floats, direction: float, speed: float) -> float:
    """Return a speed with which the ball, next cycle, does not lie in my own body."""
    cos_way, sin_way = math.cos(direction * RADIANS), math.sin(direction * RADIANS)
    x, y = ball[X] + speed * cos_way, ball[Y] + speed * sin_way
    if length(me[X] + me[VX] - x, me[Y] + me[VY] - y) >= TOUCH_DISTANCE:
        return speed
    nearest = abs(cos_way * float(me[X] - ball[X]) + sin_way * float(me[Y] - ball[Y]))
    return nearest - TOUCH_DISTANCE if speed < nearest else nearest + TOUCH_DISTANCE


@inner_kernel
def pass_ball(me: Floats, ball: Floats, tx: float, ty: float, rival_distance: float, command: Floats) -> None:
    """PassBall: kick towards (tx, ty), or bring the ball into a place from which it can be kicked.

    Args:
        me: own row.
        ball: as believed.
        tx: x of the receiver as believed.
        ty: y of the receiver as believed.
        rival_distance: of the nearest opponent to the ball.
        command: out.
    """
    dx, dy = tx - ball[X], ty - ball[Y]
    direction = direction_deg(dx, dy)
    speed = _clear_of_body(me, ball, direction, pass_speed(length(dx, dy)))
    rate = own_kick_rate(me, ball)
    strongest = MAX_POWER * rate
    if speed > BALL_SPEED_MAX:
        way = capped_direction(ball, direction, strongest)
        vx = ball[VX] + strongest * math.cos(way * RADIANS)
        vy = ball[VY] + strongest * math.sin(way * RADIANS)
        if length(vx, vy) > WHEN_TO_KICK * BALL_ACCEL_MAX:
            send_kick(MAX_POWER, way, me[BODY], command)
        elif rate > WHEN_TO_KICK * KICK_RATE:
            freeze_ball(me, ball, command)
        else:
            kick_close(me, ball, 0.0, REPOSITION_RATIO, command)
        return
    push_x = speed * math.cos(direction * RADIANS) - ball[VX]
    push_y = speed * math.sin(direction * RADIANS) - ball[VY]
    power = length(push_x, push_y) / rate
    if power <= 1.05 * MAX_POWER or (power <= 1.30 * MAX_POWER and rival_distance < HURRY_DISTANCE):
        way = direction_deg(push_x, push_y)
        if power > MAX_POWER:
            way = capped_direction(ball, direction, strongest)
        send_kick(power, way, me[BODY], command)
    else:
        kick_close(me, ball, 0.0, REPOSITION_RATIO, command)
