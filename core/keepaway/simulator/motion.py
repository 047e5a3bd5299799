"""Motion of ball and players in one cycle: commands, noise, decay, collisions (server 15.2.2, section by
section).

All kernels work in place on `ball` (x, y, vx, vy) and `players` (one row each: x, y, vx, vy, body, neck),
whose velocities are those after the decay: an object at rest in noise moves by its velocity in the next
cycle.
"""

import math

import numpy as np
from numpy.typing import NDArray

from core.keepaway.pitch import (
    ANGLE,
    BALL_ACCEL_MAX,
    BALL_DECAY,
    BALL_NOISE,
    BALL_SPEED_MAX,
    BODY,
    DASH,
    DASH_RATE,
    INERTIA,
    KICK,
    KICK_DISTANCE,
    KICK_MARGIN,
    KICK_NOISE,
    KICK_RATE,
    KIND,
    MAX_POWER,
    NECK,
    NECK_MAX_DEG,
    NECK_TURN,
    PLAYER_ACCEL_MAX,
    PLAYER_DECAY,
    PLAYER_NOISE,
    PLAYER_RADIUS,
    PLAYER_SPEED_MAX,
    POWER,
    TOUCH_DISTANCE,
    TURN,
    TURN_NOISE,
    VX,
    VY,
    X,
    Y,
)
from core.numerics.arrays import Floats
from core.numerics.compiled import inner_kernel

RADIANS = math.pi / 180.0
DEGREES = 180.0 / math.pi
COLLISION_PASSES = 10
TOUCHING = 1e-9
"""Overlap in square metres that is a rounding error: the two just touch."""
COLLISION_FACTOR = -0.1
"""What a collision leaves of a velocity."""


@inner_kernel
def wrap_deg(angle: float) -> float:
    """Return `angle` (degrees, any turn count) in (-180, 180]."""
    while angle > 180.0:
        angle -= 360.0
    while angle <= -180.0:
        angle += 360.0
    return angle


@inner_kernel
def direction_deg(dx: float, dy: float) -> float:
    """Return the direction of a vector, degrees in (-180, 180]; 0 for the null vector."""
    return math.atan2(dy, dx) * DEGREES


@inner_kernel
def length(dx: float, dy: float) -> float:
    """Return the Euclidean length of a vector."""
    return math.sqrt(dx * dx + dy * dy)


@inner_kernel
def copy_row(row: Floats, out: Floats) -> None:
    """Write one row into another of the same length (assigning rows would make room for a copy of overlapping
    ones).
    """
    for column in range(len(row)):
        out[column] = row[column]


@inner_kernel
def kick_rate(distance: float, angle_deg: float) -> float:
    """Return the acceleration per unit of kick power.

    Args:
        distance: between the centres of player and ball, in [0, KICK_DISTANCE].
        angle_deg: of the ball from the player's body, unsigned, 0..180.
    """
    return KICK_RATE * (1.0 - 0.25 * angle_deg / 180.0 - 0.25 * (distance - TOUCH_DISTANCE) / KICK_MARGIN)


@inner_kernel
def apply_commands(
    ball: Floats,
    players: Floats,
    commands: Floats,
    push: Floats,
    turn_rng: np.random.Generator,
    kick_rng: np.random.Generator,
) -> None:
    """Carry out every player's command; accelerations go to `push`, row 0 the ball, row 1 + i player i.

    A turn takes effect at once. A kick from beyond the kick distance does nothing.
    """
    push[:] = 0.0
    for i in range(players.shape[0]):
        kind = commands[i, KIND]
        if kind == DASH:
            _dash(players[i], commands[i, POWER], push[1 + i])
        elif kind == TURN:
            speed = length(players[i, VX], players[i, VY])
            noise = 1.0 + TURN_NOISE * (2.0 * turn_rng.random() - 1.0)
            players[i, BODY] = wrap_deg(
                players[i, BODY] + noise * commands[i, ANGLE] / (1.0 + INERTIA * speed)
            )
        elif kind == KICK:
            _kick(ball, players[i], commands[i, POWER], commands[i, ANGLE], push[0], kick_rng)
        neck = players[i, NECK] + commands[i, NECK_TURN]
        players[i, NECK] = min(max(neck, -NECK_MAX_DEG), NECK_MAX_DEG)


@inner_kernel
def _dash(player: Floats, power: float, push: Floats) -> None:
    accel = DASH_RATE * power
    push[X] += accel * math.cos(player[BODY] * RADIANS)
    push[Y] += accel * math.sin(player[BODY] * RADIANS)


