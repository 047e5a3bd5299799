import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from studies.reaction_time.ascent import climb

FREE = ([-math.inf] * 2, [math.inf] * 2)


def test_a_parabola_is_climbed_to_its_top():
    top, value = climb(
        lambda x: 5.0 - (x[0] - 1.0) ** 2 - 3.0 * (x[1] + 2.0) ** 2 - x[0] * x[1], [0.0, 0.0], *FREE
    )
    # Gradient: -2 (a - 1) - b = 0 and -6 (b + 2) - a = 0, so a = 24 / 11 and b = -26 / 11.
    assert top == pytest.approx([24 / 11, -26 / 11], abs=1e-5)
    assert value == pytest.approx(5.0 - (13 / 11) ** 2 - 3.0 * (4 / 11) ** 2 + 24 * 26 / 121)


@given(st.floats(-3.0, 3.0), st.floats(-3.0, 3.0))
def test_a_curved_ridge_is_climbed_from_anywhere(a, b):
    top, _ = climb(
        lambda x: -((1.0 - x[0]) ** 2) - 10.0 * (x[1] - x[0] ** 2) ** 2, [a, b], *FREE, max_steps=500
    )
    assert top == pytest.approx([1.0, 1.0], abs=1e-3)


def test_the_top_is_looked_for_inside_the_box():
    top, _ = climb(lambda x: -((x[0] - 3.0) ** 2) - (x[1] - x[0]) ** 2, [0.0, 0.0], [-1.0, -1.0], [2.0, 5.0])
    assert top == pytest.approx([2.0, 2.0], abs=1e-5)
    corner, _ = climb(lambda x: x[0] + x[1], [0.0, 0.0], [-1.0, -1.0], [2.0, 5.0])
    assert corner.tolist() == [2.0, 5.0]


def test_a_start_outside_the_box_is_moved_in_and_a_cliff_is_not_crossed():
    top, _ = climb(lambda x: math.log(x[0]) - x[0] if x[0] > 0.0 else -math.inf, [-5.0], [0.1], [9.0])
    assert top == pytest.approx([1.0], abs=1e-4)


def test_a_start_at_the_top_stays():
    top, value = climb(lambda x: -float(np.sum(x**2)), [0.0, 0.0], *FREE)
    assert (top.tolist(), value) == ([0.0, 0.0], 0.0)
