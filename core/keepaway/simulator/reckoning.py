"""Dead reckoning: what a player believes of a cycle in which it sees nothing - mostly soccer habits."""

import math

from core.keepaway.pitch import (
    ANGLE,
    BALL_ACCEL_MAX,
    BALL_DECAY,
    BALL_SPEED_MAX,
    BODY,
    INERTIA,
    KICK,
    KICK_DISTANCE,
    KIND,
    NECK,
    PLAYER_DECAY,
    POWER,
    TURN,
    VX,
    VY,
    X,
    Y,
)
from core.keepaway.simulator.arrivals import LONGEST_INTERCEPT, fastest_to_ball
from core.keepaway.simulator.match import NEVER_SEEN
from core.keepaway.simulator.motion import RADIANS, direction_deg, kick_rate, length, wrap_deg
from core.keepaway.simulator.prediction import step_meant
from core.numerics.arrays import Bools, Floats, Ints
from core.numerics.compiled import inner_kernel

RUNNER_STEP = 0.3
"""How far the opponent fastest to the ball is thought to come towards it per cycle."""
PUSH_STEP = 0.25
"""How far other opponents are thought to move along x per cycle; twice as far behind a fast ball."""
BUMPED_DISTANCE = 0.2
NOT_FOUND = -2


@inner_kernel
def reckon_players(
    i: int,
    truth: Floats,
    beliefs: Floats,
    ball: Floats,
    ages: Ints,
    known: Bools,
    knows_ball: bool,
    first: int,
    last: int,
    forward: float,
    sure_to_see: float,
) -> None:
    """Advance player i's beliefs about the others by one cycle, out of habit.

    Args:
        i: the player.
        truth: all players, (n, 6); used only to leave out those that are about to be seen.
        beliefs: player i's beliefs, (n, 6), in place.
        ball: the ball as player i believes.
        ages: cycles since player i saw each player, (n,), in place.
        known: which players it knew the place of, (n,).
        knows_ball: whether it has seen the ball in this episode.
        first: first opponent.
        last: one past the last opponent.
        forward: +1 where the player's team plays towards +x, else -1.
        sure_to_see: distance within which all players are seen in this cycle; negative for none.
    """
    runner = NOT_FOUND
    for j in range(beliefs.shape[0]):
        if j == i or ages[j] == NEVER_SEEN:
            continue
        ages[j] += 1
        if length(truth[j, X] - truth[i, X], truth[j, Y] - truth[i, Y]) <= sure_to_see:
            continue
        if first <= j < last:
            if runner == NOT_FOUND:
                runner = -1
                if knows_ball:
                    runner = fastest_to_ball(ball, beliefs, known, first, last, LONGEST_INTERCEPT)[0]
            _reckon_opponent(beliefs[j], ball, j == runner, forward)
        else:
            beliefs[j, X] += beliefs[j, VX]
            beliefs[j, Y] += beliefs[j, VY]
            beliefs[j, VX] *= PLAYER_DECAY
            beliefs[j, VY] *= PLAYER_DECAY


@inner_kernel
def feel_myself(body: Floats, belief: Floats, command: Floats, collided: bool) -> None:
    """Know one's own velocity; advance one's own position by the way covered, one's direction by the turn
    meant.

    How far a turn really went (its noise is 10 %) is seen only in the next visual message. So is where a
    collision stopped one: until then a player believes that it has gone as far as it meant to. (Read from the
    logs: after colliding in a blind cycle, takers kick at a ball exactly when it would be in reach from
    there.)
    """
    if command[KIND] == TURN:
        turned = command[ANGLE] / (1.0 + INERTIA * length(belief[VX], belief[VY]))
        belief[BODY] = wrap_deg(belief[BODY] + turned)
    step_x, step_y = body[VX] / PLAYER_DECAY, body[VY] / PLAYER_DECAY
    if collided:
        step_x, step_y = step_meant(belief, command)
    belief[X] += step_x
    belief[Y] += step_y
    belief[VX], belief[VY] = body[VX], body[VY]
    belief[NECK] = body[NECK]


@inner_kernel
def reckon_ball(ball: Floats, me: Floats, command: Floats, bumped: bool) -> None:
    """Move the believed ball by one cycle, with the effect of my own kick, without noise.

    `me` has been advanced already; the kick was made from where I was one cycle ago.
    """
    if command[KIND] == KICK:
        dx = ball[X] - me[X] + me[VX] / PLAYER_DECAY
        dy = ball[Y] - me[Y] + me[VY] / PLAYER_DECAY
        distance = length(dx, dy)
        if distance <= KICK_DISTANCE:
            off_axis = abs(wrap_deg(direction_deg(dx, dy) - me[BODY]))
            accel = min(kick_rate(distance, off_axis) * command[POWER], BALL_ACCEL_MAX)
            direction = (me[BODY] + command[ANGLE]) * RADIANS
            ball[VX] += accel * math.cos(direction)
            ball[VY] += accel * math.sin(direction)
            speed = length(ball[VX], ball[VY])
            if speed > BALL_SPEED_MAX:
                ball[VX] *= BALL_SPEED_MAX / speed
                ball[VY] *= BALL_SPEED_MAX / speed
    ball[X] += ball[VX]
    ball[Y] += ball[VY]
    ball[VX] *= BALL_DECAY
    ball[VY] *= BALL_DECAY
    if bumped:
        _bump(ball, me)


@inner_kernel
def _bump(ball: Floats, me: Floats) -> None:
    """I ran into the ball: it lies just beside me and has lost its speed."""
    dx, dy = ball[X] - me[X], ball[Y] - me[Y]
    distance = max(length(dx, dy), 1e-9)
    ball[X] = me[X] + dx * BUMPED_DISTANCE / distance
    ball[Y] = me[Y] + dy * BUMPED_DISTANCE / distance
    ball[VX] *= -0.1
    ball[VY] *= -0.1


@inner_kernel
def still_near_opponent(ball: Floats, players: Floats, known: Bools, first: int, last: int) -> None:
    """A ball within an opponent's reach is thought to lie still."""
    for j in range(first, last):
        if known[j] and length(ball[X] - players[j, X], ball[Y] - players[j, Y]) < KICK_DISTANCE:
            ball[VX], ball[VY] = 0.0, 0.0


@inner_kernel
def _reckon_opponent(player: Floats, ball: Floats, runs: bool, forward: float) -> None:
    if runs:
        dx, dy = ball[X] - player[X], ball[Y] - player[Y]
        distance = length(dx, dy)
        if distance > 0.0:
            player[X] += RUNNER_STEP * dx / distance
            player[Y] += RUNNER_STEP * dy / distance
    else:
        speed = ball[VX] * forward
        step = PUSH_STEP if speed > 0.0 else -PUSH_STEP
        if abs(speed) > 1.0:
            step *= 2.0
        player[X] += step * forward
