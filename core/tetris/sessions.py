"""Tetris as sessions see it (`core.games.Game`): an agent over the cross-entropy method, whole games unseen."""

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from core.clock import NS_PER_S
from core.combination.agent import ArlAgent, EpisodePolicy
from core.combination.human_learner import HumanLearner
from core.domain import Choices, Domain
from core.episode import StepTaken
from core.feedback.viewing import SteadyViewing
from core.games import Oracle, Player
from core.keys import NS_PER_MS
from core.learners.cross_entropy import CrossEntropyLearner
from core.learners.cross_entropy_config import CrossEntropyConfig
from core.protocol import Protocol
from core.rollout import Played
from core.tetris.afterstate import Tetris, TetrisState
from core.tetris.combined import play_combined
from core.tetris.config import TetrisConfig
from core.tetris.oracle import TetrisOracle

TICKS_PER_STEP = 14
"""How long a simulated step is on screen, in ticks: about what a shown piece takes."""


class TetrisGame:
    """The one game whose policies are searched for."""

    def domain(self, protocol: Protocol) -> Tetris:
        """Return the board under the protocol's rules."""
        return Tetris(tetris_rules(protocol))

    def agent(self, protocol: Protocol, root_seed: int) -> ArlAgent:
        """Return an agent over the cross-entropy method."""
        domain = self.domain(protocol)
        learner = protocol.learner
        assert isinstance(learner, CrossEntropyConfig), "a protocol checks that its learner suits its game"
        return ArlAgent(
            CrossEntropyLearner(learner, n_weights=len(domain.feature_names), root_seed=root_seed),
            protocol.agent,
            n_feedback_features=len(domain.feedback_feature_names),
            root_seed=root_seed,
        )

    def listener(self, protocol: Protocol) -> HumanLearner:
        """Return a human model over the board's features."""
        agent, domain = protocol.agent, self.domain(protocol)
        return HumanLearner(agent.credit, agent.human_model, len(domain.feedback_feature_names))

    def player(self, protocol: Protocol, agent: ArlAgent) -> Player:
        """Return what plays unseen games: whole games in compiled code."""
        return tetris_player(tetris_rules(protocol))

    def evaluate(
        self, protocol: Protocol, agent: ArlAgent, seeds: Sequence[int], *, max_steps: int, episode: int
    ) -> list[Played]:
        """Play the agent's final policy, which does not change."""
        policy = agent.final_policy(episode)
        play = self.player(protocol, agent)
        return [play(policy, seed, max_steps) for seed in seeds]

    def oracle(self, protocol: Protocol) -> Oracle:
        """Return what the protocol's simulated participant knows."""
        return TetrisOracle(tetris_rules(protocol), protocol.trainer.knowledge)

    def viewing(self, protocol: Protocol) -> SteadyViewing:
        """Return a pace of `TICKS_PER_STEP` ticks per piece."""
        screen = protocol.screen
        return SteadyViewing(
            step_ns=TICKS_PER_STEP * screen.tick_ms * NS_PER_MS,
            pause_ns=round(screen.pause_between_episodes_s * NS_PER_S),
        )

    def observed(self, domain: Domain[TetrisState], step: StepTaken) -> tuple[Choices, NDArray[np.float64]]:
        """Return a step of an imported recording, from the boards as they were seen."""
        assert isinstance(domain, Tetris), "the domain of this game"
        assert step.observed is not None, "an imported step says what was seen"
        before = tuple(step.observed["before"])
        choices = domain.choices_on(before, step.detail["piece"])
        after = step.observed.get("after")
        if after is None:
            return choices, np.full(choices.feedback_features.shape[1], np.nan)
        return choices, domain.feedback_difference(before, tuple(after))


def tetris_player(config: TetrisConfig) -> Player:
    """Return what plays unseen games of Tetris: whole games in compiled code."""

    def play(policy: EpisodePolicy, episode_seed: int, max_steps: int) -> Played:
        episode = play_combined(
            policy.theta,
            policy.human_weights,
            episode_seed,
            config,
            policy.weights,
            share_seed=policy.share_seed,
            piece_cap=max_steps,
        )
        return Played(
            performance=float(episode.lines),
            steps=episode.n_decisions,
            agreed=episode.n_agree,
            agreed_worst=episode.n_agree_worst,
            ended="termination" if episode.finished else "truncation",
            time=episode.n_decisions,
        )

    return play


def tetris_rules(protocol: Protocol) -> TetrisConfig:
    """Return the rules of a protocol of Tetris."""
    assert isinstance(protocol.domain, TetrisConfig), "a protocol of Tetris"
    return protocol.domain
