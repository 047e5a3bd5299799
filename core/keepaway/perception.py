"""What each player believes: dead reckoning in every cycle, corrected by what it sees in two of three.

The reference's players carry soccer habits into keepaway - opponents are thought to push forward, a ball near an
opponent is thought to lie still - and these, not the rounding of what is seen, decide how well a ball is held.
"""

import math

import numpy as np
from numpy.typing import NDArray

from core.compiled import kernel
from core.keepaway.intercept import LONGEST_INTERCEPT, fastest_to_ball
from core.keepaway.match import CLOCK, NEVER_SEEN, SEE_PERIOD, Match
from core.keepaway.motion import DEGREES, RADIANS, direction_deg, kick_rate, length, wrap_deg
from core.keepaway.pitch import (
    ANGLE,
    BALL_ACCEL_MAX,
    BALL_DECAY,
    BALL_NOISE,
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
    Rules,
    X,
    Y,
)
from core.keepaway.prediction import step_meant

Floats = NDArray[np.float64]
Ints = NDArray[np.int64]
Bools = NDArray[np.bool_]
FORGET_PLAYER = 12
"""Cycles after which a player not seen is unknown (confidence 0.88)."""
FORGET_BALL = 10
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
RUNNER_STEP = 0.3
"""How far the opponent fastest to the ball is thought to come towards it per cycle."""
PUSH_STEP = 0.25
"""How far other opponents are thought to move along x per cycle; twice as far behind a fast ball."""
BUMPED_DISTANCE = 0.2
NOT_FOUND = -2
STALE_BALL = 3
"""Age in cycles beyond which what a team mate says about the ball is believed."""
CONTRADICTION = 0.3
"""Difference of velocities, metres per cycle, beyond which fresher news of the ball is believed at once."""
TOLD_DISTANCE = 20.0
"""A player speaks of a ball nearer than this."""

# Entries of `Match.sight`.
DISTANCE = 0
DIRECTION = 1
REPORTED = 2
AWAY = 3
ACROSS = 4


@kernel
def rounded(value: float, step: float) -> float:
    """Return the multiple of `step` nearest to `value`."""
    return math.floor(value / step + 0.5) * step


@kernel
def seen_distance(distance: float) -> float:
    """Return a distance as the server reports it: steps of about 10 %, then of 0.1 m."""
    return rounded(math.exp(rounded(math.log(max(distance, 1e-3)), LOG_STEP)), DISTANCE_STEP)


@kernel
def perceive(match: Match, rules: Rules, rng: np.random.Generator) -> None:
    """Bring every player's beliefs to the present cycle.

    With exact state players know everything; their belief arrays stay unused.
    """
    n = rules.n_keepers + rules.n_takers
    if rules.exact_state:
        match.known[:] = True
        return
    if rules.view_angle < 360.0:
        for i in range(n):  # what is heard now was said, and seen, a cycle ago
            first, last = (0, rules.n_keepers) if i < rules.n_keepers else (rules.n_keepers, n)
            listen(match, i, first, last, rng)
    for i in range(n):
        # With eyes all round, whoever is near is about to be seen: no need to reckon where he went.
        sure_to_see = NUMBER_SEEN if sees(match, i) and rules.view_angle >= 360.0 else -1.0
        first, last = (rules.n_keepers, n) if i < rules.n_keepers else (0, rules.n_keepers)
        ages, beliefs, known = match.player_age[i], match.seen_players[i], match.known[i]
        _feel_myself(match.players[i], beliefs[i], match.commands[i], match.hit[1 + i])
        if ages[i] < NEVER_SEEN:
            ages[i] = 0
        knows = match.ball_age[i] < NEVER_SEEN
        if knows:
            match.ball_age[i] += 1
            bumped = match.hit[0] and match.hit[1 + i]
            _reckon_ball(match.seen_ball[i], beliefs[i], match.commands[i], bumped)
            _still_near_opponent(match.seen_ball[i], beliefs, known, first, last)
        forward = 1.0 if i < rules.n_keepers else -1.0
        reckon_players(
            i,
            match.players,
            beliefs,
            match.seen_ball[i],
            ages,
            known,
            knows,
            first,
            last,
            forward,
            sure_to_see,
        )
    look(match, rules, rng)
    for i in range(n):
        for j in range(n):
            match.known[i, j] = match.player_age[i, j] <= FORGET_PLAYER


@kernel
def sees(match: Match, i: int) -> bool:
    """Return whether player i gets a visual message in this cycle."""
    return bool((match.status[CLOCK] + match.phase[i]) % SEE_PERIOD != SEE_PERIOD - 1)


@kernel
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
        sure_to_see: distance within which everybody is seen in this cycle; negative for none.
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


