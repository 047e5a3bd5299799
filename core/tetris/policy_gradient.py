"""Whole games of Tetris in compiled code in which a policy-gradient learner plays, with a human model, and
learns.

The policy is a softmax over placements (Kakade 2001), of f(R, H) where there is a human model
(`core.combination.preference`). A game is columns and counters, so it can be stopped and continued: the human
model may change between two pieces.
"""

from functools import lru_cache

import numpy as np
from numpy.typing import NDArray

from core.combination.config import ENVIRONMENT_WEIGHTS, EpisodeWeights
from core.combination.preference import choose, fill_logits, takes_control
from core.combination.tally import Tally, compare_choices
from core.learners.linear import action_values
from core.learners.policy_gradient import PolicyGradient
from core.learners.policy_gradient_kernels import Memory, fill_score, learn_from_reward, remember_score
from core.numerics.arrays import Floats, Ints
from core.numerics.compiled import inner_kernel, kernel
from core.numerics.counters import uniform_at
from core.numerics.softmax import drawn, softmax
from core.numerics.streams import stream_seed
from core.tetris.afterstate import Tetris
from core.tetris.board import (
    COLUMNS,
    FEATURES,
    FEATURES_BEFORE,
    FULL,
    LEFT,
    MAX_PLACEMENTS,
    NOW,
    OVERFLOW,
    ROW,
    ROWS,
    SEVEN_BAG,
    SHAPE,
    allow_all,
    fill_heights,
    mark_ruled_out,
    piece_at,
    put_down,
    remove_rows,
    scan_placements,
    wall_height,
)
from core.tetris.combined import place_among_offered
from core.tetris.config import MAX_COLUMNS, TetrisConfig
from core.tetris.evaluation import fill_values
from core.tetris.features import BERTSEKAS_21, feature_set, fill_after, fill_bertsekas
from core.tetris.kept_game import FINISHED, LINES, PIECES, KeptGame
from core.tetris.pieces import MAX_SHAPE_SIZE, SHAPE_TOPS, SHAPE_WIDTHS

N_SCALE_GAMES = 20
"""Random games behind `placement_scales`."""
TETROMINO_CELLS = 4


class PolicyGradientGame(KeptGame):
    """One episode in which the learner plays and learns; agreement is counted where there is a human
    policy.
    """

    def __init__(
        self,
        learner: PolicyGradient,
        human_weights: NDArray[np.float64],
        seed: int,
        config: TetrisConfig,
        combination: EpisodeWeights = ENVIRONMENT_WEIGHTS,
        *,
        chance_seed: int,
        handover_seed: int = 0,
        window: int = 1,
    ) -> None:
        """Set up a game; the learner begins an episode, and whoever asked for it ends it (`end_episode`).

        Args:
            learner: with one weight per feature of `config.features`; learns in place. The reward of a
                decision is the number of lines it clears (and `combination.shaping` times H).
            human_weights: v, under `config.feedback_features`, shape (G,); all 0 while there is no human
                policy.
            seed: of the piece stream, in [0, 2**63).
            config: board and rules; `lines_in_value` must be off.
            combination: form and weights of the combination in this game.
            chance_seed: seed of the draws from the softmax, in [0, 2**62).
            handover_seed: seed that decides where control is shared, in [0, 2**62).
            window: how many of the last decisions are kept, >= 1.
        """
        features = feature_set(config.features, config.columns)
        if learner.scales.shape != (len(features.names),):
            raise ValueError(
                f"{config.features} on {config.columns} columns has {len(features.names)} features, "
                f"the learner {len(learner.scales)}"
            )
        super().__init__(human_weights, config, combination, window=window)
        self._memory = learner.memory
        self._code = features.code
        self._units = features.denominators * learner.scales
        self._seeds = np.array([seed, handover_seed, chance_seed], dtype=np.int64)
        learner.begin_episode()

    def advance(self, piece_cap: int) -> None:
        """Play on until the game ends or has `piece_cap` pieces."""
        combination = self._combination
        _play_on(
            self._memory,
            self._code,
            self._units,
            *self._human,
            self._human_known,
            self._work,
            self._rules,
            self._seeds,
            piece_cap,
            combination.form,
            float(combination.w_r),
            float(combination.w_h),
            float(combination.handover),
            float(combination.shaping),
            self._ring,
            self._counters,
            self.tally,
        )

    def set_human_weights(self, human_weights: NDArray[np.float64]) -> None:
        """Go on with another human model; all 0: there is no human policy."""
        super().set_human_weights(human_weights)
        self._human_known = bool(np.any(human_weights))


@lru_cache(maxsize=16)
def _placement_scales(config: TetrisConfig) -> tuple[float, ...]:
    domain = Tetris(config)
    squares, decisions = np.zeros(len(domain.feature_names)), 0
    for game in range(N_SCALE_GAMES):
        state = domain.initial(stream_seed(0, "placement-scales", game))
        while not domain.terminal(state):
            features = domain.choices(state).features
            squares += features.var(axis=0)
            decisions += 1
            point = uniform_at(game, state.k)
            state = domain.transition(state, int(point * len(features))).next_state
    sd = np.sqrt(squares / max(decisions, 1))
    return tuple(float(scale) for scale in 2.0 ** np.rint(np.log2(np.where(sd > 0, sd, 1.0))))


