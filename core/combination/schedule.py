"""Which episode an agent plays next, and which number its scheme's schedule is asked about: said here alone.

Sessions, what-ifs, evaluation and experiments all ask `next_episode`. (`docs/decisions/annealing.md`)
"""

from dataclasses import dataclass
from typing import Self

from core.combination.config import AnnealedWeight, Scheme


@dataclass(frozen=True, slots=True)
class EpisodesSoFar:
    """How many episodes of a session have begun."""

    episodes: int = 0
    """All of them, >= 0."""
    watched: int = 0
    """Those that were shown to a participant, in [0, episodes]."""

    def __post_init__(self) -> None:
        if not 0 <= self.watched <= self.episodes:
            raise ValueError(
                f"need 0 <= watched <= episodes, got {self.watched} watched of {self.episodes} episodes"
            )

    def after(self, *, watched: bool) -> Self:
        """Return the counts after one more episode, which was watched or not."""
        return type(self)(self.episodes + 1, self.watched + watched)


@dataclass(frozen=True, slots=True)
class NextEpisode:
    """The episode that comes next."""

    number: int
    """Its number in the session, watched or not, from 0: all its random choices follow from it."""
    scheduled: int
    """The number that the scheme's schedule is asked about, from 0 (`Scheme.episode_weights`)."""


def next_episode(scheme: Scheme, so_far: EpisodesSoFar) -> NextEpisode:
    """Return which episode comes next.

    Args:
        scheme: whose weight may fall with each episode or with each watched game. Schemes without a schedule
            are asked about the episode's number, which plays no part.
        so_far: what has begun.
    """
    by_game = isinstance(scheme, AnnealedWeight) and scheme.per == "watched-game"
    return NextEpisode(so_far.episodes, so_far.watched if by_game else so_far.episodes)
