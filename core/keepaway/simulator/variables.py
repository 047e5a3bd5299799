"""The state variables of a deciding keeper: distances and angles, 13 of them for 3v2 (4K + 2T - 3 in
general).
"""

import math
from dataclasses import dataclass

from core.keepaway.pitch import KeepawayConfig, X, Y
from core.keepaway.simulator.motion import DEGREES
from core.numerics.arrays import Floats, Ints
from core.numerics.compiled import inner_kernel


@dataclass(frozen=True, slots=True)
class StateVariable:
    """One state variable, its unit and range, and how finely the published tile coding cuts it."""

    name: str
    unit: str
    """"m" or "deg"."""
    low: float
    high: float
    tile_width: float
    """In `unit` (UT Austin keepaway 0.6)."""


def _spread(i: int, n: int) -> int:
    """Return (i - 1) / n cut towards zero as in the published widths; 0 where n is 0."""
    return int((i - 1) / n) if n else 0


def state_variables(config: KeepawayConfig) -> tuple[StateVariable, ...]:
    """Return the variables in the order of the array: K1 has the ball, others are numbered by distance from
    it.

    Distances reach to 1.25 times the region's diagonal: players leave the region by a little, never far.
    """
    keepers, takers = config.n_keepers, config.n_takers
    far = 1.25 * math.hypot(config.length_m, config.width_m)
    keeper_width = [2.0 + _spread(i, keepers - 2) for i in range(1, keepers)]
    taker_width = [3.0 + _spread(i, takers - 1) for i in range(takers)]
    mates = [f"K{i + 2}" for i in range(keepers - 1)]
    rivals = [f"T{i + 1}" for i in range(takers)]

    def metres(name: str, width: float) -> StateVariable:
        return StateVariable(name, "m", 0.0, far, width)

    return (
        metres("dist(K1,C)", 2.0),
        *(metres(f"dist(K1,{k})", w) for k, w in zip(mates, keeper_width, strict=True)),
        *(metres(f"dist(K1,{t})", w) for t, w in zip(rivals, taker_width, strict=True)),
        *(metres(f"dist({k},C)", w) for k, w in zip(mates, keeper_width, strict=True)),
        *(metres(f"dist({t},C)", 3.0) for t in rivals),
        *(metres(f"min dist({k},T)", 4.0) for k in mates),
        *(StateVariable(f"min ang({k},K1,T)", "deg", 0.0, 180.0, 10.0) for k in mates),
    )


@inner_kernel
def sort_by_distance(me: int, players: Floats, first: int, last: int, order: Ints) -> None:
    """Write the players [first, last) into order[first:last], nearest to `me` first (stable)."""
    for j in range(first, last):
        dx, dy = players[j, X] - players[me, X], players[j, Y] - players[me, Y]
        here = dx * dx + dy * dy
        place = j
        while place > first:
            before = order[place - 1]
            ex, ey = players[before, X] - players[me, X], players[before, Y] - players[me, Y]
            if ex * ex + ey * ey <= here:
                break
            order[place] = before
            place -= 1
        order[place] = j


@inner_kernel
def observe(me: int, players: Floats, n_keepers: int, order: Ints, out: Floats) -> None:
    """Compute the state variables of keeper `me`.

    Args:
        me: index of the keeper with the ball.
        players: as believed, (n, 6).
        n_keepers: keepers have indices 0..n_keepers - 1.
        order: out, (n,): keepers by distance, `me` first, then takers by distance.
        out: (4K + 2T - 3,), in the order of `state_variables`.
    """
    n = players.shape[0]
    sort_by_distance(me, players, 0, n_keepers, order)
    sort_by_distance(me, players, n_keepers, n, order)
    mates, rivals = n_keepers - 1, n - n_keepers
    my_x, my_y = players[me, X], players[me, Y]
    out[0] = math.sqrt(my_x * my_x + my_y * my_y)
    for k in range(1, n):
        x, y = players[order[k], X], players[order[k], Y]
        dx, dy = x - my_x, y - my_y
        out[k] = math.sqrt(dx * dx + dy * dy)
        out[mates + rivals + k] = math.sqrt(x * x + y * y)
    base = 1 + 2 * (mates + rivals)
    for k in range(1, n_keepers):
        x, y = players[order[k], X], players[order[k], Y]
        ax, ay = x - my_x, y - my_y
        nearest, widest = math.inf, -1.0
        for t in range(n_keepers, n):
            rx, ry = players[t, X], players[t, Y]
            dx, dy = rx - x, ry - y
            nearest = min(nearest, dx * dx + dy * dy)
            bx, by = rx - my_x, ry - my_y
            # The smallest angle has the largest cosine.
            norm = math.sqrt((ax * ax + ay * ay) * (bx * bx + by * by))
            cosine = (ax * bx + ay * by) / norm if norm > 0.0 else 1.0
            widest = max(widest, cosine)
        out[base + k - 1] = math.sqrt(nearest)
        out[base + mates + k - 1] = math.acos(min(max(widest, -1.0), 1.0)) * DEGREES
