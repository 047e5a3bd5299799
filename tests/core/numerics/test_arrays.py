"""Sums whose bits do not depend on the version of Python."""

from core.numerics.arrays import in_order


def test_numbers_are_added_from_the_left():
    # Exactly rounded, as Python 3.12's own `sum` has it, this would be 1.0.
    assert in_order([0.1] * 10) == 0.9999999999999999
    assert in_order([]) == 0.0
