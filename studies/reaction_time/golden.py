"""Golden-section search for the top of a function with one top, asked for values one by one.

    bracket = np.empty(PLACES)
    begin(bracket, low, high)
    bracket[AT_C], bracket[AT_D] = f(bracket[C]), f(bracket[D])
    while ...:
        new = narrow(bracket)
        bracket[AT + new] = f(bracket[new])
    t, value = top(bracket)

So one search serves any function, and no function has to be passed to compiled code.
"""

from typing import Final

import numpy as np
from numpy.typing import NDArray

from core.numerics.compiled import kernel

STEPS: Final = 36
"""Steps that narrow any bracket to 3e-8 of its length."""
GOLDEN: Final = 0.6180339887498949

A: Final = 0
B: Final = 1
"""The ends."""
C: Final = 2
D: Final = 3
"""The places between them that are asked for."""
AT: Final = 2
"""The value at a place stands so many entries after it."""
AT_C: Final = C + AT
AT_D: Final = D + AT
PLACES: Final = 6


@kernel
def begin(bracket: NDArray[np.float64], low: float, high: float) -> None:
    """Search between `low` and `high`; values at C and D are wanted first."""
    bracket[A], bracket[B] = low, high
    bracket[C], bracket[D] = high - GOLDEN * (high - low), low + GOLDEN * (high - low)


@kernel
def narrow(bracket: NDArray[np.float64]) -> int:
    """Cut off the worse end; return the place, C or D, at which a value is wanted next."""
    if bracket[AT_C] > bracket[AT_D]:
        bracket[B], bracket[D], bracket[AT_D] = bracket[D], bracket[C], bracket[AT_C]
        bracket[C] = bracket[B] - GOLDEN * (bracket[B] - bracket[A])
        return C
    bracket[A], bracket[C], bracket[AT_C] = bracket[C], bracket[D], bracket[AT_D]
    bracket[D] = bracket[A] + GOLDEN * (bracket[B] - bracket[A])
    return D


@kernel
def top(bracket: NDArray[np.float64]) -> tuple[float, float]:
    """Return the better place so far and its value."""
    if bracket[AT_C] > bracket[AT_D]:
        return bracket[C], bracket[AT_C]
    return bracket[D], bracket[AT_D]
