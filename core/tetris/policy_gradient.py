"""Whole games of Tetris in compiled code in which a policy-gradient learner plays, with a human model, and
learns.

The policy is a softmax over placements (Kakade 2001), of f(R, H) where there is a human model
(`core.combination.preference`). A game is columns and counters, so it can be stopped and continued: the human
model may change between two pieces.
"""

from functools import lru_cache
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from core.combination.config import ENVIRONMENT_WEIGHTS, EpisodeWeights
from core.combination.preference import KernelWeights, choose, fill_logits, takes_control
from core.combination.tally import compare_choices
from core.learners.linear import action_values
from core.learners.policy_gradient import PolicyGradient
from core.learners.policy_gradient_kernels import Memory, fill_score, learn_from_reward, remember_score
from core.numerics.arrays import Bools, Floats, Ints
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
    ROW,
    SHAPE,
    fill_heights,
)
from core.tetris.config import TetrisConfig
from core.tetris.evaluation import LinearPolicy, fill_values
from core.tetris.features import BERTSEKAS_21, feature_set, fill_after, fill_bertsekas
from core.tetris.kept_game import (
    CHANCE_SEED,
    FINISHED,
    HANDOVER_SEED,
    PIECE_SEED,
    PIECES,
    GameMemory,
    KeptGame,
    find_placements,
    put_piece,
)
from core.tetris.pieces import SHAPE_TOPS, SHAPE_WIDTHS

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
        """Set up a game; the learner begins an episode, which the caller ends (`end_episode`).

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
        _play_on(
            self._memory,
            self._code,
            self._units,
            self._human,
            self._human_known,
            self._weights,
            self._game,
            self._seeds,
            piece_cap,
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


class _Decision(NamedTuple):
    """Working memory of one decision among at most m placements."""

    rows: Floats
    """Scaled features of each placement, shape (m, F)."""
    human_values: Floats
    """H of each, shape (m,); 0 where there is no human policy."""
    ruled_out: Bools
    """Shape (m,)."""
    logits: Floats
    """Shape (m,)."""
    gains: Floats
    """Derivative of each logit by the placement's R, shape (m,)."""
    probabilities: Floats
    """Of the softmax, shape (m,)."""
    score: Floats
    """Gradient of the logarithm of the chosen placement's probability, shape (F,)."""


@kernel
def _new_decision(n_features: int) -> _Decision:
    m = MAX_PLACEMENTS
    return _Decision(
        np.empty((m, n_features)),
        np.zeros(m),
        np.zeros(m, dtype=np.bool_),
        np.empty(m),
        np.empty(m),
        np.empty(m),
        np.empty(n_features),
    )


@kernel
def _play_on(
    memory: Memory,
    code: int,
    units: Floats,
    human: LinearPolicy,
    human_known: bool,
    weights: KernelWeights,
    game: GameMemory,
    seeds: Ints,
    cap: int,
) -> None:
    """Play on to the game's end or to `cap` pieces; `memory` and `game` are changed."""
    work, rules, counters = game.work, game.rules, game.counters
    decision = _new_decision(len(units))
    human_values, ruled_out, score = decision.human_values, decision.ruled_out, decision.score
    fill_heights(work, NOW, rules[COLUMNS])
    while counters[FINISHED] == 0:
        piece = counters[PIECES]
        n, _, crowded = find_placements(game, seeds[PIECE_SEED], ruled_out)
        if counters[FINISHED] != 0 or piece >= cap:
            break
        _fill_rows(code, units, work, rules, n, decision.rows)
        env_values = action_values(decision.rows[:n], memory.weights)
        human_best = 0
        if human_known:
            fill_values(human.code, human.table, human.numbers, work, rules, n, True, human_values)
            human_best = compare_choices(env_values, human_values, ruled_out, n, game.tally)
        if weights.handover > 0.0 and takes_control(seeds[HANDOVER_SEED], piece, weights.handover):
            action = human_best
            score[:] = 0.0
        else:
            action = _act(env_values, decision, n, weights, uniform_at(seeds[CHANCE_SEED], piece))
        remember_score(memory, score)
        lines = put_piece(game, ruled_out, action, crowded)
        learn_from_reward(memory, lines + weights.shaping * human_values[action])


@kernel
def _act(env_values: Floats, decision: _Decision, n: int, weights: KernelWeights, point: float) -> int:
    """Return an action of the softmax over f(R, H) and write its score, which is 0 where R has no weight.

    Args:
        env_values: R of each action, shape (n,).
        decision: working memory, with the rows, H and what is ruled out.
        n: number of actions.
        weights: of R and H.
        point: of the draw, uniform in [0, 1).
    """
    human_values, ruled_out = decision.human_values, decision.ruled_out
    form, w_r, w_h = weights.form, weights.w_r, weights.w_h
    if w_r == 0.0:
        decision.score[:] = 0.0
        return choose(env_values, human_values, ruled_out, n, form, w_r, w_h)
    logits, gains, probabilities = decision.logits, decision.gains, decision.probabilities
    reference = fill_logits(env_values, human_values, ruled_out, n, form, w_r, w_h, logits, gains)
    softmax(logits, ruled_out, n, probabilities)
    action = drawn(probabilities, n, point)
    fill_score(decision.rows, gains, probabilities, n, action, reference, decision.score)
    return action
