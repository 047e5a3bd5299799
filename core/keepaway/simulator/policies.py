"""Benchmark policies of the keeper with the ball: random, always hold, hand-coded."""

from typing import Final

import numpy as np

from core.numerics.arrays import Floats
from core.numerics.compiled import inner_kernel

RANDOM: Final = 0
HOLD: Final = 1
HAND_CODED: Final = 2
POLICIES: Final = {"random": RANDOM, "hold": HOLD, "hand": HAND_CODED}
"""Names of the benchmark policies."""
SAFE_TAKER_DISTANCE: Final = 5.0
HOLD_SCORE: Final = 90.0
DISTANCE_SCORE: Final = 4.0
"""Score of a pass per metre between its receiver and the taker nearest to the receiver."""


@inner_kernel
def hand_coded(variables: Floats, n_keepers: int, n_takers: int) -> int:
    """Hold while the nearest taker is farther than 5 m; else the best of 90 and 4 * distance + angle per
    pass.
    """
    if variables[n_keepers] > SAFE_TAKER_DISTANCE:
        return 0
    base = 1 + 2 * (n_keepers - 1 + n_takers)
    best, best_score = 0, HOLD_SCORE
    for k in range(1, n_keepers):
        score = DISTANCE_SCORE * variables[base + k - 1] + variables[base + n_keepers - 1 + k - 1]
        if score > best_score:
            best, best_score = k, score
    return best


@inner_kernel
def choose(policy: int, variables: Floats, n_keepers: int, n_takers: int, rng: np.random.Generator) -> int:
    """Return the action of a benchmark policy: 0 holds, a >= 1 passes to the a-th nearest keeper."""
    if policy == RANDOM:
        return int(n_keepers * rng.random())
    if policy == HAND_CODED:
        return hand_coded(variables, n_keepers, n_takers)
    return 0
