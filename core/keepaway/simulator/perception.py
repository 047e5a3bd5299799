"""What each player believes: dead reckoning in every cycle, corrected by what it sees in two of three.

The reference's players carry soccer habits into keepaway - opponents are thought to push forward, a ball near
an opponent is thought to lie still - and these, not the rounding of what is seen, decide how well a ball is
held.
"""

import numpy as np

from core.keepaway.pitch import Rules
from core.keepaway.simulator.hearing import listen
from core.keepaway.simulator.match import NEVER_SEEN, Match
from core.keepaway.simulator.reckoning import feel_myself, reckon_ball, reckon_players, still_near_opponent
from core.keepaway.simulator.sight import NUMBER_SEEN, look, sees
from core.numerics.compiled import inner_kernel

FORGET_PLAYER = 12
"""Cycles after which a player not seen is unknown (confidence 0.88)."""
FORGET_BALL = 10


@inner_kernel
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
        # With eyes all round, a player nearby is about to be seen: no need to reckon where he went.
        sure_to_see = NUMBER_SEEN if sees(match, i) and rules.view_angle >= 360.0 else -1.0
        first, last = (rules.n_keepers, n) if i < rules.n_keepers else (0, rules.n_keepers)
        ages, beliefs, known = match.player_age[i], match.seen_players[i], match.known[i]
        feel_myself(match.players[i], beliefs[i], match.commands[i], match.hit[1 + i])
        if ages[i] < NEVER_SEEN:
            ages[i] = 0
        knows = match.ball_age[i] < NEVER_SEEN
        if knows:
            match.ball_age[i] += 1
            bumped = match.hit[0] and match.hit[1 + i]
            reckon_ball(match.seen_ball[i], beliefs[i], match.commands[i], bumped)
            still_near_opponent(match.seen_ball[i], beliefs, known, first, last)
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
