"""What a keeper does in a cycle: which option it is in, and the command that option asks for.

A keeper that can kick decides (an SMDP decision), except while it is carrying out a pass. Without the ball
the keeper fastest to it goes to it and the others get open; with no idea where the ball is a keeper searches.
"""

import numpy as np

from core.keepaway.pitch import (
    ANGLE,
    BODY,
    INERTIA,
    KICK_DISTANCE,
    KIND,
    NECK,
    NECK_MAX_DEG,
    NECK_TURN,
    TURN,
    VX,
    VY,
    Rules,
    X,
    Y,
)
from core.keepaway.simulator.arrivals import keeper_to_go
from core.keepaway.simulator.intercept import go_to_ball
from core.keepaway.simulator.kicking import KEEPER_HOLD_RATIO, hold_ball, nearest_to, pass_ball
from core.keepaway.simulator.match import (
    ACTION,
    ACTION_CYCLE,
    GET_OPEN,
    GO_TO_BALL,
    HOLD_BALL,
    OPTION,
    PASS_BALL,
    SEARCH_BALL,
    START,
    TARGET,
)
from core.keepaway.simulator.motion import direction_deg, length, wrap_deg
from core.keepaway.simulator.positioning import get_open
from core.keepaway.simulator.prediction import BALL_ROLL, cut, send_turn, step_meant
from core.keepaway.simulator.variables import sort_by_distance
from core.numerics.arrays import Bools, Floats, Ints
from core.numerics.compiled import inner_kernel

KEEPERS_FACE = 0.0
"""Direction of play of the keepers' team, degrees."""
SEARCH_TURN = 60.0


@inner_kernel
def begin_option(row: Ints, option: int, target: int, anew: bool, cycle: int) -> bool:
    """Put the player of this row of `Match.options` into an option.

    Returns:
        Whether it starts now: if it is another one, or if it was chosen `anew`.
    """
    starts = anew or row[OPTION] != option or row[TARGET] != target
    if starts:
        row[OPTION], row[TARGET], row[START] = option, target, cycle
    return bool(starts)


@inner_kernel
def can_kick(me: Floats, ball: Floats) -> bool:
    """Return whether a player (row of x, y, ...) has the ball within its kick distance."""
    return length(ball[X] - me[X], ball[Y] - me[Y]) < KICK_DISTANCE


@inner_kernel
def open_decision(
    i: int, row: Ints, players: Floats, known: Bools, n_keepers: int, order: Ints, cycle: int
) -> tuple[bool, bool]:
    """Find what keeper i, who can kick, does: returns (whether it decides, whether its option starts now).

    No decision while its pass is still being carried out, nor while some player is out of its knowledge: then
    it holds, and nothing is learned. What is carried out is "pass to the a-th nearest": the player who is
    that in this cycle, so that a pass takes a new aim, and time, when two receivers change places in the
    order.
    """
    if row[ACTION] > 0 and row[ACTION_CYCLE] == cycle - 1:
        sort_by_distance(i, players, 0, n_keepers, order)
        target = order[row[ACTION]]
        if known[target]:
            row[ACTION_CYCLE], row[TARGET] = cycle, target
            return False, begin_option(row, PASS_BALL, target, False, cycle)
    if not np.all(known):
        return False, begin_option(row, HOLD_BALL, -1, False, cycle)
    return True, False


@inner_kernel
def take_decision(row: Ints, action: int, order: Ints, cycle: int) -> bool:
    """Start the option a keeper has decided on; `order` holds the players by distance. Returns True."""
    row[ACTION], row[ACTION_CYCLE] = action, cycle
    if action > 0:
        return begin_option(row, PASS_BALL, order[action], True, cycle)
    return begin_option(row, HOLD_BALL, -1, True, cycle)


