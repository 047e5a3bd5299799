"""What a keeper does in a cycle: which option it is in, and the command that option asks for.

A keeper that can kick decides (an SMDP decision), except while it is carrying out a pass. Without the ball the
keeper fastest to it goes to it and the others get open; with no idea where the ball is a keeper searches.
"""

import numpy as np
from numpy.typing import NDArray

from core.compiled import kernel
from core.keepaway.intercept import fastest_to_ball, go_to_ball
from core.keepaway.kicking import KEEPER_HOLD_RATIO, hold_ball, nearest_to, pass_ball
from core.keepaway.match import (
    ACTION,
    ACTION_CYCLE,
    CYCLE,
    GET_OPEN,
    GO_TO_BALL,
    HOLD_BALL,
    OPTION,
    PASS_BALL,
    SEARCH_BALL,
    START,
    TARGET,
    Match,
)
from core.keepaway.motion import direction_deg, length, wrap_deg
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
from core.keepaway.positioning import get_open
from core.keepaway.prediction import BALL_ROLL, cut, send_turn
from core.keepaway.variables import observe

Floats = NDArray[np.float64]
Bools = NDArray[np.bool_]
KEEPERS_FACE = 0.0
"""Direction of play of the keepers' team, degrees."""
SEARCH_TURN = 60.0


@kernel
def begin_option(match: Match, i: int, option: int, target: int, anew: bool) -> None:
    """Put player i into an option; it starts now if it is another one, or if it was chosen `anew`."""
    row = match.options[i]
    match.started[i] = anew or row[OPTION] != option or row[TARGET] != target
    if match.started[i]:
        row[OPTION], row[TARGET], row[START] = option, target, match.status[CYCLE]


@kernel
def can_kick(me: Floats, ball: Floats) -> bool:
    """Return whether a player (row of x, y, ...) has the ball within its kick distance."""
    return length(ball[X] - me[X], ball[Y] - me[Y]) < KICK_DISTANCE


@kernel
def open_decision(match: Match, i: int, rules: Rules, players: Floats, known: Bools) -> bool:
    """Prepare the decision of keeper i, which can kick; return whether it has one to make.

    No decision while its pass is still being carried out, nor while some player is out of its knowledge: then it
    holds, and nothing is learned.
    """
    row = match.options[i]
    if row[ACTION] > 0 and row[ACTION_CYCLE] == match.status[CYCLE] - 1 and known[row[TARGET]]:
        row[ACTION_CYCLE] = match.status[CYCLE]
        begin_option(match, i, PASS_BALL, row[TARGET], False)
        return False
    if not np.all(known):
        begin_option(match, i, HOLD_BALL, -1, False)
        return False
    observe(i, players, rules.n_keepers, match.order[i], match.variables[i])
    return True


@kernel
def take_decision(match: Match, i: int) -> None:
    """Start the option that keeper i has decided on (`match.actions[i]`)."""
    action = match.actions[i]
    if action > 0:
        begin_option(match, i, PASS_BALL, match.order[i, action], True)
    else:
        begin_option(match, i, HOLD_BALL, -1, True)
    match.options[i, ACTION] = action
    match.options[i, ACTION_CYCLE] = match.status[CYCLE]


@kernel
def assign_keeper(
    match: Match, i: int, rules: Rules, ball: Floats, players: Floats, knows_ball: bool
) -> None:
    """Find the option of keeper i, or mark it as deciding.

    Args:
        match: in place.
        i: the keeper.
        rules: size of the game.
        ball: as keeper i believes.
        players: as keeper i believes.
        knows_ball: whether it knows where the ball is.
    """
    match.deciding[i] = False
    if not knows_ball:
        begin_option(match, i, SEARCH_BALL, -1, False)
    elif can_kick(players[i], ball):
        match.deciding[i] = open_decision(match, i, rules, players, match.known[i])
    elif match.runner[i, 0] == i:
        begin_option(match, i, GO_TO_BALL, -1, False)
    else:
        begin_option(match, i, GET_OPEN, -1, False)


@kernel
def command_keeper(match: Match, i: int, rules: Rules, ball: Floats, players: Floats) -> None:
    """Write this cycle's command of keeper i, whose option has been found."""
    known, arrival = match.known[i], match.runner[i, 1]
    option, target = match.options[i, OPTION], match.options[i, TARGET]
    me, command = players[i], match.commands[i]
    n_keepers, n = rules.n_keepers, players.shape[0]
    if option == HOLD_BALL:
        hold_ball(me, ball, players, known, n_keepers, n, KEEPER_HOLD_RATIO, KEEPERS_FACE, command)
    elif option == PASS_BALL:
        rival = nearest_to(ball[X], ball[Y], players, known, n_keepers, n)[1]
        pass_ball(me, ball, players[target, X], players[target, Y], rival, command)
    elif option == GO_TO_BALL:
        rival = nearest_to(me[X], me[Y], players, known, n_keepers, n)[1]
        go_to_ball(me, ball, match.meet[i], match.status[CYCLE], rival, KEEPERS_FACE, command)
    elif option == GET_OPEN:
        from_x = ball[X] + BALL_ROLL[arrival] * ball[VX]
        from_y = ball[Y] + BALL_ROLL[arrival] * ball[VY]
        get_open(
            i, ball, from_x, from_y, players, known, n_keepers, rules.half_length, rules.half_width, command
        )
    else:
        send_turn(SEARCH_TURN, length(me[VX], me[VY]), command)


@kernel
def find_runner(match: Match, i: int, rules: Rules, ball: Floats, players: Floats) -> None:
    """Write to `match.runner[i]` which keeper is, as keeper i believes, fastest to the ball, and its cycles."""
    runner, cycles = fastest_to_ball(ball, players, match.known[i], 0, rules.n_keepers)
    match.runner[i, 0], match.runner[i, 1] = runner, cycles


@kernel
def turn_neck(command: Floats, option: int, ball: Floats, me: Floats) -> None:
    """Look at the ball; while getting open, at the centre of the region; while searching, straight ahead."""
    x, y = ball[X], ball[Y]
    if option == GET_OPEN:
        x, y = 0.0, 0.0
    wanted = wrap_deg(direction_deg(x - me[X], y - me[Y]) - me[BODY])
    if command[KIND] == TURN:  # the body's turn takes the head along
        wanted = wrap_deg(wanted - command[ANGLE] / (1.0 + INERTIA * length(me[VX], me[VY])))
    if option == SEARCH_BALL:
        wanted = 0.0
    wanted = min(max(wanted, -NECK_MAX_DEG), NECK_MAX_DEG)
    command[NECK_TURN] = cut(wanted - me[NECK])
