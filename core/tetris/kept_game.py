"""A game of Tetris that compiled code plays slice by slice: what can be asked of it between two slices.

A game is columns and counters, so it can be stopped and continued. What a participant needs of the last
decisions (board and action) is kept in a ring, so that whoever judges them need not have been asked at each.
"""

from abc import ABC, abstractmethod

import numpy as np
from numpy.typing import NDArray

from core.combination.config import EpisodeWeights
from core.combination.tally import new_tally
from core.tetris.board import new_work, rule_codes
from core.tetris.config import MAX_COLUMNS, TetrisConfig
from core.tetris.evaluation import linear_policy

# Places in a game's row of counters.
PIECES, LINES, FINISHED = range(3)


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
        self._combination = combination
        self._work = new_work()
        self._rules = rule_codes(config)
        # One row per kept decision: the columns of the board, then the action.
        self._ring = np.zeros((window, MAX_COLUMNS + 1), dtype=np.int64)
        self._counters = np.zeros(3, dtype=np.int64)
        self.tally = new_tally()
        """Agreement of the environment policy with the human policy, decision by decision so far
        (`core.combination.tally`)."""
        self.set_human_weights(human_weights)

    @property
    def pieces(self) -> int:
        """Pieces placed so far: the number of decisions."""
        return int(self._counters[PIECES])

    @property
    def lines(self) -> int:
        """Lines cleared so far."""
        return int(self._counters[LINES])

    @property
    def finished(self) -> bool:
        """Whether the game has ended (not: was stopped by a cap)."""
        return bool(self._counters[FINISHED])

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
        if not max(0, self.pieces - len(self._ring)) <= decision < self.pieces:
            raise ValueError(
                f"decision {decision} is not one of the last {len(self._ring)} of {self.pieces} decisions"
            )
        row = self._ring[decision % len(self._ring)]
        return tuple(row[: self._config.columns].tolist()), int(row[MAX_COLUMNS])
