"""Weights on a binary grid."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from core.numerics.fixed_point import exact_weights, fixed_point_shift, fixed_point_shifts

SIZES = st.floats(1e-100, 1e6)
WEIGHTS = st.lists(SIZES | SIZES.map(lambda size: -size) | st.just(0.0), min_size=1, max_size=21).map(
    np.array
)


def fixed_point(weights):
    """Return the weights on their grid, in integers."""
    return np.ldexp(exact_weights(weights), fixed_point_shift(weights)).astype(np.int64)


def test_the_largest_weight_has_forty_bits_by_hand():
    # 3 is 2 bits long: 3 * 2**38 < 2**40
    assert fixed_point_shift([3.0, -1.0]) == 38
    assert fixed_point([3.0, -1.0]).tolist() == [3 << 38, -(1 << 38)]


@given(WEIGHTS)
def test_the_grid_keeps_forty_bits(weights):
    integers = fixed_point(weights)
    assert np.abs(integers).max() <= 2**40
    assert np.abs(exact_weights(weights) - weights).max() <= np.abs(weights).max() * 2.0**-39


@given(WEIGHTS)
def test_rounding_twice_changes_nothing(weights):
    once = exact_weights(weights)
    np.testing.assert_array_equal(exact_weights(once), once)


@given(st.lists(st.integers(-(2**31), 2**31), min_size=1, max_size=21))
def test_integers_stay_exact(values):
    np.testing.assert_array_equal(exact_weights(np.array(values, dtype=float)), values)


@given(WEIGHTS, st.randoms(use_true_random=False))
def test_values_of_integer_features_do_not_depend_on_the_order_of_the_sum(weights, random):
    features = np.array([random.randint(-150, 150) for _ in weights], dtype=float)
    terms = list(exact_weights(weights) * features)
    expected = sum(terms)
    random.shuffle(terms)
    assert sum(terms) == expected == float(np.dot(exact_weights(weights), features))


def test_zeros_and_tiny_weights_are_weights_too():
    assert fixed_point([0.0, 0.0]).tolist() == [0, 0]
    tiny = exact_weights([1e-120, -3e-120])
    assert tiny[1] / tiny[0] == pytest.approx(-3)


def test_weights_that_are_not_finite_are_refused():
    with pytest.raises(ValueError, match="finite"):
        fixed_point([1.0, np.inf])


@given(st.lists(st.lists(st.floats(-1e6, 1e6), min_size=3, max_size=3), min_size=1, max_size=5))
def test_shifts_of_many_rows_are_those_of_each(rows):
    table = np.array(rows)
    assert fixed_point_shifts(table).tolist() == [fixed_point_shift(row) for row in table]
