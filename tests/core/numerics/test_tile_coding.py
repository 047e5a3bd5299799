"""Tile coding by hand: which tiles are active, how tiles overlap, and that the index is fixed."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from core.numerics.tile_coding import Range, add_to_windows, find_windows, tile_coder, window_sum


def windows(coder, *values):
    out = np.zeros(len(coder.low), np.int64)
    find_windows(coder, np.array(values, float), out)
    return out


def test_a_value_activates_one_tile_of_each_tiling():
    # Width 2, 4 tilings: cells of 0.5. Value 1.2 lies in cell 2, so its window is tiles 2, 3, 4, 5.
    coder = tile_coder((Range(0.0, 10.0, 2.0),), n_tilings=4)
    assert windows(coder, 1.2)[0] == 2
    # 21 cells (10 is the last cell's start) and 3 more tiles that reach into the first cell.
    assert coder.n_tiles == 24


def test_tiles_overlap_in_proportion_to_the_distance():
    # Learning 1 at 3.0 gives 4/4 of it at 3.0, 3/4 at 3.5, 2/4 at 4.0, 1/4 at 4.5, nothing at 5.0.
    coder = tile_coder((Range(0.0, 10.0, 2.0),), n_tilings=4)
    weights = np.zeros(coder.n_tiles)
    add_to_windows(weights, windows(coder, 3.0), 4, 0.25)
    learned = [window_sum(weights, windows(coder, v), 4) for v in (1.0, 1.5, 2.5, 3.0, 3.5, 4.0, 4.5, 5.0)]
    assert learned == [0.0, 0.25, 0.75, 1.0, 0.75, 0.5, 0.25, 0.0]


def test_one_tiling_of_width_one_is_a_table():
    coder = tile_coder((Range(0.0, 2.5, 1.0),), n_tilings=1)
    assert coder.n_tiles == 3
    assert [windows(coder, v)[0] for v in (0.0, 1.0, 2.0)] == [0, 1, 2]


def test_variables_do_not_share_tiles():
    coder = tile_coder((Range(0.0, 4.0, 2.0), Range(-90.0, 90.0, 10.0)), n_tilings=32)
    last_of_first = windows(coder, 4.0, 0.0)[0] + 31
    first_of_second = windows(coder, 0.0, -90.0)[1]
    assert last_of_first < first_of_second
    assert windows(coder, 0.0, 90.0)[1] + 31 == coder.n_tiles - 1


def test_values_outside_the_range_count_as_its_end():
    coder = tile_coder((Range(0.0, 4.0, 2.0),))
    assert windows(coder, -3.0)[0] == windows(coder, 0.0)[0]
    assert windows(coder, 99.0)[0] == windows(coder, 4.0)[0]


@given(st.lists(st.floats(-50, 50), min_size=3, max_size=3), st.integers(1, 40))
def test_the_sum_is_that_of_the_active_tiles(values, n_tilings):
    coder = tile_coder((Range(-20.0, 20.0, 3.0),) * 3, n_tilings)
    weights = np.sin(np.arange(coder.n_tiles))
    found = windows(coder, *values)
    active = np.concatenate([weights[w : w + n_tilings] for w in found])
    assert window_sum(weights, found, n_tilings) == pytest.approx(active.sum(), abs=1e-12)


@pytest.mark.parametrize("wrong", [(1.0, 1.0, 1.0), (2.0, 1.0, 1.0), (0.0, 1.0, 0.0)])
def test_an_impossible_range_is_refused(wrong):
    with pytest.raises(ValueError, match="low < high"):
        Range(*wrong)


def test_a_coder_needs_a_variable_and_a_tiling():
    with pytest.raises(ValueError, match="at least one"):
        tile_coder(())
    with pytest.raises(ValueError, match="at least one"):
        tile_coder((Range(0.0, 1.0, 1.0),), 0)
