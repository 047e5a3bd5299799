"""The decision itself: one kernel that every domain's player calls for f(R, H) of Eq. 2.

All kernels take rows of which the first `n` entries count, never raise and allocate nothing. Sums run in the
order of the actions, so that plain Python gives the same bits. Values must be finite where not ruled out.
"""

import math

import numpy as np
from numpy.typing import NDArray

from core.combination.config import (
    ADVISE,
    ENVIRONMENT_WEIGHTS,
    EXPONENTIAL,
    LINEAR,
    LINEAR_RAW,
    SCHEMES,
    EpisodeWeights,
    Scheme,
)
from core.compiled import kernel
from core.counters import uniform_at
from core.softmax import exponential

__all__ = [
    "ADVISE",
    "ENVIRONMENT_WEIGHTS",
    "EXPONENTIAL",
    "LINEAR",
    "LINEAR_RAW",
    "SCHEMES",
    "EpisodeWeights",
    "Scheme",
    "best_action",
    "choose",
    "takes_control",
    "worst_action",
]

Values = NDArray[np.float64]
Mask = NDArray[np.bool_]


@kernel
def best_action(values: Values, ruled_out: Mask, n: int) -> int:
    """Return the first action with the highest value; 0 when all are ruled out."""
    best = -1
    for action in range(n):
        if not ruled_out[action] and (best < 0 or values[action] > values[best]):
            best = action
    return max(best, 0)


@kernel
def worst_action(values: Values, ruled_out: Mask, n: int) -> int:
    """Return the first action with the lowest value; 0 when all are ruled out."""
    worst = -1
    for action in range(n):
        if not ruled_out[action] and (worst < 0 or values[action] < values[worst]):
            worst = action
    return max(worst, 0)


@kernel
def choose(
    env_values: Values, human_values: Values, ruled_out: Mask, n: int, form: int, w_r: float, w_h: float
) -> int:
    """Return argmax f(R, H) over the actions that are not ruled out (Eq. 2); the lowest index wins ties.

    Args:
        env_values: R of each action, shape (>= n,).
        human_values: H of each action, shape (>= n,).
        ruled_out: actions that are not to be taken, shape (>= n,). If all are, the answer is 0.
        n: number of actions, >= 1.
        form: LINEAR, EXPONENTIAL, LINEAR_RAW or ADVISE (`core.combination.config`).
        w_r: weight of R, >= 0.
        w_h: weight of H. 0 gives exactly `best_action(env_values)` whatever the form.
    """
    if w_h == 0.0:
        return best_action(env_values, ruled_out, n)
    if form == EXPONENTIAL:
        return _choose_exponential(env_values, human_values, ruled_out, n, w_r, w_h)
    if w_r == 0.0:
        if w_h > 0.0:
            return best_action(human_values, ruled_out, n)
        return worst_action(human_values, ruled_out, n)
    if form == ADVISE:
        return _choose_by_advice(env_values, human_values, ruled_out, n, w_r, w_h)
    if form == LINEAR:
        centre_r, spread_r = mean_and_sd(env_values, ruled_out, n)
        centre_h, spread_h = mean_and_sd(human_values, ruled_out, n)
        # A constant row becomes zeros.
        gain_r = w_r / spread_r if spread_r > 0.0 else 0.0
        gain_h = w_h / spread_h if spread_h > 0.0 else 0.0
    else:
        centre_r, gain_r = 0.0, w_r
        centre_h, gain_h = 0.0, w_h
    best = -1
    best_value = 0.0
    for action in range(n):
        if not ruled_out[action]:
            # Eq. 3
            value = (env_values[action] - centre_r) * gain_r + (human_values[action] - centre_h) * gain_h
            if best < 0 or value > best_value:
                best = action
                best_value = value
    return max(best, 0)


@kernel
def takes_control(seed: int, decision: int, share: float) -> bool:
    """Return whether the human model's best action is taken in this decision (control sharing).

    Args:
        seed: seed of the episode's stream, in [0, 2**62).
        decision: number of the decision in the episode, >= 0.
        share: probability, in [0, 1].

    Returns:
        True with probability `share`; the same for the same arguments in compiled and plain Python.
    """
    return uniform_at(seed, decision) < share


@kernel
def mean_and_sd(values: Values, ruled_out: Mask, n: int) -> tuple[float, float]:
    """Mean and population sd over the actions not ruled out; sd 0 exactly for a constant row."""
    count = 0
    total = 0.0
    low = math.inf
    high = -math.inf
    for action in range(n):
        if not ruled_out[action]:
            count += 1
            total += values[action]
            low = min(low, values[action])
            high = max(high, values[action])
    if count == 0 or low == high:
        return 0.0, 0.0
    mean = total / count
    squares = 0.0
    for action in range(n):
        if not ruled_out[action]:
            squares += (values[action] - mean) * (values[action] - mean)
    return mean, math.sqrt(squares / count)


@kernel
def _choose_exponential(
    env_values: Values, human_values: Values, ruled_out: Mask, n: int, w_r: float, w_h: float
) -> int:
    """Return argmax w_r (R - min R) (1 + h^w_h), h = H mapped to [0, 1]; 1 - h in its place where w_h < 0."""
    low_r = env_values[worst_action(env_values, ruled_out, n)]
    low_h = human_values[worst_action(human_values, ruled_out, n)]
    range_h = human_values[best_action(human_values, ruled_out, n)] - low_h
    best = -1
    best_value = 0.0
    for action in range(n):
        if not ruled_out[action]:
            share = (human_values[action] - low_h) / range_h if range_h > 0.0 else 0.0
            if w_h < 0.0:
                share = 1.0 - share
            value = w_r * (env_values[action] - low_r) * (1.0 + share ** abs(w_h))
            if best < 0 or value > best_value:
                best = action
                best_value = value
    return max(best, 0)


@kernel
def chance_of_right(advice: float) -> float:
    """Return 1 / (1 + e^-advice): the probability of Advise, advice being d ln(C / (1 - C))."""
    if advice >= 0.0:
        return 1.0 / (1.0 + exponential(-advice))
    return exponential(advice) / (1.0 + exponential(advice))


@kernel
def _choose_by_advice(
    env_values: Values, human_values: Values, ruled_out: Mask, n: int, w_r: float, w_h: float
) -> int:
    """Return argmax e^(w_r R') P(w_h H'), R' and H' standardised over the actions."""
    spread_r = mean_and_sd(env_values, ruled_out, n)[1]
    centre_h, spread_h = mean_and_sd(human_values, ruled_out, n)
    highest_r = env_values[best_action(env_values, ruled_out, n)]
    gain_r = w_r / spread_r if spread_r > 0.0 else 0.0
    gain_h = w_h / spread_h if spread_h > 0.0 else 0.0
    best = -1
    best_value = 0.0
    for action in range(n):
        if not ruled_out[action]:
            value = exponential((env_values[action] - highest_r) * gain_r)
            value *= chance_of_right((human_values[action] - centre_h) * gain_h)
            if best < 0 or value > best_value:
                best = action
                best_value = value
    return max(best, 0)