@inner_kernel
def assign_keeper(
    i: int,
    row: Ints,
    ball: Floats,
    players: Floats,
    known: Bools,
    knows_ball: bool,
    runner: int,
    n_keepers: int,
    order: Ints,
    cycle: int,
) -> tuple[bool, bool]:
    """Find the option of keeper i: returns (whether it decides, whether its option starts now).

    Args:
        i: the keeper.
        row: its row of `Match.options`, in place.
        ball: as keeper i believes.
        players: as keeper i believes.
        known: which players it knows the place of.
        knows_ball: whether it knows where the ball is.
        runner: the keeper it believes fastest to the ball.
        n_keepers: keepers have the first indices.
        order: the keepers by distance from keeper i, filled in where its pass goes on, (n,).
        cycle: of the episode.
    """
    if not knows_ball:
        return False, begin_option(row, SEARCH_BALL, -1, False, cycle)
    if can_kick(players[i], ball):
        return open_decision(i, row, players, known, n_keepers, order, cycle)
    option = GO_TO_BALL if runner == i else GET_OPEN
    return False, begin_option(row, option, -1, False, cycle)


@inner_kernel
def command_keeper(
    i: int,
    row: Ints,
    ball: Floats,
    players: Floats,
    known: Bools,
    arrival: int,
    meet: Floats,
    cycle: int,
    rules: Rules,
    command: Floats,
) -> None:
    """Write this cycle's command of keeper i, whose option has been found.

    Args:
        i: the keeper.
        row: its row of `Match.options`.
        ball: as keeper i believes.
        players: as keeper i believes.
        known: which players it knows the place of.
        arrival: cycles until a player is believed to reach the ball; used while it gets open.
        meet: its memory of the last meeting point, in place.
        cycle: of the episode.
        rules: size of the game.
        command: out.
    """
    option, target, me = row[OPTION], row[TARGET], players[i]
    n_keepers, n = rules.n_keepers, players.shape[0]
    if option == HOLD_BALL:
        hold_ball(me, ball, players, known, n_keepers, n, KEEPER_HOLD_RATIO, KEEPERS_FACE, command)
    elif option == PASS_BALL:
        rival = nearest_to(ball[X], ball[Y], players, known, n_keepers, n)[1]
        pass_ball(me, ball, players[target, X], players[target, Y], rival, command)
    elif option == GO_TO_BALL:
        rival = nearest_to(me[X], me[Y], players, known, n_keepers, n)[1]
        go_to_ball(me, ball, meet, cycle, rival, KEEPERS_FACE, command)
    elif option == GET_OPEN:
        from_x = ball[X] + BALL_ROLL[arrival] * ball[VX]
        from_y = ball[Y] + BALL_ROLL[arrival] * ball[VY]
        get_open(
            i, ball, from_x, from_y, players, known, n_keepers, rules.half_length, rules.half_width, command
        )
    else:
        send_turn(SEARCH_TURN, length(me[VX], me[VY]), command)


@inner_kernel
def find_runner(runner: Ints, ball: Floats, players: Floats, known: Bools, rules: Rules) -> None:
    """Write which keeper is believed to have to go to the ball, and -1 for not yet reckoned, to `runner`,
    shape (2,).
    """
    runner[0], runner[1] = keeper_to_go(ball, players, known, rules.n_keepers), -1


@inner_kernel
def turn_neck(command: Floats, option: int, ball: Floats, me: Floats) -> None:
    """Look at the ball; while getting open, at the centre of the region; while searching, straight ahead.

    Aims from where this cycle's command takes the player to where the ball will be then. Who holds or passes
    the ball leaves its neck alone: in the reference's logs no neck of a kicking player moves.
    """
    if option in (HOLD_BALL, PASS_BALL):
        return
    x, y = ball[X] + ball[VX], ball[Y] + ball[VY]
    if option == GET_OPEN:
        x, y = 0.0, 0.0
    step_x, step_y = step_meant(me, command)
    wanted = wrap_deg(direction_deg(x - me[X] - step_x, y - me[Y] - step_y) - me[BODY])
    if command[KIND] == TURN:  # the body's turn takes the head along
        wanted = wrap_deg(wanted - command[ANGLE] / (1.0 + INERTIA * length(me[VX], me[VY])))
    if option == SEARCH_BALL:
        wanted = 0.0
    wanted = min(max(wanted, -NECK_MAX_DEG), NECK_MAX_DEG)
    command[NECK_TURN] = cut(wanted - me[NECK])
