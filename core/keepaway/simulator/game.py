"""One cycle of Keepaway, in two halves around the keepers' decisions.

`begin_cycle` lets players perceive and finds who has to decide; a policy fills in `match.actions`;
`finish_cycle` commands, moves and judges. `step_cycle` is both with a benchmark policy in between. The live
loop and whole episodes run these same kernels.
"""

import numpy as np

from core.keepaway.pitch import ONGOING, Rules
from core.keepaway.simulator.arrivals import LONGEST_INTERCEPT, cycles_to_ball
from core.keepaway.simulator.match import (
    CLOCK,
    CYCLE,
    END,
    GET_OPEN,
    OPTION,
    Match,
    Streams,
    drop_ball,
    is_stuck,
    referee,
    start_episode,
)
from core.keepaway.simulator.motion import apply_commands, collide, move_all
from core.keepaway.simulator.options import (
    assign_keeper,
    can_kick,
    command_keeper,
    find_runner,
    take_decision,
    turn_neck,
)
from core.keepaway.simulator.perception import FORGET_BALL, perceive
from core.keepaway.simulator.policies import choose
from core.keepaway.simulator.takers import command_taker
from core.keepaway.simulator.variables import observe
from core.numerics.arrays import Floats
from core.numerics.compiled import called_kernel, inner_kernel, kernel


@called_kernel
def begin_cycle(match: Match, rules: Rules, streams: Streams) -> bool:
    """Perceive; put keepers into their options; mark in `match.deciding` those that have to decide.

    Returns:
        Whether any keeper decides.
    """
    perceive(match, rules, streams.perception)
    any_decides, exact, cycle = False, rules.exact_state, match.status[CYCLE]
    for i in range(rules.n_keepers):
        ball = match.ball if exact else match.seen_ball[i]
        players = match.players if exact else match.seen_players[i]
        sure = exact or match.ball_age[i] <= FORGET_BALL
        if exact and i > 0:  # all know the same
            match.runner[i, 0], match.runner[i, 1] = match.runner[0, 0], match.runner[0, 1]
        elif exact or (sure and not can_kick(players[i], ball)):
            find_runner(match.runner[i], ball, players, match.known[i], rules)
        decides, starts = assign_keeper(
            i,
            match.options[i],
            ball,
            players,
            match.known[i],
            sure,
            match.runner[i, 0],
            rules.n_keepers,
            match.order[i],
            cycle,
        )
        if decides:
            observe(i, players, rules.n_keepers, match.order[i], match.variables[i])
        match.deciding[i], match.started[i] = decides, starts
        any_decides |= decides
    return any_decides


@called_kernel
def finish_cycle(match: Match, rules: Rules, streams: Streams) -> bool:
    """Carry out the decisions in `match.actions`, command all players, move everything, and let the referee
    look.

    Returns:
        Whether the episode has ended; `match.status[END]` says how. Positions stay until `start_episode`.
    """
    match.commands[:] = 0.0
    cycle = match.status[CYCLE]
    for i in range(rules.n_keepers):
        if match.deciding[i]:
            match.started[i] = take_decision(match.options[i], match.actions[i], match.order[i], cycle)
    for i in range(rules.n_keepers + rules.n_takers):
        ball = match.ball if rules.exact_state else match.seen_ball[i]
        players = match.players if rules.exact_state else match.seen_players[i]
        row, known, meet, command = match.options[i], match.known[i], match.meet[i], match.commands[i]
        if i < rules.n_keepers:
            arrival = _arrival(match, i, ball, players, rules.exact_state) if row[OPTION] == GET_OPEN else 0
            command_keeper(i, row, ball, players, known, arrival, meet, cycle, rules, command)
        else:
            sure = rules.exact_state or match.ball_age[i] <= FORGET_BALL
            match.started[i] = command_taker(i, row, ball, players, known, sure, meet, cycle, rules, command)
        if rules.view_angle < 360.0:
            turn_neck(command, row[OPTION], ball, players[i])
    apply_commands(match.ball, match.players, match.commands, match.push, streams.turn, streams.kick)
    move_all(match.ball, match.players, match.push, streams.movement)
    collide(match.ball, match.players, match.moves, match.hit)
    match.status[CYCLE] += 1
    match.status[CLOCK] += 1
    referee(match.ball, match.players, match.status, rules)
    ended = bool(match.status[END] != ONGOING)
    if is_stuck(match) and not ended:
        drop_ball(match)
        collide(match.ball, match.players, match.moves, match.hit)
    return ended


@inner_kernel
def _arrival(match: Match, i: int, ball: Floats, players: Floats, exact: bool) -> int:
    """Return in how many cycles the keeper that keeper i believes fastest has the ball; with exact state
    reckoned once.
    """
    row = match.runner[0 if exact else i]
    if row[1] < 0:
        row[1] = LONGEST_INTERCEPT if row[0] < 0 else cycles_to_ball(players[row[0]], ball)
    return int(row[1])


@inner_kernel
def choose_all(match: Match, rules: Rules, policy: int, rng: np.random.Generator) -> None:
    """Let every deciding keeper choose by a benchmark policy."""
    for i in range(rules.n_keepers):
        if match.deciding[i]:
            match.actions[i] = choose(policy, match.variables[i], rules.n_keepers, rules.n_takers, rng)


@kernel
def step_cycle(match: Match, rules: Rules, policy: int, streams: Streams) -> bool:
    """Play one cycle with a benchmark policy; return whether the episode has ended."""
    if begin_cycle(match, rules, streams):
        choose_all(match, rules, policy, streams.policy)
    return finish_cycle(match, rules, streams)


@kernel
def next_episode(match: Match, rules: Rules, streams: Streams) -> None:
    """Set up the next episode."""
    start_episode(match, rules, streams.placement)
