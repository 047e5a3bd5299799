"""A match: every array that changes while keepers and takers play, and how an episode starts and ends."""

from typing import Final, NamedTuple

import numpy as np

from core.keepaway.pitch import (
    BALL_COLUMNS,
    BALL_INSET,
    BODY,
    COMMAND_COLUMNS,
    CORNER_BOX,
    DROP_DISTANCE,
    KICK_DISTANCE,
    ONGOING,
    OUT,
    PLAYER_COLUMNS,
    STUCK_AREA,
    STUCK_CYCLES,
    TAKE_CYCLES,
    TAKEN,
    VX,
    VY,
    KeepawayConfig,
    Rules,
    X,
    Y,
)
from core.keepaway.simulator.intercept import MEET_COLUMNS, MEET_CYCLE
from core.keepaway.simulator.motion import length
from core.numerics.arrays import Bools, Floats, Ints
from core.numerics.compiled import inner_kernel, kernel
from core.numerics.streams import stream

# Entries of `Match.status`.
CYCLE: Final = 0
"""Cycles since the episode started."""
CLOCK: Final = 1
"""Cycles since the match started."""
TAKE_COUNT: Final = 2
END: Final = 3
"""ONGOING, OUT or TAKEN."""
EPISODE: Final = 4
"""Episodes started."""
STATUS_ENTRIES: Final = 5

# Columns of `Match.options`: what each player is doing.
OPTION: Final = 0
TARGET: Final = 1
"""Index of the player a pass goes to or a block marks; -1 for none."""
START: Final = 2
"""Cycle in which the option started."""
ACTION: Final = 3
"""Index of the last action of this player's decisions; -1 before the first one."""
ACTION_CYCLE: Final = 4
"""Last cycle in which that action was carried out."""
OPTION_COLUMNS: Final = 5

# Values of OPTION.
NO_OPTION: Final = -1
HOLD_BALL: Final = 0
PASS_BALL: Final = 1
GO_TO_BALL: Final = 2
GET_OPEN: Final = 3
BLOCK_PASS: Final = 4
SEARCH_BALL: Final = 5
WATCH_BALL: Final = 6
"""A taker whose team mate has the ball turns towards it."""

NEVER_SEEN: Final = 1 << 30
SEE_PERIOD: Final = 3
"""Visual messages come every 150 ms: in two of three cycles of 100 ms."""
SHARED_PHASE: Final = 0.5
"""Chance that a player gets its visual messages in the same cycles as the one before it because they joined
together.

In the reference every player's messages run from the moment it joined. In three logged matches 8 of 12
neighbours share their phase (K1..T2: 22211, 11012, 00000); 1/2 joined together and 1/3 of the rest by chance
make 2 of 3."""


class Match(NamedTuple):
    """Arrays of a match with n players (keepers first) and v state variables; kernels work on them in
    place.
    """

    ball: Floats
    """x, y, vx, vy, shape (4,)."""
    players: Floats
    """x, y, vx, vy, body, neck, shape (n, 6)."""
    commands: Floats
    """Kind, power, angle, neck turn of this cycle, shape (n, 4)."""
    status: Ints
    """CYCLE, CLOCK, TAKE_COUNT, END, EPISODE, shape (5,)."""
    options: Ints
    """Option, target, start, action, action cycle, shape (n, 5)."""
    started: Bools
    """Whether the player's option started in this cycle, shape (n,)."""
    deciding: Bools
    """Whether the keeper decides in this cycle, shape (n_keepers,)."""
    actions: Ints
    """The decision: 0 holds, a >= 1 passes to the a-th nearest keeper, shape (n_keepers,)."""
    variables: Floats
    """State variables of keepers that decide, shape (n_keepers, v); stale otherwise."""
    order: Ints
    """Players by distance as the deciding keeper sees them: keepers (itself first), takers; (n_keepers,
    n)."""
    runner: Ints
    """The keeper each keeper without the ball believes fastest to it (-1: nobody), and its cycles to the ball
    (-1: not yet reckoned), shape (n_keepers, 2)."""
    meet: Floats
    """Where each player last meant to meet the ball: x, y, cycle, shape (n, 3)."""
    seen_ball: Floats
    """Each player's belief of the ball, shape (n, 4)."""
    seen_players: Floats
    """Each player's belief of every player, shape (n, n, 6)."""
    ball_age: Ints
    """Cycles since each player last saw the ball, shape (n,)."""
    player_age: Ints
    """Cycles since each player last saw each player, shape (n, n)."""
    phase: Ints
    """Of each player's visual messages: none where (clock + phase) % 3 is 2, shape (n,)."""
    sight: Floats
    """Scratch of the visual messages, shape (5,)."""
    known: Bools
    """Whether each player knows where each player is, shape (n, n)."""
    stuck: Floats
    """Where and since when (clock) the ball has not left its surroundings: x, y, clock, shape (3,)."""
    push: Floats
    """Accelerations of this cycle: ball, then players, shape (n + 1, 2)."""
    moves: Floats
    """Scratch of the collisions, shape (n + 1, 3)."""
    hit: Bools
    """Whether ball (0) or player i (1 + i) collided in this cycle, shape (n + 1,)."""


