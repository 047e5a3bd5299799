"""Whole games in which environment and participant decide together, in compiled code; they can be stopped and
continued.

A game between two changes of the human model is one call.
"""

import numpy as np
from numpy.typing import NDArray

from core.combination.config import ENVIRONMENT_WEIGHTS, EpisodeWeights
from core.combination.preference import KernelWeights, best_action, choose, takes_control, worst_action
from core.combination.tally import Tally, count_decision
from core.numerics.arrays import Bools, Floats, Ints
from core.numerics.compiled import inner_kernel, kernel
from core.tetris.autoplay import best_of, worst_of
from core.tetris.board import COLUMNS, MAX_PLACEMENTS, NOW, fill_heights
from core.tetris.config import TetrisConfig
from core.tetris.evaluation import LinearPolicy, fill_values, linear_policy
from core.tetris.kept_game import (
    FINISHED,
    HANDOVER_SEED,
    PIECE_SEED,
    PIECES,
    GameMemory,
    KeptGame,
    find_placements,
    put_piece,
)


class CombinedGame(KeptGame):
    """A game in which every decision combines R = theta . phi and H = v . psi (Eqs. 1 to 3)."""

    def __init__(
        self,
        environment_weights: NDArray[np.float64],
        human_weights: NDArray[np.float64],
        seed: int,
        config: TetrisConfig,
        combination: EpisodeWeights = ENVIRONMENT_WEIGHTS,
        *,
        handover_seed: int = 0,
        window: int = 1,
    ) -> None:
        """Set up a game.

        Args:
            environment_weights: theta, under `config.features`, shape (F,).
            human_weights: v, under `config.feedback_features`, shape (G,).
            seed: of the piece stream, in [0, 2**63).
            config: board and rules; `lines_in_value` must be off.
            combination: form and weights of the combination in this game.
            handover_seed: seed that decides where control is shared (`combination.handover`), in [0, 2**62).
            window: how many of the last decisions are kept, >= 1.
        """
        super().__init__(human_weights, config, combination, window=window)
        self._environment = linear_policy(environment_weights, config, config.features)
        self._seeds = np.array([seed, handover_seed], dtype=np.int64)

    def advance(self, piece_cap: int) -> None:
        """Play on until the game ends or has `piece_cap` pieces."""
        _play_combined(self._environment, self._human, self._weights, self._game, self._seeds, piece_cap)


@kernel
def _play_combined(
    environment: LinearPolicy,
    human: LinearPolicy,
    weights: KernelWeights,
    game: GameMemory,
    seeds: Ints,
    cap: int,
) -> None:
    """Play on to the game's end or to `cap` pieces; `game` is changed."""
    work, rules, counters = game.work, game.rules, game.counters
    env_values, human_values = np.empty(MAX_PLACEMENTS), np.empty(MAX_PLACEMENTS)
    ruled_out = np.zeros(MAX_PLACEMENTS, dtype=np.bool_)
    fill_heights(work, NOW, rules[COLUMNS])
    while counters[FINISHED] == 0:
        decision = counters[PIECES]
        n, n_open, crowded = find_placements(game, seeds[PIECE_SEED], ruled_out)
        if counters[FINISHED] != 0 or decision >= cap:
            break
        fill_values(
            environment.code, environment.table, environment.numbers, work, rules, n, False, env_values
        )
        fill_values(human.code, human.table, human.numbers, work, rules, n, True, human_values)
        human_best = _compare(env_values, human_values, ruled_out, n, n_open, game.tally)
        if weights.handover > 0.0 and takes_control(seeds[HANDOVER_SEED], decision, weights.handover):
            action = human_best
        else:
            action = choose(env_values, human_values, ruled_out, n, weights.form, weights.w_r, weights.w_h)
        put_piece(game, ruled_out, action, crowded)


@inner_kernel
def _compare(
    env_values: Floats, human_values: Floats, ruled_out: Bools, n: int, n_open: int, tally: Tally
) -> int:
    """Do what `core.combination.tally.compare_choices` does, faster where no action is ruled out
    (n_open = n).
    """
    if n_open == n:
        env_best, human_best = best_of(env_values, n), best_of(human_values, n)
        human_worst = worst_of(human_values, n)
    else:
        env_best = best_action(env_values, ruled_out, n)
        human_best = best_action(human_values, ruled_out, n)
        human_worst = worst_action(human_values, ruled_out, n)
    count_decision(tally, env_best, human_best, human_worst)
    return human_best
