"""Watched sessions in which policy gradient plays and learns, in compiled code from piece to piece."""

from collections import deque

import numpy as np
from numpy.typing import NDArray

from core.combination.agent import ArlAgent, EpisodePolicy
from core.combination.config import EpisodeWeights
from core.feedback.trainers import SimulatedTrainer
from core.games import Oracle
from core.learners.policy_gradient import PolicyGradientConfig, PolicyGradientLearner
from core.protocol import Protocol
from core.streams import stream_seed
from core.tetris.afterstate import Tetris
from core.tetris.policy_gradient import PolicyGradientGame, placement_scales
from core.tetris.sessions import tetris_rules
from core.tetris.watched import Game, WatchedTetris


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

    def _new_game(self, policy: EpisodePolicy, seed: int, window: int) -> Game:
        game = PolicyGradientGame(
            self.learner.gradient,
            seed,
            self._rules,
            chance_seed=stream_seed(self._root_seed, "softmax", self._episode) >> 1,
            share_seed=policy.share_seed,
        )
        return _KeepingGame(game, policy.human_weights, policy.weights, window)

    def _game_over(self) -> None:
        self.learner.gradient.end_episode()


class _KeepingGame:
    """A game that remembers its last decisions."""

    def __init__(
        self,
        game: PolicyGradientGame,
        human_weights: NDArray[np.float64],
        combination: EpisodeWeights,
        window: int,
    ) -> None:
        self._game = game
        self._human_weights = human_weights
        self._combination = combination
        self._kept: deque[tuple[tuple[int, ...], int]] = deque(maxlen=window)

    @property
    def pieces(self) -> int:
        return self._game.pieces

    @property
    def lines(self) -> int:
        return self._game.episode.lines

    @property
    def finished(self) -> bool:
        return self._game.finished

    @property
    def agreed(self) -> int:
        return self._game.episode.n_agree

    @property
    def agreed_worst(self) -> int:
        return self._game.episode.n_agree_worst

    def advance(self, piece_cap: int) -> None:
        # A game ends unannounced, and its last decisions are wanted: so each is kept when it is made.
        while not self._game.finished and self._game.pieces < piece_cap:
            before, columns = self._game.pieces, self._game.columns
            self._game.advance(before + 1, self._human_weights, self._combination)
            if self._game.pieces > before:
                self._kept.append((columns, self._game.last_action))

    def set_human_weights(self, human_weights: NDArray[np.float64]) -> None:
        self._human_weights = human_weights

    def kept(self, decision: int) -> tuple[tuple[int, ...], int]:
        place = decision - self._game.pieces
        if not -len(self._kept) <= place < 0:
            raise ValueError(f"decision {decision} is not one of the last {len(self._kept)}")
        return self._kept[place]
