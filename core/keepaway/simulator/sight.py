"""What is seen: distances, directions and their changes, rounded as the server does, in two of three
cycles.
"""

import math

import numpy as np

from core.keepaway.pitch import BALL_NOISE, BODY, KICK_DISTANCE, NECK, VX, VY, Rules, X, Y
from core.keepaway.simulator.match import CLOCK, NEVER_SEEN, SEE_PERIOD, Match
from core.keepaway.simulator.motion import DEGREES, RADIANS, copy_row, direction_deg, length, wrap_deg
from core.keepaway.simulator.reckoning import still_near_opponent
from core.numerics.arrays import Floats
from core.numerics.compiled import inner_kernel

LOG_STEP = 0.1
"""Step of the logarithm of a seen distance."""
DISTANCE_STEP = 0.1
CHANGE_STEP = 0.02
"""Step of the relative change of a seen distance."""
TURN_STEP_DEG = 0.1
"""Step of the change of a seen direction, degrees per cycle."""
NUMBER_SEEN = 20.0
"""Distance up to which a shirt number is always seen; the chance falls to 0 at twice this."""
FELT_DISTANCE = 3.0
"""Distance within which something is noticed outside the field of view."""


# Entries of `Match.sight`.
DISTANCE = 0
DIRECTION = 1
REPORTED = 2
AWAY = 3
ACROSS = 4


@inner_kernel
def rounded(value: float, step: float) -> float:
    """Return the multiple of `step` nearest to `value`."""
    return math.floor(value / step + 0.5) * step


@inner_kernel
def seen_distance(distance: float) -> float:
    """Return a distance as the server reports it: steps of about 10 %, then of 0.1 m."""
    return rounded(math.exp(rounded(math.log(max(distance, 1e-3)), LOG_STEP)), DISTANCE_STEP)


@inner_kernel
def sees(match: Match, i: int) -> bool:
    """Return whether player i gets a visual message in this cycle."""
    return bool((match.status[CLOCK] + match.phase[i]) % SEE_PERIOD != SEE_PERIOD - 1)


@inner_kernel
def measure(a: Floats, b: Floats, quantise: bool, out: Floats) -> None:
    """Measure object b from object a (rows of x, y, vx, vy): what both see of each other is the same.

    Args:
        a: the one.
        b: the other.
        quantise: round as the server does.
        out: distance, direction from a to b (degrees), distance as reported, speed away from each other,
            speed across (counter-clockwise), shape (5,).
    """
    dx, dy = b[X] - a[X], b[Y] - a[Y]
    distance = length(dx, dy)
    ux, uy = (dx / distance, dy / distance) if distance > 0.0 else (1.0, 0.0)
    rvx, rvy = b[VX] - a[VX], b[VY] - a[VY]
    away, across = rvx * ux + rvy * uy, rvy * ux - rvx * uy
    out[DISTANCE], out[DIRECTION], out[REPORTED] = distance, direction_deg(dx, dy), distance
    if quantise:
        reported = seen_distance(distance)
        apart = max(distance, 1e-3)
        out[REPORTED] = reported
        away = reported * rounded(away / apart, CHANGE_STEP)
        across = reported * RADIANS * rounded(across / apart * DEGREES, TURN_STEP_DEG)
    out[AWAY], out[ACROSS] = away, across


