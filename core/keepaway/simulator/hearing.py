"""What is heard: with a narrow field of view team mates tell each other where they, the ball and an opponent
are.
"""

import math

import numpy as np

from core.keepaway.pitch import VX, VY, X, Y
from core.keepaway.simulator.match import Match
from core.keepaway.simulator.motion import copy_row, length
from core.numerics.arrays import Floats
from core.numerics.compiled import inner_kernel

STALE_BALL = 3
"""Age in cycles beyond which what a team mate says about the ball is believed."""
CONTRADICTION = 0.3
"""Difference of velocities, metres per cycle, beyond which fresher news of the ball is believed at once."""
TOLD_DISTANCE = 20.0
"""A player speaks of a ball nearer than this."""


@inner_kernel
def listen(match: Match, i: int, first: int, last: int, rng: np.random.Generator) -> None:
    """Hear one team mate of [first, last): its own place, the ball, and the opponent it saw nearest.

    Who has seen nothing in this episode yet says nothing. What is heard replaces only what oneself knows less
    well: an unseen mate, a ball older than 3 cycles, or one that moves otherwise by fresher news.
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
        copy_row(match.seen_ball[speaker], match.seen_ball[i])
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


@inner_kernel
def _is_news(ball: Floats, speaker: Floats, mine: Floats, age: int) -> bool:
    """Return whether what a mate says of the ball, just seen from where it stood, is better than what I
    believe.
    """
    if length(ball[X] - speaker[X], ball[Y] - speaker[Y]) >= TOLD_DISTANCE:
        return False
    if age > STALE_BALL:
        return True
    return bool(age > 0 and length(ball[VX] - mine[VX], ball[VY] - mine[VY]) > CONTRADICTION)


@inner_kernel
def _copy_place(told: Floats, belief: Floats) -> None:
    belief[X], belief[Y] = told[X], told[Y]
