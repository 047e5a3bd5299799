"""Choice by a softmax over f(R, H): what a policy-gradient learner plays in place of the argmax of Eq. 2."""

import math

import numpy as np
from numpy.typing import NDArray

from core.combination.config import ADVISE, EXPONENTIAL, LINEAR
from core.combination.preference import best_action, chance_of_right, mean_and_sd, worst_action
from core.compiled import kernel

Values = NDArray[np.float64]
Mask = NDArray[np.bool_]

LEAST_CHANCE = 1e-300
"""A chance of being right below this counts as this: its logarithm is finite."""


@kernel
def fill_logits(
    env_values: Values,
    human_values: Values,
    ruled_out: Mask,
    n: int,
    form: int,
    w_r: float,
    w_h: float,
    logits: Values,
    gains: Values,
) -> int:
    """Write f(R, H) of each action as logits, and their derivative by the action's R.

    Linear: w_r R + w_h s H', H' being H standardised over the actions and s the larger of 1 and the sd of R. That is
    Eq. 3 with both standardised, times a factor of the decision: R keeps the sharpness that learning gave it
    (`docs/decisions/policy-gradient.md`). Raw: w_r R + w_h H. Exponential: w_r (R - min R)(1 + h^w_h) as in `choose`.
    Advise: w_r R + log P(w_h H').

    Args:
        env_values: R of each action, shape (>= n,).
        human_values: H of each action, shape (>= n,).
        ruled_out: actions that are not to be taken, shape (>= n,).
        n: number of actions, >= 1.
        form: as in `core.combination.preference.choose`.
        w_r: weight of R, > 0.
        w_h: weight of H.
        logits: written, shape (>= n,).
        gains: written, shape (>= n,).

    Returns:
        The action whose R counts as 0 in the derivative; -1 where all gains are equal, so that none has to.
    """
    exponential = form == EXPONENTIAL and w_h != 0.0
    centre = range_h = 0.0
    factor = w_h
    reference = -1
    if exponential:
        reference = worst_action(env_values, ruled_out, n)
        centre = human_values[worst_action(human_values, ruled_out, n)]
        range_h = human_values[best_action(human_values, ruled_out, n)] - centre
    elif form in (LINEAR, ADVISE) and w_h != 0.0:
        centre, spread_h = mean_and_sd(human_values, ruled_out, n)
        scale = max(1.0, mean_and_sd(env_values, ruled_out, n)[1]) if form == LINEAR else 1.0
        factor = w_h * scale / spread_h if spread_h > 0.0 else 0.0
    for action in range(n):
        if exponential:
            share = (human_values[action] - centre) / range_h if range_h > 0.0 else 0.0
            share = min(max(share, 0.0), 1.0)  # of actions that are ruled out
            share = 1.0 - share if w_h < 0.0 else share
            gains[action] = w_r * (1.0 + math.pow(share, abs(w_h)))
            logits[action] = gains[action] * (env_values[action] - env_values[reference])
        else:
            gains[action] = w_r
            said = factor * (human_values[action] - centre)
            if form == ADVISE and w_h != 0.0:
                said = math.log(max(chance_of_right(said), LEAST_CHANCE))
            logits[action] = w_r * env_values[action] + said
    return reference
