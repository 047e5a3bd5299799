"""Takes the pictures of a match that is played cycle by cycle."""

from collections import deque
from typing import Final

import numpy as np

from core.keepaway.picture import PitchFrame, Place, PlayerView
from core.keepaway.pitch import BODY, CYCLE_S, KICK_DISTANCE, NO_PLAYER, KeepawayConfig, X, Y
from core.keepaway.simulator.match import ACTION, CYCLE, END, EPISODE, TARGET, Match

TRAIL_CYCLES: Final = 5
"""How many earlier places of the ball a picture shows."""


class FrameMaker:
    """Follows one match: it knows the ball's last places and whose option is on screen.

    An option is on screen from its decision until any keeper decides again, or the episode ends.
    """

    def __init__(self, config: KeepawayConfig) -> None:
        self.config = config
        self._trail: deque[Place] = deque(maxlen=TRAIL_CYCLES + 1)
        self._at = (NO_PLAYER, NO_PLAYER)
        self._decision = (NO_PLAYER, NO_PLAYER)

    def look(self, match: Match) -> PitchFrame:
        """Return the picture of a match that has just been set up or has just finished a cycle."""
        episode, cycle = int(match.status[EPISODE]), int(match.status[CYCLE])
        ball = (float(match.ball[X]), float(match.ball[Y]))
        holder = _holder(match)
        if (episode, cycle) != self._at:
            if episode != self._at[0]:
                self._trail.clear()
                self._decision = (NO_PLAYER, NO_PLAYER)
            self._at = (episode, cycle)
            self._trail.append(ball)
            self._note_decision(match)
        decider, target = self._decision
        return PitchFrame(
            length_m=self.config.length_m,
            width_m=self.config.width_m,
            n_keepers=self.config.n_keepers,
            players=tuple(
                PlayerView(float(row[X]), float(row[Y]), float(row[BODY])) for row in match.players
            ),
            ball=ball,
            trail=tuple(self._trail)[:-1],
            episode=episode,
            cycle=cycle,
            time_s=cycle * CYCLE_S,
            holder=holder,
            decider=decider,
            target=target,
            ended=int(match.status[END]),
        )

    def _note_decision(self, match: Match) -> None:
        """Where two keepers decide in the same cycle, the nearer one to the ball is shown."""
        deciding = np.flatnonzero(match.deciding)
        if len(deciding):
            keeper = int(min(deciding, key=lambda i: _distance(match, int(i))))
            row = match.options[keeper]
            self._decision = (keeper, int(row[TARGET]) if row[ACTION] > 0 else NO_PLAYER)


def _distance(match: Match, player: int) -> float:
    """Return how far a player is from the ball, metres."""
    return float(np.hypot(*(match.players[player, : Y + 1] - match.ball[: Y + 1])))


def _holder(match: Match) -> int:
    """Return the nearest player that can kick the ball, or nobody."""
    distances = np.hypot(match.players[:, X] - match.ball[X], match.players[:, Y] - match.ball[Y])
    nearest = int(distances.argmin())
    return nearest if distances[nearest] < KICK_DISTANCE else NO_PLAYER