class Streams(NamedTuple):
    """One Generator per purpose, so that a draw in one never shifts another."""

    placement: np.random.Generator
    movement: np.random.Generator
    turn: np.random.Generator
    kick: np.random.Generator
    perception: np.random.Generator
    policy: np.random.Generator


def open_streams(root_seed: int, *path: str | int) -> Streams:
    """Return the streams of the match named by `path` (see `core.numerics.streams.stream`)."""
    return Streams(*(stream(root_seed, *path, "keepaway", name) for name in Streams._fields))


def n_variables(n_keepers: int, n_takers: int) -> int:
    """Return the number of state variables: 13 for 3v2."""
    return 4 * n_keepers + 2 * n_takers - 3


def new_match(config: KeepawayConfig, streams: Streams) -> Match:
    """Return a match whose first episode has been set up.

    Body directions are drawn once: resets keep them, as in the reference.
    """
    n, keepers = config.n_players, config.n_keepers
    match = Match(
        ball=np.zeros(BALL_COLUMNS),
        players=np.zeros((n, PLAYER_COLUMNS)),
        commands=np.zeros((n, COMMAND_COLUMNS)),
        status=np.zeros(STATUS_ENTRIES, np.int64),
        options=np.zeros((n, OPTION_COLUMNS), np.int64),
        started=np.zeros(n, np.bool_),
        deciding=np.zeros(keepers, np.bool_),
        actions=np.zeros(keepers, np.int64),
        variables=np.zeros((keepers, n_variables(keepers, config.n_takers))),
        order=np.zeros((keepers, n), np.int64),
        runner=np.zeros((keepers, 2), np.int64),
        meet=np.zeros((n, MEET_COLUMNS)),
        seen_ball=np.zeros((n, BALL_COLUMNS)),
        seen_players=np.zeros((n, n, PLAYER_COLUMNS)),
        ball_age=np.zeros(n, np.int64),
        player_age=np.zeros((n, n), np.int64),
        phase=np.array(config.see_phases or (0,) * n, np.int64),
        sight=np.zeros(5),
        known=np.zeros((n, n), np.bool_),
        stuck=np.full(3, np.inf),
        push=np.zeros((n + 1, 2)),
        moves=np.zeros((n + 1, 3)),
        hit=np.zeros(n + 1, np.bool_),
    )
    match.players[:, BODY] = streams.placement.uniform(-180.0, 180.0, n)
    start_episode(match, config.rules(), streams.placement)
    return match


@kernel
def start_episode(match: Match, rules: Rules, rng: np.random.Generator) -> None:
    """Put all players in place for the next episode; all forget what they have seen.

    Three keepers go to three corner boxes in a random rotation, further ones to the centre, takers to the
    fourth corner; the ball lies at rest in the first keeper corner. Body and neck directions stay.
    """
    _place(match.ball, match.players, rules, rng)
    if not rules.fixed_phases:
        _draw_phases(match.phase, rng)
    match.status[CYCLE] = 0
    match.status[TAKE_COUNT] = 0
    match.status[END] = ONGOING
    match.status[EPISODE] += 1
    match.options[:] = -1
    match.started[:] = False
    match.deciding[:] = False
    match.meet[:, MEET_CYCLE] = -2.0
    match.ball_age[:] = NEVER_SEEN
    match.player_age[:] = NEVER_SEEN
    match.known[:] = False
    match.runner[:] = -1
    match.commands[:] = 0.0
    match.hit[:] = False


