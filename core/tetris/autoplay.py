"""Whole games in compiled code, played greedily by linear policies; with a human model:
`core.tetris.combined`.

Every game is fixed by its policy, its seed and the rules: pieces come from a counter, values are exact, ties
go to the first placement. A game is columns, number of pieces and lines, so it can be stopped and continued.
"""

import numpy as np
from numpy.typing import ArrayLike, NDArray

from core.combination.preference import best_action
from core.numerics.arrays import Floats, Ints
from core.numerics.compiled import kernel
from core.tetris.board import (
    COLUMNS,
    MAX_PLACEMENTS,
    NOW,
    OVERFLOW,
    ROWS,
    SEVEN_BAG,
    fill_heights,
    mark_ruled_out,
    new_work,
    piece_at,
    put_down,
    remove_rows,
    rule_codes,
    scan_placements,
    wall_height,
)
from core.tetris.config import MAX_COLUMNS, TetrisConfig
from core.tetris.evaluation import (
    empty_policy,
    fill_sums,
    fill_values_21,
    fill_values_any,
    fill_values_of_clearing,
    grid_weights,
    set_weights,
)
from core.tetris.features import BERTSEKAS_21, feature_set
from core.tetris.kept_game import FINISHED, LINES, PIECES
from core.tetris.pieces import MAX_SHAPE_SIZE


class GreedyGames:
    """n games, each played greedily by its own policy, that can be continued slice by slice."""

    def __init__(self, weights: NDArray[np.float64], seeds: ArrayLike, config: TetrisConfig) -> None:
        """Set up n games.

        Args:
            weights: policies under `config.features`, shape (n, F), or (F,) for one policy in all games.
            seeds: seeds of the piece streams, shape (n,), in [0, 2**63).
            config: board and rules.
        """
        self.config = config
        self.seeds = np.asarray(seeds, dtype=np.int64)
        """Shape (n,)."""
        n_features = len(feature_set(config.features, config.columns).names)
        if self.seeds.ndim != 1 or (self.seeds < 0).any():
            raise ValueError(f"seeds are numbers >= 0 in one row, got {self.seeds}")
        if np.shape(weights)[-1:] != (n_features,) or len(np.atleast_2d(weights)) not in (1, len(self.seeds)):
            raise ValueError(
                f"{config.features} on {config.columns} columns needs weights of shape ({n_features},) or "
                f"({len(self.seeds)}, {n_features}), got {np.shape(weights)}"
            )
        every = np.broadcast_to(np.asarray(weights, dtype=np.float64), (len(self.seeds), n_features))
        self._integers, self._units = grid_weights(every, float(config.lines_in_value))
        self._policy = empty_policy(feature_set(config.features, config.columns))
        self._rules = rule_codes(config)
        self.boards = np.zeros((len(self.seeds), MAX_COLUMNS), dtype=np.int64)
        """Columns of each game's board, shape (n, MAX_COLUMNS)."""
        self._counters = np.zeros((len(self.seeds), 3), dtype=np.int64)

    @property
    def pieces(self) -> Ints:
        """Pieces placed so far, shape (n,)."""
        return self._counters[:, PIECES].copy()

    @property
    def lines(self) -> Ints:
        """Lines cleared so far, shape (n,)."""
        return self._counters[:, LINES].copy()

    @property
    def finished(self) -> NDArray[np.bool_]:
        """Whether the game has ended (not: was stopped by a cap), shape (n,)."""
        return np.asarray(self._counters[:, FINISHED] != 0)

    def advance(self, piece_cap: ArrayLike) -> None:
        """Play each unfinished game until it ends or has `piece_cap` pieces (one number, or one per game)."""
        caps = np.broadcast_to(np.asarray(piece_cap, dtype=np.int64), self.seeds.shape).copy()
        _advance_games(
            *self._policy,
            new_work(),
            self._rules,
            self._integers,
            self._units,
            self.seeds,
            caps,
            self.boards,
            self._counters,
        )


@kernel
def _advance_games(
    code: int,
    table: Ints,
    numbers: Floats,
    work: Ints,
    rules: Ints,
    integers: Ints,
    units: Floats,
    seeds: Ints,
    caps: Ints,
    boards: Ints,
    counters: Ints,
) -> None:
    for game in range(len(seeds)):
        if counters[game, FINISHED] == 0 and counters[game, PIECES] < caps[game]:
            set_weights(code, table, numbers, rules, integers[game], units[game])
            for column in range(rules[COLUMNS]):
                work[NOW, column] = boards[game, column]
            _play_greedily(code, table, numbers, work, rules, seeds[game], caps[game], counters[game])
            for column in range(rules[COLUMNS]):
                boards[game, column] = work[NOW, column]


@kernel
def _play_greedily(
    code: int, table: Ints, numbers: Floats, work: Ints, rules: Ints, seed: int, cap: int, counters: Ints
) -> None:
    """Play on to the game's end or to `cap` pieces; the board and `counters` are changed."""
    n_columns, must_fit = rules[COLUMNS], rules[OVERFLOW] == 0
    values = np.empty(MAX_PLACEMENTS)
    ruled_out = np.zeros(MAX_PLACEMENTS, dtype=np.bool_)
    pieces, lines = counters[PIECES], counters[LINES]
    fill_heights(work, NOW, n_columns)
    over = False
    while not over:
        n = scan_placements(work, rules, piece_at(seed, pieces, rules[SEVEN_BAG]))
        crowded = wall_height(work, NOW, n_columns) + MAX_SHAPE_SIZE > rules[ROWS]
        n_open = mark_ruled_out(work, rules, n, ruled_out) if crowded else n
        over = must_fit and n_open == 0
        if over or pieces >= cap:
            break
        if code != BERTSEKAS_21:
            fill_values_any(code, numbers, work, rules, n, False, values)
        else:
            fill_sums(table, work, n_columns)
            if fill_values_21(table, numbers, work, n_columns, n, 0, values):
                fill_values_of_clearing(table, numbers, work, n_columns, n, 0, values)
        action = best_of(values, n) if n_open == n else best_action(values, ruled_out, n)
        full = put_down(work, NOW, action)
        if full != 0:
            lines += remove_rows(work, NOW, n_columns, full)
        pieces += 1
        over = crowded and not must_fit and wall_height(work, NOW, n_columns) > rules[ROWS]
    counters[PIECES], counters[LINES], counters[FINISHED] = pieces, lines, over


@kernel
def best_of(values: Floats, n: int) -> int:
    """Return `best_action` where no action is ruled out, in half the time."""
    best = 0
    highest = values[0]
    for action in range(1, n):
        value = values[action]
        best = action if value > highest else best
        highest = max(highest, value)
    return best


@kernel
def worst_of(values: Floats, n: int) -> int:
    """Return `worst_action` where no action is ruled out."""
    worst = 0
    lowest = values[0]
    for action in range(1, n):
        value = values[action]
        worst = action if value < lowest else worst
        lowest = min(lowest, value)
    return worst
