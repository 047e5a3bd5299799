"""What players expect of the next cycles: noise-free roll-outs, the kick they need, and the policy for
moving.

A player's commands are integers: the reference's players send them with the fraction cut off.
"""

import math

import numpy as np

from core.keepaway.pitch import (
    ANGLE,
    BALL_DECAY,
    BODY,
    DASH,
    DASH_RATE,
    INERTIA,
    KICK,
    KICK_DISTANCE,
    KIND,
    MAX_POWER,
    PLAYER_DECAY,
    PLAYER_SPEED_MAX,
    POWER,
    TURN,
    VX,
    VY,
    X,
    Y,
)
from core.keepaway.simulator.motion import RADIANS, direction_deg, kick_rate, length, wrap_deg
from core.numerics.arrays import Floats
from core.numerics.compiled import inner_kernel

ROLL_OUT_CYCLES = 4
TURN_AT_OFFSET = 0.90 * KICK_DISTANCE
"""The move policy turns when the target lies farther than this from the body's line."""
TURN_BACK_DISTANCE = 2.5


HORIZON = 101
"""Longest prediction in cycles (exclusive)."""
BALL_POWER: Floats = np.array([BALL_DECAY**n for n in range(HORIZON)])
"""What is left of a ball's unit speed after n cycles, shape (HORIZON,)."""
BALL_ROLL: Floats = np.array([(1.0 - BALL_DECAY**n) / (1.0 - BALL_DECAY) for n in range(HORIZON)])
"""How far a ball with unit velocity rolls in n cycles, shape (HORIZON,)."""
PLAYER_ROLL: Floats = np.array([(1.0 - PLAYER_DECAY**n) / (1.0 - PLAYER_DECAY) for n in range(HORIZON)])
"""How far a player with unit velocity rolls in n cycles, shape (HORIZON,)."""
FULL_DASH: Floats = DASH_RATE * MAX_POWER * np.cumsum(np.append(0.0, PLAYER_ROLL[1:]))
"""How far n full dashes take a player from rest, shape (HORIZON,)."""


@inner_kernel
def cut(value: float) -> float:
    """Cut the fraction off, as the players do; what is an integer but for rounding stays that integer."""
    return float(int(value + math.copysign(1e-9, value)))


@inner_kernel
def send_dash(power: float, command: Floats) -> None:
    """Write a dash; power is clipped to +-100 and cut to an integer."""
    command[KIND] = DASH
    command[POWER] = cut(min(max(power, -MAX_POWER), MAX_POWER))


@inner_kernel
def send_turn(angle: float, speed: float, command: Floats) -> None:
    """Write the turn that turns a body moving at `speed` by `angle` degrees, as far as that is possible."""
    moment = wrap_deg(angle) * (1.0 + INERTIA * speed)
    command[KIND] = TURN
    command[ANGLE] = cut(min(max(moment, -180.0), 180.0))


@inner_kernel
def send_kick(power: float, global_direction: float, body: float, command: Floats) -> None:
    """Write a kick in a global direction; power is clipped to 0..100."""
    command[KIND] = KICK
    command[POWER] = cut(min(max(power, 0.0), MAX_POWER))
    command[ANGLE] = cut(wrap_deg(global_direction - body))


@inner_kernel
def own_kick_rate(me: Floats, ball: Floats) -> float:
    """Return the acceleration per unit of power with the ball where it is."""
    dx, dy = ball[X] - me[X], ball[Y] - me[Y]
    off_axis = abs(wrap_deg(direction_deg(dx, dy) - me[BODY]))
    return kick_rate(length(dx, dy), off_axis)


@inner_kernel
def turn_body_to(me: Floats, x: float, y: float, cycles: int, command: Floats) -> None:
    """Turn towards a point, seen from where the player will have rolled to after `cycles`."""
    roll = PLAYER_ROLL[cycles]
    dx, dy = x - me[X] - roll * me[VX], y - me[Y] - roll * me[VY]
    send_turn(direction_deg(dx, dy) - me[BODY], length(me[VX], me[VY]), command)


@inner_kernel
def dash_power(forward: float, axial_speed: float, cycles: int) -> float:
    """Return the power that covers `forward` metres along the body in `cycles` >= 1 cycles of one dash."""
    speed = forward / float(PLAYER_ROLL[max(cycles, 1)])
    speed = min(max(speed, -PLAYER_SPEED_MAX), PLAYER_SPEED_MAX)
    return min(max((speed - axial_speed) / DASH_RATE, -MAX_POWER), MAX_POWER)


