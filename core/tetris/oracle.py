"""What simulated participants know of Tetris: by these values they judge the agent's placements."""

import numpy as np
from numpy.typing import NDArray

from core.feedback.config import Knowledge
from core.tetris.afterstate import Tetris, TetrisState
from core.tetris.config import TetrisConfig
from core.tetris.features import DT_20_WEIGHTS

# In "dellacherie-thiery" order: landing height, eroded cells, row transitions, column transitions, holes, ...
KNOWLEDGE_WEIGHTS: dict[Knowledge, tuple[float, ...]] = {
    "expert": DT_20_WEIGHTS,
    "lay": (-1.0, 1.0, 0.0, 0.0, -1.0, 0.0, 0.0, 0.0, 0.0),
    "myopic": (-1.0, 1.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0),
}
"""Expert: the controller DT-20 (Gabillon, Ghavamzadeh & Scherrer 2013), about 50 million lines per game on 10
x 20. Lay: what meets the eye, a row of height, a cell removed and a hole counting alike. Myopic: how low the
piece came to lie and what it removed, whatever it buried. (The last two are ours; played greedily they clear
about 100 and 27 lines per game: means of 100 games.)"""


class TetrisOracle:
    """A participant who values placements: far better than the learner's features can express, or as a lay
    person.
    """

    def __init__(self, config: TetrisConfig, knowledge: Knowledge = "expert") -> None:
        """Judge games under these rules.

        Args:
            config: rules of the games seen; their features do not matter.
            knowledge: a key of `KNOWLEDGE_WEIGHTS`.
        """
        self._domain = Tetris(_seen_by_the_oracle(config))
        self._weights = np.array(KNOWLEDGE_WEIGHTS[knowledge])

    def __call__(self, state: TetrisState) -> NDArray[np.float64]:
        """Return the value of each action of `state`, shape (n,); -inf for one that ends the game."""
        choices = self._domain.choices(state)
        values: NDArray[np.float64] = choices.features @ self._weights
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
