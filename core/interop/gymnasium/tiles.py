"""Tiles over all numbers of an observation together (Sutton & Barto 2018, sections 9.5.4 and 10.1).

Joint tilings are written as one variable for each tiling, whose value is the number of the active tile: the
kernels of `core.numerics.tile_coding` then learn them as they learn single numbers, with one tile each.
"""

import numpy as np

from core.numerics.arrays import Floats
from core.numerics.tile_coding import Range, TileCoder, tile_coder
from core.plugins import GameError

MOST_TILES = 2**22
"""Of all joint tilings: 32 megabytes of weights for each action."""


class JointTiles:
    """Tiles of all numbers together, each tiling shifted by (1, 3, 5, ...) of its cells (Parks & Militzer
    1991, as in Sutton & Barto 2018, section 9.5.4).
    """

    def __init__(self, ranges: tuple[Range, ...], n_tilings: int) -> None:
        """Lay the tilings.

        Args:
            ranges: of the d numbers.
            n_tilings: >= 1.

        Raises:
            GameError: they have more tiles than fit into memory.
        """
        spans = np.array([r.high - r.low for r in ranges])
        widths = np.array([r.tile_width for r in ranges])
        self._low = np.array([r.low for r in ranges])
        self._cells_per_unit = n_tilings / widths
        self._last_cell = np.ceil(spans / widths - 1e-9) * n_tilings
        self._n_tilings = n_tilings
        # One tile more than the range needs: the tilings are shifted. Python's integers do not overflow.
        across = [int(cells) // n_tilings + 1 for cells in self._last_cell]
        n_tiles = 1
        for n in across:
            n_tiles *= n
        if n_tilings * n_tiles > MOST_TILES:
            raise GameError(
                f"{n_tilings} joint tilings of {len(ranges)} numbers need {n_tilings * n_tiles:,} tiles; "
                f"the most is {MOST_TILES:,}. Choose fewer tiles, joint = false, or a phi of fewer numbers"
            )
        shifts = np.arange(n_tilings)[:, None] * (1 + 2 * np.arange(len(ranges)))
        self._shifts = shifts % n_tilings
        self._strides = np.cumprod([1, *across[:-1]])
        self.coder: TileCoder = tile_coder((Range(0.0, n_tiles - 0.5, 1.0),) * n_tilings, 1)

    def tiled(self, numbers: Floats) -> Floats:
        """Return the active tile of each tiling, shape (n_tilings,), of numbers of shape (d,)."""
        cells = np.clip(np.floor((numbers - self._low) * self._cells_per_unit), 0.0, self._last_cell)
        tiles = (cells.astype(np.int64) + self._shifts) // self._n_tilings
        numbers_of_tiles: Floats = (tiles @ self._strides).astype(np.float64)
        return numbers_of_tiles
