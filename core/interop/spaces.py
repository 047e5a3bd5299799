"""Spaces of the program's own games, for everything that leaves it: Gymnasium, PettingZoo, Minari data sets.

One description, so that a policy learned from a data set acts in the environment.
"""

from typing import Any

import numpy as np
from gymnasium import spaces
from numpy.typing import NDArray

from core.keepaway.domain import Keepaway
from core.keepaway.pitch import KeepawayConfig
from core.keepaway.simulator.match import n_variables
from core.tetris.afterstate import Tetris, TetrisState
from core.tetris.config import TetrisConfig
from core.tetris.shapes import N_PIECES

N_ORIENTATIONS = 4
"""Quarter turns of a piece; a piece that looks alike after fewer turns has fewer."""


def tetris_observations(config: TetrisConfig) -> spaces.Dict:
    """Return what is seen of Tetris: `board`, (rows, columns), row 0 the lowest, and the `piece` to be
    placed.
    """
    board = spaces.Box(0, 1, (config.rows, config.columns), np.int8)
    return spaces.Dict({"board": board, "piece": spaces.Discrete(N_PIECES)})


def tetris_placements(config: TetrisConfig) -> spaces.MultiDiscrete:
    """Return the actions of Tetris: (quarter turns counter-clockwise, leftmost column)."""
    return spaces.MultiDiscrete([N_ORIENTATIONS, config.columns])


def board_cells(columns: tuple[int, ...], rows: int) -> NDArray[np.int8]:
    """Return a board of column bitboards as cells, shape (rows, columns), row 0 the lowest."""
    return np.array([[column >> row & 1 for column in columns] for row in range(rows)], dtype=np.int8)


def tetris_observation(domain: Tetris, state: TetrisState) -> dict[str, Any]:
    """Return what is seen in a state."""
    piece = np.int64(domain.piece(state))
    return {"board": board_cells(state.columns, domain.config.rows), "piece": piece}


def keepaway_observations(config: KeepawayConfig) -> spaces.Box:
    """Return what a keeper sees: its state variables (`Keepaway.observation_names`), metres and degrees."""
    return spaces.Box(-np.inf, np.inf, (n_variables(config.n_keepers, config.n_takers),), np.float64)


def keepaway_actions(config: KeepawayConfig) -> spaces.Discrete:
    """Return a keeper's actions: 0 holds the ball, k passes to the k-th nearest keeper."""
    return spaces.Discrete(config.n_actions)


def keepaway_names(config: KeepawayConfig) -> tuple[str, ...]:
    """Return the names of the state variables, in their order."""
    return Keepaway(config).observation_names