@inner_kernel
def _place(ball: Floats, players: Floats, rules: Rules, rng: np.random.Generator) -> None:
    half_length, half_width = rules.half_length, rules.half_width
    turn = int(3.0 * rng.random())
    for i in range(players.shape[0]):
        u, v = CORNER_BOX * rng.random(), CORNER_BOX * rng.random()
        corner = (i + turn) % 3
        if i >= rules.n_keepers:
            x, y = u - half_length, half_width - v
        elif i >= 3:  # two of three box widths: U(-1, 1)
            x, y = u * (2.0 / CORNER_BOX) - 1.0, v * (2.0 / CORNER_BOX) - 1.0
        elif corner == 0:
            x, y = u - half_length, v - half_width
        elif corner == 1:
            x, y = half_length - u, v - half_width
        else:
            x, y = half_length - u, half_width - v
        players[i, X], players[i, Y] = x, y
        players[i, VX], players[i, VY] = 0.0, 0.0
    ball[X], ball[Y] = BALL_INSET - half_length, BALL_INSET - half_width
    ball[VX], ball[VY] = 0.0, 0.0


@inner_kernel
def _draw_phases(phase: Ints, rng: np.random.Generator) -> None:
    """Draw when each player's visual messages come: often as the one before it, else in any phase."""
    shared = 0
    for i in range(len(phase)):
        anew, drawn = rng.random() >= SHARED_PHASE, int(SEE_PERIOD * rng.random())
        if i == 0 or anew:
            shared = drawn
        phase[i] = shared


@inner_kernel
def referee(ball: Floats, players: Floats, status: Ints, rules: Rules) -> None:
    """Look once per cycle: end the episode, or count possession.

    A cycle counts for the takers when any of them can kick, even if a keeper can as well; the count goes back
    to zero only when a keeper can kick and no taker can; a loose ball leaves it as it is.
    """
    if abs(ball[X]) >= rules.half_length or abs(ball[Y]) >= rules.half_width:
        status[END] = OUT
    elif status[TAKE_COUNT] >= TAKE_CYCLES:
        status[END] = TAKEN
    elif _any_in_reach(ball, players, rules.n_keepers, players.shape[0]):
        status[TAKE_COUNT] += 1
    elif _any_in_reach(ball, players, 0, rules.n_keepers):
        status[TAKE_COUNT] = 0


@inner_kernel
def _any_in_reach(ball: Floats, players: Floats, first: int, last: int) -> bool:
    for i in range(first, last):
        if length(ball[X] - players[i, X], ball[Y] - players[i, Y]) < KICK_DISTANCE:
            return True
    return False


@inner_kernel
def is_stuck(match: Match) -> bool:
    """Return whether the ball has not left a circle of 3 m for 100 cycles; its clock starts anew then.

    The server's own rule, unnoticed in most episodes but the end of many a long hold. The clock runs on over
    resets, and looks at the last cycle of an episode, too, before all players are put back.
    """
    ball, stuck, now = match.ball, match.stuck, float(match.status[CLOCK])
    moved = not length(ball[X] - stuck[X], ball[Y] - stuck[Y]) <= STUCK_AREA
    over = not moved and now - stuck[2] >= STUCK_CYCLES
    if moved or over:
        stuck[X], stuck[Y], stuck[2] = ball[X], ball[Y], now
    return bool(over)


@inner_kernel
def drop_ball(match: Match) -> None:
    """Stop the ball where it is; players within 9.15 m of it are put back to that distance, at rest.

    Two who come to stand in one place overlap until they are parted
    (`core.keepaway.simulator.motion.collide`).
    """
    ball = match.ball
    ball[VX], ball[VY] = 0.0, 0.0
    for i in range(match.players.shape[0]):
        _clear_from_ball(ball, match.players[i])


@inner_kernel
def _clear_from_ball(ball: Floats, player: Floats) -> None:
    dx, dy = player[X] - ball[X], player[Y] - ball[Y]
    distance = length(dx, dy)
    if distance >= DROP_DISTANCE:
        return
    if distance == 0.0:
        dx, distance = 1.0, 1.0
    player[X] = ball[X] + dx * DROP_DISTANCE / distance
    player[Y] = ball[Y] + dy * DROP_DISTANCE / distance
    player[VX], player[VY] = 0.0, 0.0
