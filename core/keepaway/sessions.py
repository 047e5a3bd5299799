"""Keepaway as sessions see it (`core.registry.Game`): an agent over Sarsa, one learner per keeper."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from core.domain import Choices, Domain, Features
from core.events import EpisodeEnded, StepTaken
from core.feedback.config import Knowledge
from core.feedback.viewing import Watched
from core.keepaway.action import ChosenOption
from core.keepaway.domain import HOLD, Keepaway, KeepawayState
from core.keepaway.pace import options_on_screen
from core.keepaway.participant import lay_choice, noticed_per_cycle
from core.keepaway.participant_config import KeepawayPersonConfig
from core.keepaway.pitch import CYCLE_NS, CYCLE_S, KeepawayConfig
from core.keepaway.simulator.policies import hand_coded
from core.learners.human_config import TileModel
from core.numerics.clock import NS_PER_S
from core.registry import Oracle
from core.session.protocol import Protocol
from core.session.sarsa_game import SarsaGame, recorded_observation


@dataclass(frozen=True, slots=True)
class KeepawayViewing:
    """Simulated time goes by at `speed`; an option is seen to have been chosen when its first cycle is
    over.
    """

    speed: float
    """Simulated seconds per second."""
    pause_ns: int

    @property
    def cycle_ns(self) -> int:
        """How long a cycle is on screen."""
        return round(CYCLE_NS / self.speed)

    def opening_ns(self, first: KeepawayState) -> int:
        """Return the time from the kick-off to the first decision."""
        return first.cycle * self.cycle_ns

    def watched(self, state: KeepawayState, action: int, following: KeepawayState) -> Watched:
        """Return how an option is seen: a pass is an event, a hold one of many."""
        cycles = following.cycle - state.cycle
        noticed = 1.0 if action != HOLD else noticed_per_cycle(KeepawayPersonConfig().holds_noticed_per_s)
        return Watched(cycles * self.cycle_ns, self.cycle_ns, noticed)


class KeepawayOracle:
    """What a participant would have done in the keeper's place, on what the keeper sees."""

    def __init__(self, config: KeepawayConfig, knowledge: Knowledge = "expert") -> None:
        """Judge matches of this size.

        Args:
            config: size of the game.
            knowledge: expert (the hand-coded policy) or lay (`core.keepaway.participant`).
        """
        if knowledge == "myopic":
            raise ValueError("knowledge='myopic' is not known in Keepaway: an option has no immediate effect")
        self._config = config
        self._choose = lay_choice if knowledge == "lay" else hand_coded

    def __call__(self, state: KeepawayState) -> NDArray[np.float64]:
        """Return 1 for its option and 0 for the others, shape (n,)."""
        values = np.zeros(self._config.n_actions)
        values[self._choose(state.variables, self._config.n_keepers, self._config.n_takers)] = 1.0
        return values


class KeepawayGame(SarsaGame):
    """The game whose learners learn at every step."""

    def domain(self, protocol: Protocol) -> Keepaway:
        """Return the match under the protocol's rules."""
        assert isinstance(protocol.domain, KeepawayConfig), "a protocol of Keepaway"
        model = protocol.agent.human_model
        shared = isinstance(model, TileModel) and model.shared
        return Keepaway(protocol.domain, shared_feedback=shared)

    def oracle(self, protocol: Protocol) -> Oracle:
        """Return what the protocol's simulated participant knows."""
        assert isinstance(protocol.domain, KeepawayConfig), "a protocol of Keepaway"
        return KeepawayOracle(protocol.domain, protocol.trainer.knowledge)

    def viewing(self, protocol: Protocol) -> KeepawayViewing:
        """Return cycles of 100 ms at the protocol's speed."""
        screen = protocol.screen
        return KeepawayViewing(screen.speed, round(screen.pause_between_episodes_s * NS_PER_S))

    def steps_on_screen(self, protocol: Protocol) -> tuple[Watched, ...]:
        """Return options of some episodes of an untrained and of a good team."""
        return options_on_screen(self.domain(protocol), self.viewing(protocol))

    def recorded(self, domain: Domain[KeepawayState], step: StepTaken) -> tuple[Choices, Features]:
        """Return a decision as its keeper saw it."""
        assert isinstance(domain, Keepaway), "the domain of this game"
        seen = recorded_observation(domain, step)
        chosen = ChosenOption.of(step)
        choices = domain.choices_of(chosen.keeper, seen, chosen.cycle)
        return choices, choices.feedback_features[step.action]

    def time_at_end(self, ended: EpisodeEnded) -> int:
        """Return cycles: an episode's performance is its duration in seconds."""
        return round(ended.performance / CYCLE_S)