def placement_scales(config: TetrisConfig) -> NDArray[np.float64]:
    """Return what each feature of `config.features` is divided by for learning by gradient, shape (F,).

    That is its spread among the placements of one decision, the root mean square over games of random
    placements, rounded to a power of two: then division is exact, and the last bits of a mean decide nothing.
    """
    return np.array(_placement_scales(config))


@kernel
def _fill_rows(code: int, units: Floats, work: Ints, rules: Ints, n: int, rows: Floats) -> None:
    """Write the scaled features of the first n placements, shape (>= n, F)."""
    n_columns = rules[COLUMNS]
    if code == BERTSEKAS_21:
        fill_bertsekas(work, NOW, FEATURES_BEFORE, n_columns)
    for action in range(n):
        if code == BERTSEKAS_21 and work[FULL, action] == 0:
            _fill_bertsekas_after(work, n_columns, action)
        else:
            fill_after(code, work, rules, action)
        _write_row(work, units, rows, action)


@inner_kernel
def _fill_bertsekas_after(work: Ints, n_columns: int, action: int) -> None:
    """Write the 21 features after a placement that fills no row, from those before it (FEATURES_BEFORE).

    Only the columns of the piece change, and the differences at their edges.
    """
    shape, left, row = work[SHAPE, action], work[LEFT, action], work[ROW, action]
    width = SHAPE_WIDTHS[shape]
    maximum, holes = 2 * n_columns - 1, 2 * n_columns
    for i in range(holes + 1):
        work[FEATURES, i] = work[FEATURES_BEFORE, i]
    for offset in range(width):
        column = left + offset
        height = row + SHAPE_TOPS[shape, offset]
        work[FEATURES, holes] += height - work[FEATURES, column]
        work[FEATURES, column] = height
        work[FEATURES, maximum] = max(work[FEATURES, maximum], height)
    work[FEATURES, holes] -= TETROMINO_CELLS
    for column in range(max(left - 1, 0), min(left + width, n_columns - 1)):
        work[FEATURES, n_columns + column] = abs(work[FEATURES, column] - work[FEATURES, column + 1])


@inner_kernel
def _write_row(work: Ints, units: Floats, rows: Floats, action: int) -> None:
    for i in range(len(units)):
        rows[action, i] = work[FEATURES, i] / units[i]


# One episode step by step: the loop is the algorithm, and splitting it would hand a dozen arrays around (60
# lines).
@kernel
def _play_on(
    memory: Memory,
    code: int,
    units: Floats,
    human_code: int,
    human_table: Ints,
    human_numbers: Floats,
    human_known: bool,
    work: Ints,
    rules: Ints,
    seeds: Ints,
    cap: int,
    form: int,
    w_r: float,
    w_h: float,
    handover: float,
    shaping: float,
    ring: Ints,
    counters: Ints,
    tally: Tally,
) -> None:
    """Play on to the game's end or to `cap` pieces; memory, board, `ring`, `counters` and `tally` are
    changed.
    """
    n_columns, must_fit = rules[COLUMNS], rules[OVERFLOW] == 0
    human_values, logits, gains = np.zeros(MAX_PLACEMENTS), np.empty(MAX_PLACEMENTS), np.empty(MAX_PLACEMENTS)
    probabilities, ruled_out = np.empty(MAX_PLACEMENTS), np.zeros(MAX_PLACEMENTS, dtype=np.bool_)
    rows, score = np.empty((MAX_PLACEMENTS, len(units))), np.empty(len(units))
    fill_heights(work, NOW, n_columns)
    while counters[FINISHED] == 0:
        piece = counters[PIECES]
        n = scan_placements(work, rules, piece_at(seeds[0], piece, rules[SEVEN_BAG]))
        crowded = wall_height(work, NOW, n_columns) + MAX_SHAPE_SIZE > rules[ROWS]
        n_open = mark_ruled_out(work, rules, n, ruled_out) if crowded else allow_all(ruled_out, n)
        counters[FINISHED] = must_fit and n_open == 0
        if counters[FINISHED] != 0 or piece >= cap:
            break
        kept = piece % len(ring)
        for column in range(n_columns):
            ring[kept, column] = work[NOW, column]
        _fill_rows(code, units, work, rules, n, rows)
        env_values = action_values(rows[:n], memory.weights)
        human_best = 0
        if human_known:
            fill_values(human_code, human_table, human_numbers, work, rules, n, True, human_values)
            human_best = compare_choices(env_values, human_values, ruled_out, n, tally)
        if handover > 0.0 and takes_control(seeds[1], piece, handover):
            action = human_best
            score[:] = 0.0
        elif w_r == 0.0:
            action = choose(env_values, human_values, ruled_out, n, form, w_r, w_h)
            score[:] = 0.0
        else:
            reference = fill_logits(env_values, human_values, ruled_out, n, form, w_r, w_h, logits, gains)
            softmax(logits, ruled_out, n, probabilities)
            action = drawn(probabilities, n, uniform_at(seeds[2], piece))
            fill_score(rows, gains, probabilities, n, action, reference, score)
        remember_score(memory, score)
        full = put_down(work, NOW, action)
        lines = remove_rows(work, NOW, n_columns, full) if full != 0 else 0
        learn_from_reward(memory, lines + shaping * human_values[action])
        ring[kept, MAX_COLUMNS] = place_among_offered(ruled_out, action) if must_fit else action
        counters[LINES] += lines
        counters[PIECES] += 1
        counters[FINISHED] = crowded and not must_fit and wall_height(work, NOW, n_columns) > rules[ROWS]
