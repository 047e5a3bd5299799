"""One-dimensional tilings with a fixed index: every variable is tiled alone, no hash table, no order of
visit.

A variable is cut into cells of width / n_tilings. Tiling j is shifted by j cells, so of the tiles that cover
a cell exactly one starts at each of the last n_tilings cells. Stored by the cell they start at, the active
tiles are one contiguous window: a decision needs one integer per variable.
"""

from collections.abc import Callable
from dataclasses import dataclass
from typing import Any, NamedTuple

import numpy as np

from core.numerics.arrays import Floats, Ints
from core.numerics.compiled import inner_kernel, kernel


class TileCoder(NamedTuple):
    """Arrays of a tile coding of v variables; made by `tile_coder`."""

    low: Floats
    """Lower end of each range, shape (v,); values outside a range count as its end."""
    cells_per_unit: Floats
    """n_tilings / tile width, shape (v,)."""
    n_cells: Ints
    """Cells in each range, shape (v,)."""
    offset: Ints
    """Index of each variable's first tile, shape (v,)."""
    n_tilings: int
    n_tiles: int
    """Number of tiles of all variables and tilings: the length of a weight vector."""


class Tiling(NamedTuple):
    """How rows of active tiles index one flat weight vector: each entry of a row is the first tile of a
    window.
    """

    n_weights: int
    """Length of the weight vector."""
    n_tilings: int
    """Length of each window."""


@dataclass(frozen=True, slots=True)
class Range:
    """A variable to tile: [low, high] in tiles of `tile_width`, all in the variable's unit."""

    low: float
    high: float
    tile_width: float

    def __post_init__(self) -> None:
        if not (self.low < self.high and self.tile_width > 0):
            raise ValueError(
                f"need low < high and tile_width > 0, got [{self.low}, {self.high}] in tiles of "
                f"{self.tile_width}"
            )


def tile_coder(ranges: tuple[Range, ...], n_tilings: int = 32) -> TileCoder:
    """Return the tile coding of the variables with these ranges.

    Args:
        ranges: one per variable, at least one.
        n_tilings: tilings per variable, >= 1 (UT Austin keepaway: 32).
    """
    if not ranges or n_tilings < 1:
        raise ValueError(f"need at least one range and one tiling, got {len(ranges)} and {n_tilings}")
    per_unit = np.array([n_tilings / r.tile_width for r in ranges])
    spans = np.array([r.high - r.low for r in ranges])
    n_cells = np.floor(spans * per_unit).astype(np.int64) + 1
    # A window reaches n_tilings - 1 cells back, also from the first cell.
    sizes = n_cells + n_tilings - 1
    ends = np.cumsum(sizes)
    return TileCoder(
        low=np.array([r.low for r in ranges]),
        cells_per_unit=per_unit,
        n_cells=n_cells,
        offset=ends - sizes,
        n_tilings=int(n_tilings),
        n_tiles=int(ends[-1]),
    )


@inner_kernel
def find_windows(coder: TileCoder, values: Floats, out: Ints) -> None:
    """Write the first active tile of each variable; its active tiles are that one and the next n_tilings - 1.

    Args:
        coder: the tile coding.
        values: finite, shape (v,).
        out: shape (v,).
    """
    for v in range(len(out)):
        cell = int(np.floor((values[v] - coder.low[v]) * coder.cells_per_unit[v]))
        out[v] = coder.offset[v] + min(max(cell, 0), coder.n_cells[v] - 1)


@inner_kernel
def window_sum(weights: Floats, windows: Ints, n_tilings: int) -> float:
    """Return the sum of the weights of all active tiles; always added in the same order."""
    a, b, c, d = 0.0, 0.0, 0.0, 0.0
    whole = n_tilings - n_tilings % 4
    for v in range(len(windows)):
        start = windows[v]
        for k in range(start, start + whole, 4):
            a += weights[k]
            b += weights[k + 1]
            c += weights[k + 2]
            d += weights[k + 3]
        for k in range(start + whole, start + n_tilings):
            a += weights[k]
    return (a + b) + (c + d)


@inner_kernel
def add_to_windows(weights: Floats, windows: Ints, n_tilings: int, amount: float) -> None:
    """Add `amount` to the weight of every active tile."""
    for v in range(len(windows)):
        for k in range(windows[v], windows[v] + n_tilings):
            weights[k] += amount


@kernel
def row_values(rows: Ints, weights: Floats, n_tilings: int) -> Floats:
    """Return the sum of the weights of the active tiles of each row of window starts, (n, v) -> (n,)."""
    out = np.empty(rows.shape[0])
    for i in range(rows.shape[0]):
        out[i] = window_sum(weights, rows[i], n_tilings)
    return out


def tile_values(tiling: Tiling) -> Callable[[Any, Floats], Floats]:
    """Return the function (rows of window starts (n, v), weights) -> values (n,)."""
    return lambda rows, weights: row_values(np.ascontiguousarray(rows, np.int64), weights, tiling.n_tilings)


def runs(weights: Floats) -> tuple[Floats, Floats]:
    """Return the starts of runs of equal numbers, and these numbers: short, because a window changes all its
    tiles.

    A weight vector is these numbers, each repeated up to the next start; `from_runs` is the way back,
    exactly.
    """
    starts = np.flatnonzero(np.append(True, np.diff(weights) != 0.0)).astype(np.float64)
    return starts, weights[starts.astype(np.int64)]


def from_runs(starts: Floats, values: Floats, n: int) -> Floats:
    """Return the n numbers behind `runs`."""
    lengths = np.diff(np.append(np.asarray(starts, np.int64), n))
    return np.repeat(np.asarray(values, np.float64), lengths)
