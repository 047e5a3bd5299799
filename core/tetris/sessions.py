"""Tetris as sessions see it (`core.registry.Game`): an agent over cross-entropy or policy gradient, whole
games unseen.
"""

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from core.combination.agent import ArlAgent, EpisodePolicy
from core.combination.config import Coach
from core.combination.human_learner import HumanLearner
from core.combination.tally import AGREED, AGREED_WORST, agreement_of
from core.domain import Choices, Domain
from core.events import EpisodeEnded, StepTaken
from core.feedback.viewing import SteadyViewing, Watched
from core.learners.cross_entropy import CrossEntropyLearner
from core.learners.cross_entropy_config import CrossEntropyConfig
from core.learners.policy_gradient import PolicyGradientLearner
from core.learners.policy_gradient_config import PolicyGradientConfig
from core.numerics.clock import NS_PER_MS, NS_PER_S
from core.registry import Oracle, Player
from core.session.protocol import Protocol
from core.session.rollout import Played
from core.tetris.action import PlacedPiece
from core.tetris.afterstate import Tetris, TetrisState
from core.tetris.combined import CombinedGame
from core.tetris.config import TetrisConfig
from core.tetris.features import feature_set
from core.tetris.oracle import TetrisOracle
from core.tetris.pace import pictures_per_piece
from core.tetris.policy_gradient import PolicyGradientGame, placement_scales

TICKS_PER_STEP = 14
"""How long a simulated step is on screen, in ticks: about what a shown piece takes."""


class TetrisGame:
    """The game whose policies are weights of a board's features."""

    def domain(self, protocol: Protocol) -> Tetris:
        """Return the board under the protocol's rules."""
        return Tetris(tetris_rules(protocol))

    def agent(self, protocol: Protocol, root_seed: int) -> ArlAgent:
        """Return an agent over the protocol's learner."""
        domain = self.domain(protocol)
        return ArlAgent(
            _learner(protocol, root_seed),
            protocol.agent,
            n_feedback_features=len(domain.feedback_feature_names),
            n_participants=protocol.n_participants,
            credits=protocol.credit_of_participants,
            root_seed=root_seed,
        )

    def listener(self, protocol: Protocol) -> HumanLearner:
        """Return a human model over the board's features."""
        agent, domain = protocol.agent, self.domain(protocol)
        return HumanLearner(agent.credit, agent.human_model, len(domain.feedback_feature_names))

    def player(self, protocol: Protocol, agent: ArlAgent) -> Player:
        """Return what plays unseen games: whole games in compiled code."""
        return tetris_player(tetris_rules(protocol), agent)

    def evaluate(
        self, protocol: Protocol, agent: ArlAgent, seeds: Sequence[int], *, max_steps: int
    ) -> list[Played]:
        """Play the agent's final policy, which does not change."""
        policy = agent.final_policy()
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

    def steps_on_screen(self, protocol: Protocol) -> tuple[Watched, ...]:
        """Return pieces of some games as a screen draws them; each is judged when it has landed."""
        tick_ns = protocol.screen.tick_ms * NS_PER_MS
        durations_ns = [pictures * tick_ns for pictures in pictures_per_piece(tetris_rules(protocol))]
        return tuple(Watched(duration_ns, duration_ns) for duration_ns in durations_ns)

    def recorded(self, domain: Domain[TetrisState], step: StepTaken) -> tuple[Choices, NDArray[np.float64]]:
        """Return a step of an imported recording, from the boards as they were seen."""
        assert isinstance(domain, Tetris), "the domain of this game"
        assert step.observed is not None, "an imported step says what was seen"
        before = tuple(step.observed["before"])
        choices = domain.choices_on(before, PlacedPiece.of(step).piece)
        after = step.observed.get("after")
        if after is None:
            return choices, np.full(choices.feedback_features.shape[1], np.nan)
        return choices, domain.feedback_difference(before, tuple(after))

    def time_at_end(self, ended: EpisodeEnded) -> int:
        """Return pieces."""
        return ended.steps


def tetris_player(config: TetrisConfig, agent: ArlAgent) -> Player:
    """Return what plays unseen games of Tetris: whole games in compiled code, in which the agent's learner
    may learn.
    """

    def play(policy: EpisodePolicy, episode_seed: int, max_steps: int) -> Played:
        game = open_game(agent, policy, episode_seed, config)
        game.advance(max_steps)
        return Played(
            performance=float(game.lines),
            steps=game.pieces,
            agreed=int(game.tally[AGREED]),
            agreed_worst=int(game.tally[AGREED_WORST]),
            ended="termination" if game.finished else "truncation",
            time=game.pieces,
            agreement=agreement_of(game.tally) if policy.human_known else None,
        )

    return play


def open_game(
    agent: ArlAgent, policy: EpisodePolicy, seed: int, config: TetrisConfig, *, window: int = 1
) -> CombinedGame | PolicyGradientGame:
    """Return a game of one episode that is about to be played in compiled code, as `agent` would play it.

    Args:
        agent: whose learner learns in it where it learns while it plays.
        policy: from the agent's `begin_episode` or `final_policy`.
        seed: of the pieces.
        config: board and rules.
        window: how many of the last decisions are kept, >= 1.
    """
    learner, scheme = agent.learner, agent.config.scheme
    if not (isinstance(learner, PolicyGradientLearner) and policy.exploring):
        return CombinedGame(
            policy.theta,
            policy.human_weights,
            seed,
            config,
            policy.episode_weights,
            handover_seed=policy.handover_seed,
            window=window,
        )
    climbs = not isinstance(scheme, Coach) or scheme.environment_too
    return PolicyGradientGame(
        learner.gradient if climbs else learner.gradient.at_rest(),
        policy.human_weights,
        seed,
        config,
        policy.episode_weights,
        chance_seed=policy.chance_seed,
        handover_seed=policy.handover_seed,
        window=window,
    )


def _learner(protocol: Protocol, root_seed: int) -> CrossEntropyLearner | PolicyGradientLearner:
    config = protocol.learner
    if isinstance(config, PolicyGradientConfig):
        return PolicyGradientLearner(config, scales=placement_scales(tetris_rules(protocol)))
    assert isinstance(config, CrossEntropyConfig), "a protocol checks that its learner suits its game"
    n_weights = len(feature_set(tetris_rules(protocol).features, tetris_rules(protocol).columns).names)
    return CrossEntropyLearner(config, n_weights=n_weights, root_seed=root_seed)


def tetris_rules(protocol: Protocol) -> TetrisConfig:
    """Return the rules of a protocol of Tetris."""
    assert isinstance(protocol.domain, TetrisConfig), "a protocol of Tetris"
    return protocol.domain
