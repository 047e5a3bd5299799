"""What games have in common that are learned by Sarsa, decision by decision, from an observation of the
state.
"""

from abc import ABC, abstractmethod
from collections.abc import Callable, Sequence
from typing import Any
from typing import Protocol as Interface

import numpy as np
from numpy.typing import NDArray

from core.combination.agent import ArlAgent, EpisodePolicy
from core.combination.human_learner import HumanLearner
from core.domain import Choices, Domain, Features
from core.events import EpisodeEnded, StepTaken
from core.feedback.viewing import Viewing, Watched
from core.learners.sarsa_config import SarsaConfig
from core.learners.sarsa_learner import SarsaLearner
from core.numerics.tile_coding import TileCoder, Tiling
from core.registry import Oracle, Player
from core.session.protocol import Protocol
from core.session.rollout import Played, play_unseen

Tiled = Callable[[NDArray[np.float64]], NDArray[np.float64]]
"""Makes of an observation the numbers that a learner tiles."""


class ObservedDomain(Domain[Any], Interface):
    """A domain that describes the state by an observation (`Choices.observation`)."""

    @property
    def coder(self) -> TileCoder:
        """Tiling of the observation, or of what `SarsaGame.tiled` makes of it."""
        ...

    @property
    def feedback_tiles(self) -> Tiling | None:
        """What the rows of `Choices.feedback_features` index (`core.learners.encoding.ActionTiles`); None
        where they are plain features.
        """
        ...

    @property
    def n_actors(self) -> int:
        """How many learn side by side, >= 1; `Choices.actor` is below."""
        ...

    @property
    def n_actions(self) -> int:
        """Of every decision, >= 1."""
        ...

    @property
    def reward_is_time(self) -> bool:
        """Whether each unit of the domain's time brings a reward of 1, and nothing else does."""
        ...


class SarsaGame(ABC):
    """A `core.registry.Game` but for its domain, its oracle and how it is seen."""

    @abstractmethod
    def domain(self, protocol: Protocol) -> ObservedDomain:
        """Return the game under the protocol's rules."""

    @abstractmethod
    def oracle(self, protocol: Protocol) -> Oracle:
        """Return by whom simulated participants judge."""

    @abstractmethod
    def viewing(self, protocol: Protocol) -> Viewing:
        """Return how long everything is on screen."""

    @abstractmethod
    def steps_on_screen(self, protocol: Protocol) -> Sequence[Watched]:
        """Return how some hundred steps are seen at the protocol's pace, in order; the same at every call."""

    @abstractmethod
    def recorded(self, domain: Domain[Any], step: StepTaken) -> tuple[Choices, Features]:
        """Return the choices of a step whose state was recorded, and psi of what was done."""

    @abstractmethod
    def time_at_end(self, ended: EpisodeEnded) -> int:
        """Return the domain's own time when an episode ended whose recording does not say it."""

    def tiled(self, domain: ObservedDomain) -> Tiled | None:
        """Return what makes of an observation the numbers that are tiled; None: the observation itself is."""
        return None

    def agent(self, protocol: Protocol, root_seed: int) -> ArlAgent:
        """Return an agent over Sarsa, one learner per actor."""
        domain, config = self.domain(protocol), protocol.learner
        assert isinstance(config, SarsaConfig), "a protocol checks that its learner suits its game"
        learner = SarsaLearner(
            config,
            domain.coder,
            n_learners=domain.n_actors,
            n_actions=domain.n_actions,
            reward_is_time=domain.reward_is_time,
            tiled=self.tiled(domain),
        )
        return ArlAgent(
            learner,
            protocol.agent,
            n_feedback_features=len(domain.feedback_feature_names),
            n_participants=protocol.n_participants,
            credits=protocol.credit_of_participants,
            feedback_tiles=domain.feedback_tiles,
            root_seed=root_seed,
        )

    def listener(self, protocol: Protocol) -> HumanLearner:
        """Return a human model over the domain's tiles."""
        agent, domain = protocol.agent, self.domain(protocol)
        names = domain.feedback_feature_names
        return HumanLearner(agent.credit, agent.human_model, len(names), tiles=domain.feedback_tiles)

    def player(self, protocol: Protocol, agent: ArlAgent) -> Player:
        """Return what plays unseen episodes: decision by decision, as watched ones, and the learner
        learns.
        """
        domain = self.domain(protocol)

        def play(policy: EpisodePolicy, episode_seed: int, max_steps: int) -> Played:
            return play_unseen(domain, agent, policy, episode_seed, max_steps)

        return play

    def evaluate(
        self, protocol: Protocol, agent: ArlAgent, seeds: Sequence[int], *, max_steps: int
    ) -> list[Played]:
        """Play on with what has been learned, exploration included, and learn nothing."""
        domain = self.domain(protocol)
        policy = agent.next_policy(exploring=False)
        return [play_unseen(domain, agent, policy, seed, max_steps, learning=False) for seed in seeds]


def recorded_observation(domain: Domain[Any], step: StepTaken) -> NDArray[np.float64]:
    """Return the observation that a recording holds of a step, shape (v,).

    Raises:
        ValueError: it is none of this domain.
    """
    expected = len(domain.observation_names)
    if step.state is None or len(step.state) != expected:
        raise ValueError(f"need a state of {expected} variables, got {step.state}")
    return np.array(step.state, np.float64)
