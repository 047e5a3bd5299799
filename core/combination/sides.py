"""What passes between an agent and its environment's side (`core.combination.environment`)."""

from collections.abc import Callable
from dataclasses import dataclass
from typing import Literal, Protocol

import numpy as np
from numpy.typing import NDArray

from core.combination.config import EpisodeWeights

Floats = NDArray[np.float64]
Drawn = Callable[[], tuple[int, Floats]]
"""Draws one of the policies that have been ranked: its number and theta."""


class Ending(Protocol):
    """How an episode ended (`core.rollout.Played`)."""

    @property
    def performance(self) -> float:
        """Performance measure, >= 0."""
        ...

    @property
    def ended(self) -> Literal["termination", "truncation"]:
        """Whether the episode came to its end."""
        ...

    @property
    def time(self) -> int:
        """The domain's own time at the end."""
        ...


@dataclass(frozen=True, slots=True, eq=False)
class Heard:
    """What the other side says of a decision, for those who draw from both together."""

    human_values: Floats
    """H of each action, shape (n,); zeros while nothing is known."""
    weights: EpisodeWeights
    """How the two are combined."""
    chance_seed: int
    """Of the episode's draws from a softmax."""
    step: int
    """Number of the decision in the episode, from 0."""
    handed_over: bool
    """Control has been handed to the human model: its choice is to be made."""
