"""What passes between an agent, its environment's side (`core.combination.environment`), and who plays for
it.
"""

from collections.abc import Callable, Sequence
from dataclasses import dataclass, field
from typing import Literal, Protocol

import numpy as np
from numpy.typing import NDArray

from core.combination.agreement import Agreement
from core.combination.config import EpisodeWeights
from core.numerics.arrays import Floats

Drawn = Callable[[], tuple[int, Floats]]
"""Draws one of the policies that have been ranked: its number and theta."""


@dataclass(frozen=True, slots=True, eq=False)
class EpisodeStart:
    """What an environment's side has to know when an episode begins."""

    episode: int
    """Number of the episode in the session."""
    draw: Drawn | None
    """How to play one of the ranked policies instead of a proposal; None where a proposal is asked for."""
    rng: np.random.Generator
    """Of the exploration within the episode."""


@dataclass(frozen=True, slots=True, eq=False)
class StartedPolicy:
    """What an environment's side plays in the episode that has begun."""

    policy_id: int
    theta: Floats
    """Weights of the policy, shape (F,); empty where the learner changes at every step."""
    proposed: bool
    """The learner's new proposal: it waits for the performance."""


@dataclass(frozen=True, slots=True)
class EpisodeEnd:
    """What an environment's side has to know when an episode ends."""

    policy_id: int
    proposed: bool
    """As in `StartedPolicy`."""
    performance: float
    """Performance measure, >= 0."""
    terminated: bool
    """The episode came to its end; otherwise it was broken off."""
    time: int
    """The domain's own time at the end."""


@dataclass(frozen=True, slots=True, eq=False)
class HumanPreference:
    """The human side of a decision, for a learner that draws from both sides together."""

    human_values: Floats
    """H of each action, shape (n,); zeros while nothing is known."""
    episode_weights: EpisodeWeights
    """How the two are combined."""
    chance_seed: int
    """Of the episode's draws from a softmax."""
    step: int
    """Number of the decision in the episode, from 0."""
    handed_over: bool
    """Control has been handed to the human model: its choice is to be made."""


@dataclass(frozen=True, slots=True, eq=False)
class EpisodePolicy:
    """What is played in one episode."""

    episode: int
    """Number of the episode in the session, watched or not, from 0."""
    policy_id: int
    theta: NDArray[np.float64]
    """Weights of the environment policy, shape (F,); empty where the learner changes at every step."""
    human_weights: NDArray[np.float64]
    """v of the human model when the episode began, shape (G,); zeros while nothing is known."""
    trust: float
    """What the rule of trust said when the episode began. The scheme was given it, and need not go by it."""
    episode_weights: EpisodeWeights
    """How the two are combined in this episode: the weights in use."""
    handover_seed: int
    """Seed of `takes_control` (control sharing), in [0, 2**62)."""
    exploring: bool
    """The learner proposed this policy and waits for its performance."""
    chance_seed: int = 0
    """Seed of the draws from a softmax policy, in [0, 2**62)."""

    @property
    def human_known(self) -> bool:
        """Whether there is a human policy: if not, nothing is compared with it."""
        return bool(self.human_weights.any())


@dataclass(frozen=True, slots=True)
class Decision:
    """What the agent decided, and what each of its sources would have."""

    action: int
    environment_action: int
    human_action: int
    """The human policy's best action; -1 while there is none."""
    human_worst_action: int
    """The human policy's worst action; -1 while there is none."""
    of_participants: Sequence[tuple[int, int]] = field(default=(), compare=False)
    """Best and worst action of each participant's own model; -1 while it knows nothing."""


class EpisodeOutcome(Protocol):
    """How an episode went (`core.session.rollout.Played`)."""

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

    @property
    def agreement(self) -> Agreement | None:
        """Agreement of the environment policy with the human policy; None where there was none."""
        ...

    @property
    def with_each(self) -> Sequence[Agreement | None]:
        """Agreement with each participant's own model; empty where the player did not count it."""
        ...
