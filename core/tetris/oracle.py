"""Somebody who knows Tetris far better than the learner's features can express: by whom simulated people judge."""

import numpy as np
from numpy.typing import NDArray

from core.tetris.afterstate import Tetris, TetrisState
from core.tetris.config import TetrisConfig
from core.tetris.features import DT_20_WEIGHTS


class TetrisOracle:
    """The controller DT-20 (Gabillon, Ghavamzadeh & Scherrer 2013): about 50 million lines per game on 10 x 20."""

    def __init__(self, config: TetrisConfig) -> None:
        """Judge games under these rules."""
        self._domain = Tetris(_seen_by_the_oracle(config))

    def __call__(self, state: TetrisState) -> NDArray[np.float64]:
        """Return the value of each action of `state`, shape (n,); -inf for one that ends the game."""
        choices = self._domain.choices(state)
        values: NDArray[np.float64] = choices.features @ np.array(DT_20_WEIGHTS)
        values[choices.ruled_out] = -np.inf
        return values


def _seen_by_the_oracle(config: TetrisConfig) -> TetrisConfig:
    return TetrisConfig(
        rows=config.rows,
        columns=config.columns,
        game_over=config.game_over,
        clear_on_overflow=config.clear_on_overflow,
        terminal_value=config.terminal_value,
        pieces=config.pieces,
        placements=config.placements,
        features="dellacherie-thiery",
    )
