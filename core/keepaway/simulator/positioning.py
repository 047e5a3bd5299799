"""Skills of a player without the ball: get open for a pass, block a pass, search for a ball out of sight."""

import math

from core.keepaway.pitch import BODY, INERTIA, PLAYER_DECAY, VX, VY, X, Y
from core.keepaway.simulator.motion import RADIANS, direction_deg, length, wrap_deg
from core.keepaway.simulator.prediction import (
    dash_power,
    send_dash,
    send_turn,
    turn_body_to,
)
from core.numerics.arrays import Bools, Floats
from core.numerics.compiled import inner_kernel

GRID = 5
MARGIN = 0.15
"""Inset of the grid of candidate points per side, as a fraction of the region's side."""
CONE = 0.3
"""Half width of a pass cone per metre of its length."""
CLOSE_ENOUGH = 1.5
WHEN_TO_TURN = 7.0
FINAL_ROLL = 1.0 / (1.0 - PLAYER_DECAY)


@inner_kernel
def open_for_pass(
    fx: float, fy: float, tx: float, ty: float, players: Floats, known: Bools, first: int, last: int
) -> bool:
    """Return whether no known player in [first, last) stands in the cone of a pass from f to t."""
    dx, dy = tx - fx, ty - fy
    squared = dx * dx + dy * dy
    if squared == 0.0:
        return True
    for j in range(first, last):
        if known[j]:
            px, py = players[j, X] - fx, players[j, Y] - fy
            along = px * dx + py * dy
            inside = along > 0.0 and along < squared and abs(px * dy - py * dx) < CONE * along
            if inside and px * px + py * py < squared:
                return False
    return True


@inner_kernel
def congestion(me: int, x: float, y: float, players: Floats, known: Bools, enough: float) -> float:
    """Return the sum of 1 / distance from a point to all other known players; stop adding at `enough`."""
    total = 0.0
    for j in range(players.shape[0]):
        if j != me and known[j]:
            dx, dy = players[j, X] - x, players[j, Y] - y
            total += 1.0 / math.sqrt(max(dx * dx + dy * dy, 1e-12))
            if total >= enough:
                break
    return total


@inner_kernel
def open_point(
    me: int,
    fx: float,
    fy: float,
    players: Floats,
    known: Bools,
    n_keepers: int,
    half_length: float,
    half_width: float,
) -> tuple[float, float]:
    """Return the least congested grid point that a pass from (fx, fy) can reach; (0, 0) where none is
    open.
    """
    best_x, best_y, least = 0.0, 0.0, math.inf
    for column in range(GRID):
        x = half_length * (1.0 - 2.0 * MARGIN) * (column / 2.0 - 1.0)
        for row in range(GRID):
            y = half_width * (1.0 - 2.0 * MARGIN) * (row / 2.0 - 1.0)
            total = congestion(me, x, y, players, known, least)
            if total < least and open_for_pass(fx, fy, x, y, players, known, n_keepers, players.shape[0]):
                best_x, best_y, least = x, y, total
    return best_x, best_y


@inner_kernel
def move_to(me: Floats, tx: float, ty: float, command: Floats) -> None:
    """Turn towards a point or dash to it; stop first where turning would take three cycles."""
    dx, dy = tx - me[X] - FINAL_ROLL * me[VX], ty - me[Y] - FINAL_ROLL * me[VY]
    off = wrap_deg(direction_deg(dx, dy) - me[BODY])
    body = me[BODY] * RADIANS
    cos_body, sin_body = math.cos(body), math.sin(body)
    axial = cos_body * me[VX] + sin_body * me[VY]
    speed = length(me[VX], me[VY])
    if abs(off) < WHEN_TO_TURN:
        send_dash(dash_power(cos_body * (tx - me[X]) + sin_body * (ty - me[Y]), axial, 1), command)
        return
    turns, left, rolling = 0, abs(off), speed
    while left > WHEN_TO_TURN and turns < 3:
        left -= 180.0 / (1.0 + INERTIA * rolling)
        rolling *= PLAYER_DECAY
        turns += 1
    if turns >= 3:
        send_dash(dash_power(0.0, axial, 1), command)
    else:
        send_turn(off, speed, command)


@inner_kernel
def get_open(
    me: int,
    ball: Floats,
    fx: float,
    fy: float,
    players: Floats,
    known: Bools,
    n_keepers: int,
    half_length: float,
    half_width: float,
    command: Floats,
) -> None:
    """GetOpen: go where few are and where a pass from (fx, fy), the ball's next holder, can reach."""
    x, y = open_point(me, fx, fy, players, known, n_keepers, half_length, half_width)
    if length(players[me, X] - x, players[me, Y] - y) < CLOSE_ENOUGH:
        turn_body_to(players[me], ball[X], ball[Y], 1, command)
    else:
        move_to(players[me], x, y, command)
