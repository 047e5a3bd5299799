"""How soon players have the ball: what a player expects of itself and others, and which keeper has to go."""

from core.keepaway.pitch import (
    BODY,
    DASH_RATE,
    INERTIA,
    KICK_DISTANCE,
    MAX_POWER,
    PLAYER_DECAY,
    PLAYER_SPEED_MAX,
    VX,
    VY,
    X,
    Y,
)
from core.keepaway.simulator.motion import direction_deg, length, wrap_deg
from core.keepaway.simulator.prediction import BALL_ROLL
from core.numerics.arrays import Bools, Floats
from core.numerics.compiled import inner_kernel

LONGEST_INTERCEPT = 30
TURN_FIRST = 10.0
"""Degrees off the way beyond which a player is taken to turn before it dashes."""
MOST_TURNS = 5
SLACK = KICK_DISTANCE


@inner_kernel
def cycles_to_point(player: Floats, tx: float, ty: float, limit: int) -> int:
    """Return about how many cycles a player needs to have (tx, ty) in reach: turns, then full dashes."""
    dx, dy = tx - player[X], ty - player[Y]
    distance = length(dx, dy)
    if distance < KICK_DISTANCE:
        return 0
    cycles = 0
    direction = direction_deg(dx, dy)
    speed = length(player[VX], player[VY])
    axial = (player[VX] * dx + player[VY] * dy) / distance
    off = abs(wrap_deg(direction - player[BODY]))
    while off > TURN_FIRST and cycles < MOST_TURNS:
        cycles += 1
        off -= 180.0 / (1.0 + INERTIA * speed)
        distance -= axial
        speed *= PLAYER_DECAY
        axial *= PLAYER_DECAY
    while distance > KICK_DISTANCE and cycles <= limit:
        cycles += 1
        axial = min(axial + DASH_RATE * MAX_POWER, PLAYER_SPEED_MAX)
        distance -= axial
        axial *= PLAYER_DECAY
    return cycles


@inner_kernel
def cycles_to_ball(player: Floats, ball: Floats) -> int:
    """Return about how many cycles a player needs to have the ball in reach; LONGEST_INTERCEPT where it
    cannot.

    The cycles to the first point of the ball's way which the player reaches *before* the ball does: fewer
    than the ball takes where it comes towards the player, many where it rolls away, even out of its own
    reach.
    """
    for n in range(1, LONGEST_INTERCEPT + 1):
        bx = ball[X] + BALL_ROLL[n] * ball[VX]
        by = ball[Y] + BALL_ROLL[n] * ball[VY]
        reach = n * PLAYER_SPEED_MAX + SLACK
        dx, dy = bx - player[X], by - player[Y]
        if dx * dx + dy * dy < reach * reach:
            cycles = cycles_to_point(player, bx, by, n)
            if cycles < n:
                return cycles
    return LONGEST_INTERCEPT


@inner_kernel
def fastest_to_ball(
    ball: Floats, players: Floats, known: Bools, first: int, last: int, latest: int
) -> tuple[int, int]:
    """Return (player, cycles): which known player of [first, last) reaches the ball first.

    Of equally fast ones the last; (-1, latest + 1) where nobody does within `latest` cycles.
    """
    for n in range(latest + 1):
        bx = ball[X] + BALL_ROLL[n] * ball[VX]
        by = ball[Y] + BALL_ROLL[n] * ball[VY]
        reach = (n + 1) * PLAYER_SPEED_MAX + SLACK
        best, best_cycles = -1, n
        for i in range(first, last):
            dx, dy = bx - players[i, X], by - players[i, Y]
            if known[i] and dx * dx + dy * dy < reach * reach:
                cycles = cycles_to_point(players[i], bx, by, n)
                if cycles <= best_cycles:
                    best, best_cycles = i, cycles
        if best >= 0:
            return best, n
    return -1, latest + 1


@inner_kernel
def keeper_to_go(ball: Floats, players: Floats, known: Bools, n_keepers: int) -> int:
    """Return the keeper that goes to the ball: the fastest to where any player, a taker too, can first have
    it; -1 for none.

    Where a taker comes first, that is the keeper who is soonest at the place where it gets the ball.
    """
    latest = fastest_to_ball(ball, players, known, 0, n_keepers, LONGEST_INTERCEPT)[1]
    n = fastest_to_ball(ball, players, known, n_keepers, players.shape[0], latest - 1)[1]
    if n > LONGEST_INTERCEPT:
        return -1
    bx = ball[X] + BALL_ROLL[n] * ball[VX]
    by = ball[Y] + BALL_ROLL[n] * ball[VY]
    best, best_cycles = -1, 2 * LONGEST_INTERCEPT
    for i in range(n_keepers):
        if known[i]:
            cycles = cycles_to_point(players[i], bx, by, best_cycles)
            if cycles <= best_cycles:
                best, best_cycles = i, cycles
    return best
