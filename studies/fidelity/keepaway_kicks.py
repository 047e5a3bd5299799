"""Our players in the reference's logged states, kick by kick.

The server's noise is bounded. So where the ball went after a logged kick tells with certainty, not in the
mean, when our player would have kicked another way: it lies farther from where our kick would have sent it
than noise can take it.
"""

from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np

from core.keepaway.pitch import (
    ANGLE,
    BALL_DECAY,
    BALL_NOISE,
    BALL_SPEED_MAX,
    BODY,
    KICK,
    KICK_MARGIN,
    KICK_NOISE,
    KIND,
    MAX_POWER,
    POWER,
    TOUCH_DISTANCE,
)
from core.keepaway.simulator.motion import RADIANS, direction_deg, wrap_deg
from core.keepaway.simulator.prediction import own_kick_rate
from core.numerics.arrays import Floats
from studies.fidelity.keepaway_fidelity import Setting
from studies.fidelity.keepaway_rollouts import JUMP_M, LoggedEpisode, follow

ROUNDING_M = 0.02
"""What the log's own rounding of places and directions can move a ball by."""
CLEAR_M = 0.01
"""A ball this near to touching a player has been stopped by it, and tells nothing of the kick."""


@dataclass(frozen=True, slots=True)
class LoggedKick:
    """A player's cycle in which it, or our player in its place, kicked."""

    episode: int
    row: int
    """Of the state it was decided on."""
    player: int
    logged: bool
    """Whether it kicked in the reference."""
    ours: bool
    """Whether ours does."""
    missed_m: float
    """From where our kick alone would have sent the ball to where it went; nan unless both kick and nobody
    else does."""
    noise_m: float
    """The farthest that noise can take it there."""

    @property
    def another(self) -> bool:
        """Whether this was another kick than ours, or only one of both kicked."""
        return self.logged != self.ours or self.missed_m > self.noise_m


def logged_kicks(setting: Setting, episodes: list[LoggedEpisode], players: range) -> Iterator[LoggedKick]:
    """Compare every kick of these players with ours from the same state.

    Args:
        setting: a fixed policy with exact state, the one that was logged.
        episodes: as logged.
        players: whose kicks follow from the state alone: with a random policy those of the takers.
    """
    for number, row, match, _ in follow(setting, episodes):
        episode = episodes[number]
        if row == 0 or _put_back(episode, row):
            continue
        # The commands are those from the state before.
        before, kicked = row - 1, episode.kicked[row]
        for i in players:
            ours = bool(match.commands[i, KIND] == KICK)
            if not (kicked[i] or ours):
                continue
            missed = noise = np.nan
            if kicked[i] and ours and kicked.sum() == 1 and not _touched(episode, row):
                sent, noise = _sent(episode.ball[before], episode.players[before, i], match.commands[i])
                missed = float(np.linalg.norm(episode.ball[row, :2] - sent))
            yield LoggedKick(number, before, i, bool(kicked[i]), ours, missed, noise)


def _put_back(episode: LoggedEpisode, row: int) -> bool:
    """Return whether a player was put back on the way to this row."""
    moved = episode.players[row, :, :2] - episode.players[row - 1, :, :2]
    return bool(np.linalg.norm(moved, axis=1).max() > JUMP_M)


def _touched(episode: LoggedEpisode, row: int) -> bool:
    gaps = np.linalg.norm(episode.players[row, :, :2] - episode.ball[row, :2], axis=1)
    return bool(gaps.min() < TOUCH_DISTANCE + CLEAR_M)


def _sent(ball: Floats, me: Floats, command: Floats) -> tuple[Floats, float]:
    """Return where a kick sends the ball without noise, shape (2,), and how far noise can take it from there,
    metres.
    """
    way = (me[BODY] + command[ANGLE]) * RADIANS
    accel = own_kick_rate(me, ball) * command[POWER]
    velocity = ball[2:4] + accel * np.array([np.cos(way), np.sin(way)])
    gap = ball[:2] - me[:2]
    off_axis = abs(wrap_deg(direction_deg(gap[0], gap[1]) - me[BODY]))
    where = 0.5 + 0.25 * (off_axis / 180.0 + (np.linalg.norm(gap) - TOUCH_DISTANCE) / KICK_MARGIN)
    how_fast = 0.5 + 0.5 * np.linalg.norm(ball[2:4]) / (BALL_SPEED_MAX * BALL_DECAY)
    of_kick = KICK_NOISE * command[POWER] / MAX_POWER * (where + how_fast)
    of_flight = BALL_NOISE * (np.linalg.norm(velocity) + of_kick)
    return ball[:2] + velocity, float(of_kick + of_flight) + ROUNDING_M
