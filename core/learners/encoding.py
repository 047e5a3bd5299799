"""Encoding of observations for linear learners: active tiles of a state, and of a state and an action.

A learner that compares rows needs no encoder (`Choices.features`). One that sees an observation tiles it by a
`TileCoder` of its own; a human model over tiles has one weight vector for all actions, so each action has
tiles of its own.
"""

from dataclasses import dataclass

import numpy as np

from core.numerics.arrays import Floats, Ints
from core.numerics.tile_coding import TileCoder, Tiling, find_windows


def active_tiles(coder: TileCoder, observation: Floats) -> Ints:
    """Return the first active tile of each variable, shape (v,), of an observation of shape (v,)."""
    windows = np.empty(len(observation), np.int64)
    find_windows(coder, observation, windows)
    return windows


@dataclass(frozen=True, slots=True, eq=False)
class ActionTiles:
    """Rows of active tiles, one per action: psi(s, a) of a human model of type tiles."""

    coder: TileCoder
    n_actions: int
    """>= 1."""
    n_models: int = 1
    """How many actors have a model of their own, >= 1; 1 where all share one."""

    @property
    def tiling(self) -> Tiling:
        """What the rows index: tiles by model, action and variable."""
        return Tiling(self.n_models * self.n_actions * self.coder.n_tiles, self.coder.n_tilings)

    def rows(self, actor: int, observation: Floats) -> Ints:
        """Return the first active tiles of each action, shape (n_actions, v).

        Args:
            actor: who decides, >= 0.
            observation: what the actor sees, shape (v,).
        """
        model = actor if self.n_models > 1 else 0
        first = (model * self.n_actions + np.arange(self.n_actions)) * self.coder.n_tiles
        rows: Ints = first[:, None] + active_tiles(self.coder, observation)
        return rows