@inner_kernel
def _kick(
    ball: Floats, player: Floats, power: float, angle: float, push: Floats, rng: np.random.Generator
) -> None:
    dx, dy = ball[X] - player[X], ball[Y] - player[Y]
    distance = length(dx, dy)
    if distance > KICK_DISTANCE:
        return
    off_axis = abs(wrap_deg(direction_deg(dx, dy) - player[BODY]))
    accel = kick_rate(distance, off_axis) * power
    direction = (player[BODY] + angle) * RADIANS
    push[X] += accel * math.cos(direction)
    push[Y] += accel * math.sin(direction)
    # Harder with the ball off the axis, far away, or fast.
    where = 0.5 + 0.25 * (off_axis / 180.0 + (distance - TOUCH_DISTANCE) / KICK_MARGIN)
    how_fast = 0.5 + 0.5 * length(ball[VX], ball[VY]) / (BALL_SPEED_MAX * BALL_DECAY)
    turn = math.pi * (2.0 * rng.random() - 1.0)
    size = rng.random() * KICK_NOISE * (power / MAX_POWER) * (where + how_fast)
    push[X] += size * math.cos(turn)
    push[Y] += size * math.sin(turn)


@inner_kernel
def move_object(
    row: Floats,
    push: Floats,
    accel_max: float,
    speed_max: float,
    noise: float,
    decay: float,
    rng: np.random.Generator,
) -> None:
    """Accelerate, add noise, move and slow down one object (`row` starts with x, y, vx, vy)."""
    accel = length(push[X], push[Y])
    if accel > 0.0:
        if accel > accel_max:
            push[X] *= accel_max / accel
            push[Y] *= accel_max / accel
        row[VX] += push[X]
        row[VY] += push[Y]
        speed = length(row[VX], row[VY])
        if speed > speed_max:
            row[VX] *= speed_max / speed
            row[VY] *= speed_max / speed
    # Two draws whatever the speed, so that a stream's position depends only on the cycle.
    turn = math.pi * (2.0 * rng.random() - 1.0)
    size = rng.random() * noise * length(row[VX], row[VY])
    if size > 0.0:
        row[VX] += size * math.cos(turn)
        row[VY] += size * math.sin(turn)
    row[X] += row[VX]
    row[Y] += row[VY]
    row[VX] *= decay
    row[VY] *= decay


@inner_kernel
def move_all(ball: Floats, players: Floats, push: Floats, rng: np.random.Generator) -> None:
    """Move the ball, then the players in order of their index."""
    move_object(ball, push[0], BALL_ACCEL_MAX, BALL_SPEED_MAX, BALL_NOISE, BALL_DECAY, rng)
    for i in range(players.shape[0]):
        move_object(
            players[i], push[1 + i], PLAYER_ACCEL_MAX, PLAYER_SPEED_MAX, PLAYER_NOISE, PLAYER_DECAY, rng
        )


@inner_kernel
def _overlap(a: Floats, b: Floats, reach: float, moves: Floats, row_a: int, row_b: int) -> bool:
    """Add to `moves` (columns: sum of shifts in x, in y, their number) what parts two overlapping objects."""
    dx, dy = b[X] - a[X], b[Y] - a[Y]
    gap = reach * reach - (dx * dx + dy * dy)
    if gap <= TOUCHING:
        return False
    distance = length(dx, dy)
    if distance < 1e-9:  # on the same spot: part them along x
        dx, dy, distance = 1e-9, 0.0, 1e-9
    half = 0.5 * (reach - distance) / distance
    moves[row_a, 0] -= half * dx
    moves[row_a, 1] -= half * dy
    moves[row_a, 2] += 1.0
    moves[row_b, 0] += half * dx
    moves[row_b, 1] += half * dy
    moves[row_b, 2] += 1.0
    return True


@inner_kernel
def collide(ball: Floats, players: Floats, moves: Floats, hit: NDArray[np.bool_]) -> None:
    """Part overlapping objects; every object that collided keeps -0.1 of its velocity.

    Args:
        ball: (4,), in place.
        players: (n, 6), in place.
        moves: scratch, (n + 1, 3).
        hit: out, (n + 1,): whether ball (0) or player i (1 + i) collided.
    """
    n_players = players.shape[0]
    hit[:] = False
    for _ in range(COLLISION_PASSES):
        found = False
        moves[:] = 0.0
        for i in range(n_players):
            found |= _overlap(ball, players[i], TOUCH_DISTANCE, moves, 0, 1 + i)
            for j in range(i + 1, n_players):
                found |= _overlap(players[i], players[j], 2.0 * PLAYER_RADIUS, moves, 1 + i, 1 + j)
        if not found:
            break
        _shift(ball, moves[0], hit, 0)
        for i in range(n_players):
            _shift(players[i], moves[1 + i], hit, 1 + i)
    if hit[0]:
        ball[VX] *= COLLISION_FACTOR
        ball[VY] *= COLLISION_FACTOR
    for i in range(n_players):
        if hit[1 + i]:
            players[i, VX] *= COLLISION_FACTOR
            players[i, VY] *= COLLISION_FACTOR


@inner_kernel
def _shift(row: Floats, move: Floats, hit: NDArray[np.bool_], index: int) -> None:
    if move[2] > 0.0:
        row[X] += move[0] / move[2]
        row[Y] += move[1] / move[2]
        hit[index] = True