@kernel
def _feel_myself(body: Floats, belief: Floats, command: Floats, collided: bool) -> None:
    """Know one's own velocity; advance one's own position by the way covered, one's direction by the turn meant.

    How far a turn really went (its noise is 10 %) is seen only in the next visual message. So is where a collision
    stopped one: until then a player believes that it has gone as far as it meant to. (Read from the logs: after colliding
    in a blind cycle, takers kick at a ball exactly when it would be in reach from there.)
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


@kernel
def _reckon_ball(ball: Floats, me: Floats, command: Floats, bumped: bool) -> None:
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


@kernel
def _bump(ball: Floats, me: Floats) -> None:
    """I ran into the ball: it lies just beside me and has lost its speed."""
    dx, dy = ball[X] - me[X], ball[Y] - me[Y]
    distance = max(length(dx, dy), 1e-9)
    ball[X] = me[X] + dx * BUMPED_DISTANCE / distance
    ball[Y] = me[Y] + dy * BUMPED_DISTANCE / distance
    ball[VX] *= -0.1
    ball[VY] *= -0.1


@kernel
def _still_near_opponent(ball: Floats, players: Floats, known: Bools, first: int, last: int) -> None:
    """A ball within an opponent's reach is thought to lie still."""
    for j in range(first, last):
        if known[j] and length(ball[X] - players[j, X], ball[Y] - players[j, Y]) < KICK_DISTANCE:
            ball[VX], ball[VY] = 0.0, 0.0


@kernel
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


@kernel
def measure(a: Floats, b: Floats, quantise: bool, out: Floats) -> None:
    """Measure object b from object a (rows of x, y, vx, vy): what both see of each other is the same.

    Args:
        a: the one.
        b: the other.
        quantise: round as the server does.
        out: distance, direction from a to b (degrees), distance as reported, speed away from each other, speed
            across (counter-clockwise), shape (5,).
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


@kernel
def look(match: Match, rules: Rules, rng: np.random.Generator) -> None:
    """Let those who get a visual message take it in: rounded distances, directions and their changes."""
    n = rules.n_keepers + rules.n_takers
    sight = match.sight
    for i in range(n):
        if sees(match, i):  # flags are seen finely enough to know one's own place and direction
            match.seen_players[i, i] = match.players[i]
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
                _still_near_opponent(match.seen_ball[i], match.seen_players[i], match.known[i], first, last)


@kernel
def in_view(me: Floats, direction: float, view_angle: float) -> bool:
    """Return whether a global direction lies in the field of view around body + neck."""
    return view_angle >= 360.0 or abs(wrap_deg(direction - me[BODY] - me[NECK])) <= 0.5 * view_angle


@kernel
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
    """Let `me` see `other`, measured in `sight` (from the other's side where `opposite`); return whether it did."""
    direction = wrap_deg(sight[DIRECTION] + 180.0) if opposite else sight[DIRECTION]
    seen = named and in_view(me, direction, rules.view_angle)
    if not seen and (sight[DISTANCE] >= FELT_DISTANCE or not known):
        return False
    _note(me, sight, direction, rules.quantise, seen, belief)
    if seen:
        belief[BODY] = wrap_deg(rounded(other[BODY], 1.0)) if rules.quantise else other[BODY]
    return True


@kernel
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


@kernel
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


@kernel
def listen(match: Match, i: int, first: int, last: int, rng: np.random.Generator) -> None:
    """Hear one team mate of [first, last): its own place, the ball, and the opponent it saw nearest.

    Who has seen nothing in this episode yet says nothing. What is heard replaces only what oneself knows less well: an
    unseen mate, a ball older than 3 cycles, or one that moves otherwise by fresher news.
    """
    mates = last - first - 1
    if mates < 1:
        return
    speaker = first + int(mates * rng.random())
    if speaker >= i:
        speaker += 1
    told = match.seen_players[speaker]
    if match.player_age[speaker, speaker] > 0:
        return
    if match.player_age[i, speaker] > 0:
        _copy_place(told[speaker], match.seen_players[i, speaker])
        match.player_age[i, speaker] = 0
    if match.ball_age[speaker] == 0 and _is_news(
        match.seen_ball[speaker], told[speaker], match.seen_ball[i], match.ball_age[i]
    ):
        match.seen_ball[i] = match.seen_ball[speaker]
        match.ball_age[i] = 1
    rival, nearest = -1, math.inf
    for j in range(told.shape[0]):
        if (j < first or j >= last) and match.player_age[speaker, j] == 0:
            distance = length(told[j, X] - told[speaker, X], told[j, Y] - told[speaker, Y])
            if distance < nearest:
                rival, nearest = j, distance
    if rival >= 0 and match.player_age[i, rival] > 1:
        _copy_place(told[rival], match.seen_players[i, rival])
        match.player_age[i, rival] = 1


@kernel
def _is_news(ball: Floats, speaker: Floats, mine: Floats, age: int) -> bool:
    """Return whether what a mate says of the ball, just seen from where it stood, is better than what I believe."""
    if length(ball[X] - speaker[X], ball[Y] - speaker[Y]) >= TOLD_DISTANCE:
        return False
    if age > STALE_BALL:
        return True
    return bool(age > 0 and length(ball[VX] - mine[VX], ball[VY] - mine[VY]) > CONTRADICTION)


@kernel
def _copy_place(told: Floats, belief: Floats) -> None:
    belief[X], belief[Y] = told[X], told[Y]
