"""Types of arrays. Their shapes and units stand where they are used."""

from collections.abc import Iterable

import numpy as np
from numpy.typing import NDArray

Floats = NDArray[np.float64]
Ints = NDArray[np.int64]
Bools = NDArray[np.bool_]


def in_order(numbers: Iterable[float]) -> float:
    """Return the sum of numbers, added one by one from the left; 0.0 for none.

    Python's own `sum` does so before 3.12 and corrects its rounding since then: other bits, with which a
    recording of an older Python would not replay.
    """
    total = 0.0
    for number in numbers:
        total += number
    return total
