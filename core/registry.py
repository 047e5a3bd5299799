"""What a session needs of each game, under one interface: sessions, what-ifs and simulated participants know
no game.

No game is imported here: its plugin (`core.plugins`) imports it when it is asked for, and compiled code comes
with it.
"""

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
from core.plugins import plugin_of
from core.session.protocol import Protocol
from core.session.rollout import Played

Player = Callable[[EpisodePolicy, int, int], Played]
"""Plays one unseen episode: (policy, episode seed, most steps) -> what came of it."""
Oracle = Callable[[Any], NDArray[np.float64]]
"""Values of all actions in a state, by a participant who knows the game; -inf for a fatal one."""


class Game(Interface):
    """One game, complete."""

    def domain(self, protocol: Protocol) -> Domain[Any]:
        """Return the game under the protocol's rules."""
        ...

    def agent(self, protocol: Protocol, root_seed: int) -> ArlAgent:
        """Return a new agent that has learned nothing."""
        ...

    def listener(self, protocol: Protocol) -> HumanLearner:
        """Return a new human model of the protocol's kind, without an agent."""
        ...

    def player(self, protocol: Protocol, agent: ArlAgent) -> Player:
        """Return what plays unseen episodes for an agent, which learns from them as its learner does."""
        ...

    def evaluate(
        self, protocol: Protocol, agent: ArlAgent, seeds: Sequence[int], *, max_steps: int
    ) -> list[Played]:
        """Return how an agent plays its next episode with each of these seeds, without learning from them.

        The weights are those of the agent's next episode (`ArlAgent.next_episode`), which is not counted.

        Args:
            protocol: whose rules are played.
            agent: who plays.
            seeds: of the episodes.
            max_steps: where an episode is broken off.
        """
        ...

    def oracle(self, protocol: Protocol) -> Oracle:
        """Return by whom simulated participants judge."""
        ...

    def viewing(self, protocol: Protocol) -> Viewing:
        """Return how long everything is on screen."""
        ...

    def steps_on_screen(self, protocol: Protocol) -> Sequence[Watched]:
        """Return how some hundred steps are seen at the protocol's pace, in order; the same at every call."""
        ...

    def recorded(self, domain: Domain[Any], step: StepTaken) -> tuple[Choices, Features]:
        """Return the choices of a step whose state was recorded or observed, and psi of what was done, NaN
        where unknown.

        Raises:
            ValueError: what was recorded is not a state of this game.
        """
        ...

    def time_at_end(self, ended: EpisodeEnded) -> int:
        """Return the domain's own time when an episode ended whose recording does not say it
        (`EpisodeEnded.time`).
        """
        ...


def game_of(protocol: Protocol) -> Game:
    """Return the game that a protocol is about."""
    game: Game = plugin_of(protocol).load()
    return game
