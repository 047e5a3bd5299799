"""Tiles over a range of all numbers of an observation together."""

import numpy as np
import pytest

pytest.importorskip("gymnasium")

from core.interop.gymnasium.tiles import JointTiles
from core.numerics.tile_coding import Range


def test_joint_tiles_by_hand() -> None:
    # Two numbers 0..1, 2 tiles each, 2 tilings; cells are a quarter wide, tiling 1 is shifted by (1, 1) cells
    # ((1, 3) modulo 2). 3 tiles across: tile = tiles of number 0 + 3 x tiles of number 1.
    tiles = JointTiles((Range(0.0, 1.0, 0.5), Range(0.0, 1.0, 0.5)), 2)
    assert tiles.coder.n_tiles == 2 * 9
    # cells (0, 0): tiling 0 tile (0, 0); tiling 1 tile (1 // 2, 1 // 2) = (0, 0)
    assert tiles.tiled(np.array([0.1, 0.1])).tolist() == [0, 0]
    # cells (1, 2): tiling 0 (0, 1) -> 3; tiling 1 (2 // 2, 3 // 2) = (1, 1) -> 4
    assert tiles.tiled(np.array([0.3, 0.6])).tolist() == [3, 4]
    # Beyond the range counts as its end: cells (4, 4): (2, 2) -> 8 in both tilings.
    assert tiles.tiled(np.array([7.0, 1.0])).tolist() == [8, 8]
    assert tiles.tiled(np.array([-7.0, 0.0])).tolist() == [0, 0]


def test_joint_tiles_that_differ_share_fewer_tiles_the_further_apart_they_are() -> None:
    tiles = JointTiles((Range(0.0, 1.0, 0.125), Range(0.0, 1.0, 0.125)), 8)
    here = tiles.tiled(np.array([0.51, 0.51]))
    shared = [
        int((tiles.tiled(np.array([0.51 + d, 0.51])) == here).sum()) for d in (0.0, 0.03, 0.06, 0.09, 0.13)
    ]
    assert shared == sorted(shared, reverse=True)
    assert (shared[0], shared[-1]) == (8, 0)
