"""Weights on a binary grid, so that a linear value comes out the same however its terms are added up.

A linear policy does not change when its weights are multiplied by a positive number, and hardly when they are
rounded to 40 bits. With integer features of up to 2**12 in sum, every product and partial sum then is exact
in an int64 and in a float64: a compiled kernel, NumPy's matrix product and plain Python agree bit for bit,
and equal values are equal instead of nearly so.
"""

import math

import numpy as np
from numpy.typing import ArrayLike, NDArray

WEIGHT_BITS = 40
"""Bits kept of the largest weight."""
_MAX_SHIFT = 500


def fixed_point_shift(weights: ArrayLike) -> int:
    """Return the s for which the largest of |weights| times 2**s lies in [2**39, 2**40); 0 if all are zero.

    Weights that are all below 1e-130 get fewer bits: s is at most 500.

    Raises:
        ValueError: a weight is not finite.
    """
    values = np.asarray(weights, dtype=np.float64)
    if not np.isfinite(values).all():
        raise ValueError(f"weights must be finite, got {values}")
    largest = float(np.abs(values).max(initial=0.0))
    if largest == 0.0:
        return 0
    return min(WEIGHT_BITS - math.frexp(largest)[1], _MAX_SHIFT)


def fixed_point_shifts(rows: NDArray[np.float64]) -> NDArray[np.int32]:
    """Return `fixed_point_shift` of each row, rows (n, F), shape (n,); all rows at once."""
    if not np.isfinite(rows).all():
        raise ValueError(f"weights must be finite, got {rows}")
    largest = np.abs(rows).max(axis=1, initial=0.0)
    exponents = np.frexp(largest)[1]
    shifts = np.where(largest == 0.0, 0, np.minimum(WEIGHT_BITS - exponents, _MAX_SHIFT))
    return np.asarray(shifts, dtype=np.int32)


def exact_weights(weights: ArrayLike) -> NDArray[np.float64]:
    """Return the weights rounded to multiples of 2**-`fixed_point_shift(weights)`, half to even.

    The factor is a power of two, so integers below 2**40 and sums of few binary fractions stay exact, and
    with them the ties between actions. A second rounding changes nothing.

    Args:
        weights: any shape, finite.
    """
    values = np.asarray(weights, dtype=np.float64)
    shift = fixed_point_shift(values)
    return np.ldexp(np.rint(np.ldexp(values, shift)), -shift)