@inner_kernel
def step_meant(me: Floats, command: Floats) -> tuple[float, float]:
    """Return how far a command takes a player where nobody stands in its way, without noise, metres along x
    and y.
    """
    step_x, step_y = me[VX], me[VY]
    if command[KIND] == DASH:
        accel = DASH_RATE * command[POWER]
        step_x += accel * math.cos(me[BODY] * RADIANS)
        step_y += accel * math.sin(me[BODY] * RADIANS)
        speed = length(step_x, step_y)
        if speed > PLAYER_SPEED_MAX:
            step_x *= PLAYER_SPEED_MAX / speed
            step_y *= PLAYER_SPEED_MAX / speed
    return step_x, step_y


@inner_kernel
def off_course(dx: float, dy: float, distance: float, cos_body: float, sin_body: float) -> bool:
    """Return whether the move policy turns.

    Args:
        dx: x from where the player rolls to, to the target.
        dy: y of the same.
        distance: from the player to the target, metres.
        cos_body: cosine of the body direction.
        sin_body: sine of the body direction.
    """
    slack = TURN_AT_OFFSET
    if distance > 20.0:
        slack = 3.0 * KICK_DISTANCE
    elif distance > 10.0:
        slack = 2.0 * KICK_DISTANCE
    if abs(cos_body * dy - sin_body * dx) > slack:
        return True
    return cos_body * dx + sin_body * dy < 0.0 and distance > TURN_BACK_DISTANCE


@inner_kernel
def move_command(me: Floats, tx: float, ty: float, cycles: int, command: Floats) -> None:
    """Write the move policy's command towards (tx, ty) with `cycles` >= 1 cycles left."""
    x, y, vx, vy, body = me[X], me[Y], me[VX], me[VY], me[BODY]
    roll = PLAYER_ROLL[min(cycles, ROLL_OUT_CYCLES)]
    cos_body, sin_body = math.cos(body * RADIANS), math.sin(body * RADIANS)
    dx, dy = tx - x - roll * vx, ty - y - roll * vy
    if off_course(dx, dy, length(tx - x, ty - y), cos_body, sin_body):
        send_turn(direction_deg(dx, dy) - body, length(vx, vy), command)
    else:
        forward = cos_body * (tx - x) + sin_body * (ty - y)
        send_dash(dash_power(forward, cos_body * vx + sin_body * vy, cycles), command)


@inner_kernel
def _too_far(dx: float, dy: float, speed: float, cycles: int, within: float) -> bool:
    """Return whether not even full dashes in the right direction cover (dx, dy) but for `within`."""
    reach = within + FULL_DASH[cycles] + PLAYER_ROLL[cycles] * speed + 1e-9
    return bool(dx * dx + dy * dy > reach * reach)


@inner_kernel
def can_arrive(me: Floats, tx: float, ty: float, cycles: int, within: float) -> bool:
    """Return whether `cycles` cycles of the move policy, without noise, end less than `within` from (tx, ty).

    Gives up as soon as full dashes in the right direction could not make it: the same answer, much earlier.
    """
    x, y, vx, vy, body = me[X], me[Y], me[VX], me[VY], me[BODY]
    speed = length(vx, vy)
    if _too_far(tx - x, ty - y, speed, cycles, within):
        return False
    cos_body, sin_body = math.cos(body * RADIANS), math.sin(body * RADIANS)
    for left in range(cycles, 0, -1):
        roll = PLAYER_ROLL[min(left, ROLL_OUT_CYCLES)]
        dx, dy = tx - x - roll * vx, ty - y - roll * vy
        if off_course(dx, dy, length(tx - x, ty - y), cos_body, sin_body):
            if _too_far(tx - x - vx, ty - y - vy, PLAYER_DECAY * speed, left - 1, within):
                return False
            inertia = 1.0 + INERTIA * speed
            turn = wrap_deg(direction_deg(dx, dy) - body)
            body = wrap_deg(body + min(max(turn * inertia, -180.0), 180.0) / inertia)
            cos_body, sin_body = math.cos(body * RADIANS), math.sin(body * RADIANS)
        else:
            forward = cos_body * (tx - x) + sin_body * (ty - y)
            accel = DASH_RATE * dash_power(forward, cos_body * vx + sin_body * vy, left)
            vx += accel * cos_body
            vy += accel * sin_body
            speed = length(vx, vy)
            if speed > PLAYER_SPEED_MAX:
                vx, vy = vx * PLAYER_SPEED_MAX / speed, vy * PLAYER_SPEED_MAX / speed
        x, y = x + vx, y + vy
        vx, vy = vx * PLAYER_DECAY, vy * PLAYER_DECAY
        speed = length(vx, vy)
        if _too_far(tx - x, ty - y, speed, left - 1, within):
            return False
    return length(tx - x, ty - y) < within
