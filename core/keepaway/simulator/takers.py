"""The takers' fixed policy: the two nearest to the ball go for it, the others block passes."""

import math

from core.keepaway.pitch import KICK_DISTANCE, VX, VY, Rules, X, Y
from core.keepaway.simulator.intercept import go_to_ball
from core.keepaway.simulator.kicking import TAKER_HOLD_RATIO, hold_ball, nearest_to
from core.keepaway.simulator.match import (
    BLOCK_PASS,
    GO_TO_BALL,
    HOLD_BALL,
    SEARCH_BALL,
    WATCH_BALL,
)
from core.keepaway.simulator.motion import length
from core.keepaway.simulator.options import SEARCH_TURN, begin_option, can_kick
from core.keepaway.simulator.positioning import CONE, move_to
from core.keepaway.simulator.prediction import send_turn, turn_body_to
from core.numerics.arrays import Bools, Floats, Ints
from core.numerics.compiled import inner_kernel

TAKERS_FACE = 180.0
"""Direction of play of the takers' team, degrees."""
CHASERS = 2
BLOCK_DISTANCE = 4.0
BLOCK_CLOSE_ENOUGH = 2.0
BLOCK_LOOK_TURN = 80.0


@inner_kernel
def _rank(i: int, x: float, y: float, players: Floats, known: Bools, first: int) -> int:
    """Return how many known players of [first, n) are nearer to a point than player i (ties: lower index)."""
    mine = length(players[i, X] - x, players[i, Y] - y)
    rank = 0
    for j in range(first, players.shape[0]):
        if j != i and known[j]:
            distance = length(players[j, X] - x, players[j, Y] - y)
            if distance < mine or (distance == mine and j < i):
                rank += 1
    return rank


@inner_kernel
def in_cone(fx: float, fy: float, tx: float, ty: float, players: Floats, known: Bools, first: int) -> int:
    """Return how many known players of [first, n) stand in the pass cone from f to t."""
    dx, dy = tx - fx, ty - fy
    count = 0
    for j in range(first, players.shape[0]):
        if known[j]:
            px, py = players[j, X] - fx, players[j, Y] - fy
            along = px * dx + py * dy
            if along > 0.0 and along < dx * dx + dy * dy and abs(px * dy - py * dx) < CONE * along:
                count += 1
    return count


@inner_kernel
def most_open_keeper(ball: Floats, players: Floats, known: Bools, n_keepers: int) -> int:
    """Return the keeper, not the one at the ball, with the fewest takers in the way of a pass; -1 for
    none.
    """
    holder = nearest_to(ball[X], ball[Y], players, known, 0, n_keepers)[0]
    best, fewest = -1, players.shape[0]
    for k in range(n_keepers):
        if k != holder and known[k]:
            count = in_cone(ball[X], ball[Y], players[k, X], players[k, Y], players, known, n_keepers)
            if count < fewest:
                best, fewest = k, count
    return best


@inner_kernel
def block_pass(me: Floats, ball: Floats, mark: Floats, cycle: int, command: Floats) -> None:
    """BlockPass: stand 4 m from the marked keeper on the ball's side; look around when there."""
    dx, dy = ball[X] - mark[X], ball[Y] - mark[Y]
    fraction = BLOCK_DISTANCE / max(math.sqrt(dx * dx + dy * dy), BLOCK_DISTANCE)
    x, y = mark[X] + fraction * dx, mark[Y] + fraction * dy
    if length(me[X] - x, me[Y] - y) < BLOCK_CLOSE_ENOUGH:
        turn = BLOCK_LOOK_TURN if cycle % 2 == 0 else -BLOCK_LOOK_TURN
        send_turn(turn, length(me[VX], me[VY]), command)
    else:
        move_to(me, x, y, command)


@inner_kernel
def command_taker(
    i: int,
    row: Ints,
    ball: Floats,
    players: Floats,
    known: Bools,
    knows_ball: bool,
    meet: Floats,
    cycle: int,
    rules: Rules,
    command: Floats,
) -> bool:
    """Find the option of taker i and write its command for this cycle; arguments as `options.command_keeper`.

    Returns:
        Whether its option starts now.
    """
    me, n_keepers = players[i], rules.n_keepers
    if not knows_ball:
        send_turn(SEARCH_TURN, length(me[VX], me[VY]), command)
        return begin_option(row, SEARCH_BALL, -1, False, cycle)
    rank = _rank(i, ball[X], ball[Y], players, known, n_keepers)
    if rank == 0 and can_kick(me, ball):
        hold_ball(me, ball, players, known, 0, n_keepers, TAKER_HOLD_RATIO, TAKERS_FACE, command)
        return begin_option(row, HOLD_BALL, -1, False, cycle)
    mark = -1
    if rank >= CHASERS:
        mark = most_open_keeper(ball, players, known, n_keepers)
    if mark >= 0:
        block_pass(me, ball, players[mark], cycle, command)
        return begin_option(row, BLOCK_PASS, mark, False, cycle)
    if _mate_has_ball(i, ball, players, known, n_keepers):
        turn_body_to(me, ball[X] + ball[VX], ball[Y] + ball[VY], 1, command)
        return begin_option(row, WATCH_BALL, -1, False, cycle)
    rival = nearest_to(me[X], me[Y], players, known, 0, n_keepers)[1]
    go_to_ball(me, ball, meet, cycle, rival, TAKERS_FACE, command)
    return begin_option(row, GO_TO_BALL, -1, False, cycle)


@inner_kernel
def _mate_has_ball(i: int, ball: Floats, players: Floats, known: Bools, n_keepers: int) -> bool:
    """Return whether the player nearest to the ball is a team mate of taker i who can kick it."""
    n = players.shape[0]
    nearest, distance = nearest_to(ball[X], ball[Y], players, known, 0, n)
    return nearest >= n_keepers and nearest != i and distance < KICK_DISTANCE