@inner_kernel
def look(match: Match, rules: Rules, rng: np.random.Generator) -> None:
    """Let those who get a visual message take it in: rounded distances, directions and their changes."""
    n = rules.n_keepers + rules.n_takers
    sight = match.sight
    for i in range(n):
        if sees(match, i):  # flags are seen finely enough to know one's own place and direction
            copy_row(match.players[i], match.seen_players[i, i])
            match.player_age[i, i] = 0
    for i in range(n):
        for j in range(i + 1, n):
            if not (sees(match, i) or sees(match, j)):
                continue
            measure(match.players[i], match.players[j], rules.quantise, sight)
            for me, other in ((i, j), (j, i)):
                if not sees(match, me):
                    continue
                # Far away the shirt number gets lost.
                far = sight[DISTANCE] - NUMBER_SEEN
                named = far <= 0.0 or NUMBER_SEEN * rng.random() > far
                if _look_at(
                    match.players[me],
                    match.players[other],
                    sight,
                    me > other,
                    named,
                    match.known[me, other],
                    rules,
                    match.seen_players[me, other],
                ):
                    match.player_age[me, other] = 0
    for i in range(n):
        if not sees(match, i):
            continue
        measure(match.players[i], match.ball, rules.quantise, sight)
        expected = match.ball_age[i] < NEVER_SEEN
        if _look_at_ball(match.players[i], sight, expected, rules, match.seen_ball[i]):
            match.ball_age[i] = 0
            if sight[REPORTED] > KICK_DISTANCE:
                first, last = (rules.n_keepers, n) if i < rules.n_keepers else (0, rules.n_keepers)
                still_near_opponent(match.seen_ball[i], match.seen_players[i], match.known[i], first, last)


@inner_kernel
def in_view(me: Floats, direction: float, view_angle: float) -> bool:
    """Return whether a global direction lies in the field of view around body + neck."""
    return view_angle >= 360.0 or abs(wrap_deg(direction - me[BODY] - me[NECK])) <= 0.5 * view_angle


@inner_kernel
def _look_at(
    me: Floats,
    other: Floats,
    sight: Floats,
    opposite: bool,
    named: bool,
    known: bool,
    rules: Rules,
    belief: Floats,
) -> bool:
    """Let `me` see `other`, measured in `sight` (from the other's side where `opposite`); return whether it
    did.
    """
    direction = wrap_deg(sight[DIRECTION] + 180.0) if opposite else sight[DIRECTION]
    seen = named and in_view(me, direction, rules.view_angle)
    if not seen and (sight[DISTANCE] >= FELT_DISTANCE or not known):
        return False
    _note(me, sight, direction, rules.quantise, seen, belief)
    if seen:
        belief[BODY] = wrap_deg(rounded(other[BODY], 1.0)) if rules.quantise else other[BODY]
    return True


@inner_kernel
def _look_at_ball(me: Floats, sight: Floats, expected: bool, rules: Rules, belief: Floats) -> bool:
    """Let `me` see the ball, measured in `sight`; return whether it did."""
    seen = in_view(me, sight[DIRECTION], rules.view_angle)
    if not seen and sight[DISTANCE] >= FELT_DISTANCE:
        return False
    vx, vy = belief[VX], belief[VY]
    _note(me, sight, sight[DIRECTION], rules.quantise, seen, belief)
    slack = 2.0 * BALL_NOISE * length(vx, vy)
    if seen and expected and abs(belief[VX] - vx) < slack and abs(belief[VY] - vy) < slack:
        belief[VX], belief[VY] = 0.5 * (belief[VX] + vx), 0.5 * (belief[VY] + vy)
    return True


@inner_kernel
def _note(me: Floats, sight: Floats, direction: float, quantise: bool, moving: bool, belief: Floats) -> None:
    """Write the place, and with `moving` the velocity, of something measured into `belief`."""
    if quantise:
        gaze = me[BODY] + me[NECK]
        direction = rounded(direction - gaze, 1.0) + gaze
    cos_way, sin_way = math.cos(direction * RADIANS), math.sin(direction * RADIANS)
    belief[X] = me[X] + sight[REPORTED] * cos_way
    belief[Y] = me[Y] + sight[REPORTED] * sin_way
    if moving:
        belief[VX] = me[VX] + sight[AWAY] * cos_way - sight[ACROSS] * sin_way
        belief[VY] = me[VY] + sight[AWAY] * sin_way + sight[ACROSS] * cos_way
