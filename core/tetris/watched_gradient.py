"""Watched sessions in which policy gradient plays and learns, in compiled code from piece to piece."""

from core.combination.agent import ArlAgent
from core.feedback.trainers import SimulatedTrainer
from core.games import Oracle
from core.learners.policy_gradient import PolicyGradientConfig, PolicyGradientLearner
from core.protocol import Protocol
from core.tetris.afterstate import Tetris
from core.tetris.policy_gradient import placement_scales
from core.tetris.sessions import tetris_rules
from core.tetris.watched import WatchedTetris


class WatchedPolicyGradient(WatchedTetris):
    """A session of `core.tetris.watched` whose environment learner climbs a gradient instead of searching.

    Every episode's policy is the learner's present one; it learns after every piece, whoever chose it.
    """

    def __init__(
        self,
        protocol: Protocol,
        gradient: PolicyGradientConfig,
        trainer: SimulatedTrainer,
        oracle: Oracle,
        *,
        root_seed: int,
        step_ns: int,
    ) -> None:
        """Sit down; the agent is made here.

        Args:
            protocol: as in `WatchedTetris`; its `learner` plays no part.
            gradient: settings of the learner.
            trainer: watches and presses.
            oracle: by which the trainer judges.
            root_seed: of the session.
            step_ns: how long each step stays on screen, > 0.
        """
        rules = tetris_rules(protocol)
        self.learner = PolicyGradientLearner(gradient, scales=placement_scales(rules))
        agent = ArlAgent(
            self.learner,
            protocol.agent,
            n_feedback_features=len(Tetris(rules).feedback_feature_names),
            root_seed=root_seed,
        )
        super().__init__(protocol, agent, trainer, oracle, root_seed=root_seed, step_ns=step_ns)
