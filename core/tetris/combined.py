"""Whole games in which environment and participant decide together, in compiled code; they can be stopped and
continued.

A game between two changes of the human model is one call.
"""

import numpy as np
from numpy.typing import NDArray

from core.combination.config import ENVIRONMENT_WEIGHTS, EpisodeWeights
from core.combination.preference import best_action, choose, takes_control, worst_action
from core.combination.tally import Tally, count_decision
from core.numerics.arrays import Floats, Ints
from core.numerics.compiled import kernel
from core.tetris.autoplay import best_of, worst_of
from core.tetris.board import (
    COLUMNS,
    MAX_PLACEMENTS,
    NOW,
    OVERFLOW,
    ROWS,
    SEVEN_BAG,
    allow_all,
    fill_heights,
    mark_ruled_out,
    piece_at,
    put_down,
    remove_rows,
    scan_placements,
    wall_height,
)
from core.tetris.config import MAX_COLUMNS, TetrisConfig
from core.tetris.evaluation import (
    fill_sums,
    fill_values_21,
    fill_values_any,
    fill_values_of_clearing,
    linear_policy,
)
from core.tetris.features import BERTSEKAS_21
from core.tetris.kept_game import FINISHED, LINES, PIECES, KeptGame
from core.tetris.pieces import MAX_SHAPE_SIZE


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
        self._seed = seed
        self._handover_seed = handover_seed

    def advance(self, piece_cap: int) -> None:
        """Play on until the game ends or has `piece_cap` pieces."""
        _play_combined(
            *self._environment,
            *self._human,
            self._work,
            self._rules,
            self._seed,
            piece_cap,
            self._combination.form,
            float(self._combination.w_r),
            float(self._combination.w_h),
            float(self._combination.handover),
            self._handover_seed,
            self._ring,
            self._counters,
            self.tally,
        )


@kernel
def _play_combined(
    env_code: int,
    env_table: Ints,
    env_numbers: Floats,
    human_code: int,
    human_table: Ints,
    human_numbers: Floats,
    work: Ints,
    rules: Ints,
    seed: int,
    cap: int,
    form: int,
    w_r: float,
    w_h: float,
    handover: float,
    handover_seed: int,
    ring: Ints,
    counters: Ints,
    tally: Tally,
) -> None:
    """Play on to the game's end or to `cap` pieces; the board, `ring`, `counters` and `tally` are changed."""
    n_columns, must_fit = rules[COLUMNS], rules[OVERFLOW] == 0
    env_values, human_values = np.empty(MAX_PLACEMENTS), np.empty(MAX_PLACEMENTS)
    ruled_out = np.zeros(MAX_PLACEMENTS, dtype=np.bool_)
    decision, lines = counters[PIECES], counters[LINES]
    fill_heights(work, NOW, n_columns)
    over = counters[FINISHED] != 0
    while not over:
        n = scan_placements(work, rules, piece_at(seed, decision, rules[SEVEN_BAG]))
        crowded = wall_height(work, NOW, n_columns) + MAX_SHAPE_SIZE > rules[ROWS]
        n_open = mark_ruled_out(work, rules, n, ruled_out) if crowded else allow_all(ruled_out, n)
        over = must_fit and n_open == 0
        if over or decision >= cap:
            break
        kept = decision % len(ring)
        for column in range(n_columns):
            ring[kept, column] = work[NOW, column]
        if env_code != BERTSEKAS_21:
            fill_values_any(env_code, env_numbers, work, rules, n, False, env_values)
        else:
            fill_sums(env_table, work, n_columns)
            if fill_values_21(env_table, env_numbers, work, n_columns, n, 0, env_values):
                fill_values_of_clearing(env_table, env_numbers, work, n_columns, n, 0, env_values)
        if human_code != BERTSEKAS_21:
            fill_values_any(human_code, human_numbers, work, rules, n, True, human_values)
        else:
            before = fill_sums(human_table, work, n_columns)
            if fill_values_21(human_table, human_numbers, work, n_columns, n, before, human_values):
                fill_values_of_clearing(human_table, human_numbers, work, n_columns, n, before, human_values)
        if n_open == n:
            env_best, human_best = best_of(env_values, n), best_of(human_values, n)
            human_worst = worst_of(human_values, n)
        else:
            env_best = best_action(env_values, ruled_out, n)
            human_best = best_action(human_values, ruled_out, n)
            human_worst = worst_action(human_values, ruled_out, n)
        count_decision(tally, env_best, human_best, human_worst)
        action = choose(env_values, human_values, ruled_out, n, form, w_r, w_h)
        if handover > 0.0 and takes_control(handover_seed, decision, handover):
            action = human_best
        ring[kept, MAX_COLUMNS] = place_among_offered(ruled_out, action) if must_fit else action
        full = put_down(work, NOW, action)
        if full != 0:
            lines += remove_rows(work, NOW, n_columns, full)
        decision += 1
        over = crowded and not must_fit and wall_height(work, NOW, n_columns) > rules[ROWS]
    counters[PIECES], counters[LINES], counters[FINISHED] = decision, lines, over


@kernel
def place_among_offered(ruled_out: NDArray[np.bool_], action: int) -> int:
    """Return which of the actions that are not ruled out this one is: where a piece must fit, others are not
    offered.
    """
    place = 0
    for other in range(action):
        place += not ruled_out[other]
    return place
