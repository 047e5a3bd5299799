"""A softmax that comes out the same everywhere: plain IEEE operations in a fixed order, the exponential,
too.
"""

import math

import numpy as np

from core.numerics.arrays import Bools, Floats
from core.numerics.compiled import inner_kernel, kernel

_LN2_HIGH = 6.93147180369123816490e-01
_LN2_LOW = 1.90821492927058770002e-10
_TERMS = 14


@kernel
def exponential(x: float) -> float:
    """Return e**x for x <= 0, to the last bit or two; 0 below -700."""
    if x < -700.0:
        return 0.0
    halvings = math.floor(x / _LN2_HIGH + 0.5)
    rest = (x - halvings * _LN2_HIGH) - halvings * _LN2_LOW
    total = 1.0
    for term in range(_TERMS, 0, -1):
        total = 1.0 + rest * total / term
    return math.ldexp(total, int(halvings))


@kernel
def softmax(logits: Floats, ruled_out: Bools, n: int, out: Floats) -> None:
    """Write the probabilities of n actions, shape (>= n,): 0 where ruled out; if all are, action 0 is
    certain.
    """
    highest = -math.inf
    for action in range(n):
        out[action] = 0.0
        if not ruled_out[action]:
            highest = max(highest, logits[action])
    if highest == -math.inf:
        out[0] = 1.0
        return
    _exponentials(logits, ruled_out, highest, n, out, np.empty(n))
    total = 0.0
    for action in range(n):
        if not ruled_out[action]:
            total += out[action]
    _divide(out, n, total)


@inner_kernel
def _exponentials(
    logits: Floats, ruled_out: Bools, highest: float, n: int, out: Floats, rests: Floats
) -> None:
    """Write `exponential(logit - highest)` of each action that is not ruled out, 0 of the others.

    The same operations as there, but each step for all actions in turn: processors divide several numbers at
    once.
    """
    for action in range(n):
        x = 0.0 if ruled_out[action] else max(logits[action] - highest, -700.0)
        halvings = math.floor(x / _LN2_HIGH + 0.5)
        rests[action] = (x - halvings * _LN2_HIGH) - halvings * _LN2_LOW
        out[action] = 1.0
    for term in range(_TERMS, 0, -1):
        divisor = float(term)
        for action in range(n):
            out[action] = 1.0 + rests[action] * out[action] / divisor
    for action in range(n):
        x = logits[action] - highest
        if ruled_out[action] or x < -700.0:
            out[action] = 0.0
        else:
            out[action] = math.ldexp(out[action], math.floor(x / _LN2_HIGH + 0.5))


@inner_kernel
def _divide(values: Floats, n: int, divisor: float) -> None:
    for i in range(n):
        values[i] /= divisor


@kernel
def drawn(probabilities: Floats, n: int, point: float) -> int:
    """Return the action in whose part of [0, 1) `point` lies; the parts are in the order of the actions."""
    cumulative = 0.0
    last = 0
    for action in range(n):
        if probabilities[action] > 0.0:
            cumulative += probabilities[action]
            last = action
            if point < cumulative:
                break
    return last
