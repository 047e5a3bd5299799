"""A game of Tetris that compiled code plays slice by slice: what can be asked of it between two slices.

A game is columns and counters, so it can be stopped and continued. What a participant needs of the last
decisions (board and action) is kept in a ring, so that they can be judged later.
"""

from abc import ABC, abstractmethod
from typing import Final, NamedTuple

import numpy as np
from numpy.typing import NDArray

from core.combination.config import EpisodeWeights
from core.combination.preference import kernel_weights
from core.combination.tally import Tally, new_tally
from core.numerics.arrays import Bools, Ints
from core.numerics.compiled import inner_kernel
from core.tetris.board import (
    COLUMNS,
    NOW,
    OVERFLOW,
    ROWS,
    SEVEN_BAG,
    allow_all,
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
from core.tetris.evaluation import linear_policy
from core.tetris.pieces import MAX_SHAPE_SIZE

# Places in a game's row of counters.
PIECES, LINES, FINISHED = range(3)

# Places in a game's row of seeds.
PIECE_SEED: Final = 0
"""Of the pieces, in [0, 2**63)."""
HANDOVER_SEED: Final = 1
"""Decides where control is shared (`combination.handover`), in [0, 2**62)."""
CHANCE_SEED: Final = 2
"""Of the draws from a softmax, in [0, 2**62); only where the policy is one."""


class GameMemory(NamedTuple):
    """A game that is being played, as kernels take it."""

    work: Ints
    """Working memory of `core.tetris.board`; the board is its row NOW."""
    rules: Ints
    """See `core.tetris.board.rule_codes`."""
    ring: Ints
    """The last decisions, one per row: the columns of the board before it, then the action."""
    counters: Ints
    """PIECES, LINES, FINISHED, shape (3,)."""
    tally: Tally
    """Agreement of the environment policy with the human policy (`core.combination.tally`)."""


@inner_kernel
def find_placements(game: GameMemory, seed: int, ruled_out: Bools) -> tuple[int, int, bool]:
    """Find the placements of the next piece; the game is finished where it must fit and does not.

    Args:
        game: after `fill_heights`.
        seed: of the pieces.
        ruled_out: written, shape (>= number of placements,).

    Returns:
        The number of placements, how many of them are not ruled out, and whether the wall is so high that a
        placement may end above the top.
    """
    work, rules, counters = game.work, game.rules, game.counters
    n = scan_placements(work, rules, piece_at(seed, counters[PIECES], rules[SEVEN_BAG]))
    crowded = wall_height(work, NOW, rules[COLUMNS]) + MAX_SHAPE_SIZE > rules[ROWS]
    n_open = mark_ruled_out(work, rules, n, ruled_out) if crowded else allow_all(ruled_out, n)
    counters[FINISHED] = rules[OVERFLOW] == 0 and n_open == 0
    return n, n_open, crowded


@inner_kernel
def put_piece(game: GameMemory, ruled_out: Bools, action: int, crowded: bool) -> int:
    """Put the piece down, keep the decision, and count; return how many lines were cleared.

    Args:
        game: changed.
        ruled_out: from `find_placements`.
        action: the placement.
        crowded: from `find_placements`.
    """
    work, rules, ring, counters = game.work, game.rules, game.ring, game.counters
    n_columns, must_fit = rules[COLUMNS], rules[OVERFLOW] == 0
    kept = counters[PIECES] % len(ring)
    for column in range(n_columns):
        ring[kept, column] = work[NOW, column]
    ring[kept, MAX_COLUMNS] = place_among_offered(ruled_out, action) if must_fit else action
    full = put_down(work, NOW, action)
    lines = remove_rows(work, NOW, n_columns, full) if full != 0 else 0
    counters[PIECES] += 1
    counters[LINES] += lines
    counters[FINISHED] = crowded and not must_fit and wall_height(work, NOW, n_columns) > rules[ROWS]
    return lines


@inner_kernel
def place_among_offered(ruled_out: Bools, action: int) -> int:
    """Return which of the actions that are not ruled out this one is: where a piece must fit, others are not
    offered.
    """
    place = 0
    for other in range(action):
        place += not ruled_out[other]
    return place


class KeptGame(ABC):
    """A game in which environment and participant decide; `advance` is the compiled player's.

    All placements are open, also those that primitive actions could not reach (`TetrisConfig.placements`).
    """

    def __init__(
        self,
        human_weights: NDArray[np.float64],
        config: TetrisConfig,
        combination: EpisodeWeights,
        *,
        window: int,
    ) -> None:
        """Set up an empty board.

        Args:
            human_weights: v, under `config.feedback_features`, shape (G,).
            config: board and rules; `lines_in_value` must be off.
            combination: form and weights of the combination in this game.
            window: how many of the last decisions are kept, >= 1.
        """
        if config.lines_in_value:
            raise ValueError(
                "lines_in_value is for given policies only (core.tetris.autoplay); here values come from "
                "features"
            )
        self._config = config
        self._weights = kernel_weights(combination)
        self._game = GameMemory(
            work=new_work(),
            rules=rule_codes(config),
            ring=np.zeros((window, MAX_COLUMNS + 1), dtype=np.int64),
            counters=np.zeros(3, dtype=np.int64),
            tally=new_tally(),
        )
        self.set_human_weights(human_weights)

    @property
    def tally(self) -> Tally:
        """Agreement of the environment policy with the human policy, decision by decision so far
        (`core.combination.tally`).
        """
        return self._game.tally

    @property
    def pieces(self) -> int:
        """Pieces placed so far: the number of decisions."""
        return int(self._game.counters[PIECES])

    @property
    def lines(self) -> int:
        """Lines cleared so far."""
        return int(self._game.counters[LINES])

    @property
    def finished(self) -> bool:
        """Whether the game has ended (not: was stopped by a cap)."""
        return bool(self._game.counters[FINISHED])

    @abstractmethod
    def advance(self, piece_cap: int) -> None:
        """Play on until the game ends or has `piece_cap` pieces."""

    def set_human_weights(self, human_weights: NDArray[np.float64]) -> None:
        """Go on with another human model; what has been decided, learned and counted stays."""
        self._human = linear_policy(human_weights, self._config, self._config.feedback_features)

    def kept(self, decision: int) -> tuple[tuple[int, ...], int]:
        """Return the board before one of the last decisions, column by column, and the action that was taken.

        The action is an index into the choices of `core.tetris.afterstate.Tetris` with all placements
        offered.
        """
        ring = self._game.ring
        if not max(0, self.pieces - len(ring)) <= decision < self.pieces:
            raise ValueError(
                f"decision {decision} is not one of the last {len(ring)} of {self.pieces} decisions"
            )
        row = ring[decision % len(ring)]
        return tuple(row[: self._config.columns].tolist()), int(row[MAX_COLUMNS])
