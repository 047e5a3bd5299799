"""The preference f(R, H) of Eq. 2, once: a score per action, and on top of it the argmax and the logits of a
softmax.

All kernels take rows of which the first `n` entries count, never raise and allocate nothing. Sums run in the
order of the actions, so that plain Python gives the same bits. Values must be finite where not ruled out.
"""

import math
from typing import Final, NamedTuple

from core.combination.episode_weights import ADVISE, EXPONENTIAL, LINEAR, LINEAR_RAW, EpisodeWeights
from core.numerics.arrays import Bools, Floats
from core.numerics.compiled import inner_kernel, kernel
from core.numerics.counters import uniform_at
from core.numerics.softmax import exponential

LEAST_CHANCE: Final = 1e-300
"""A chance of being right below this counts as this: its logarithm is finite."""


class KernelWeights(NamedTuple):
    """`EpisodeWeights` as kernels take them."""

    form: int
    """LINEAR, EXPONENTIAL, LINEAR_RAW or ADVISE."""
    w_r: float
    """Weight of R, >= 0."""
    w_h: float
    """Weight of H."""
    handover: float
    """Probability, per decision, of taking the human model's best action instead, in [0, 1]."""
    shaping: float
    """What is added to the reward of a step per unit of its H."""


def kernel_weights(weights: EpisodeWeights) -> KernelWeights:
    """Return the weights of an episode with the types that compiled code expects."""
    return KernelWeights(
        int(weights.form),
        float(weights.w_r),
        float(weights.w_h),
        float(weights.handover),
        float(weights.shaping),
    )


@kernel
def best_action(values: Floats, ruled_out: Bools, n: int) -> int:
    """Return the first action with the highest value; 0 when all are ruled out."""
    best = -1
    for action in range(n):
        if not ruled_out[action] and (best < 0 or values[action] > values[best]):
            best = action
    return max(best, 0)


@kernel
def worst_action(values: Floats, ruled_out: Bools, n: int) -> int:
    """Return the first action with the lowest value; 0 when all are ruled out."""
    worst = -1
    for action in range(n):
        if not ruled_out[action] and (worst < 0 or values[action] < values[worst]):
            worst = action
    return max(worst, 0)


@kernel
def mean_and_sd(values: Floats, ruled_out: Bools, n: int) -> tuple[float, float]:
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
def chance_of_right(advice: float) -> float:
    """Return 1 / (1 + e^-advice): the probability of Advise, advice being d ln(C / (1 - C))."""
    if advice >= 0.0:
        return 1.0 / (1.0 + exponential(-advice))
    return exponential(advice) / (1.0 + exponential(advice))


class Terms(NamedTuple):
    """What f(R, H) of one decision is made of, the same for all its actions."""

    form: int
    """LINEAR, EXPONENTIAL, LINEAR_RAW or ADVISE; LINEAR_RAW where H has no weight."""
    soft: bool
    """The score is to be a logit, not the argument of an argmax: of Advise, log f."""
    centre_r: float
    """What is subtracted from R."""
    gain_r: float
    """What R, less its centre, is multiplied by."""
    centre_h: float
    """What is subtracted from H."""
    gain_h: float
    """What H, less its centre, is multiplied by; where the form is EXPONENTIAL, w_h itself."""
    range_h: float
    """Highest less lowest H, where the form is EXPONENTIAL."""


@inner_kernel
def terms_of(
    env_values: Floats,
    human_values: Floats,
    ruled_out: Bools,
    n: int,
    form: int,
    w_r: float,
    w_h: float,
    soft: bool,
) -> Terms:
    """Return what f(R, H) of a decision is made of; arguments as in `choose` and `fill_logits`."""
    if form == EXPONENTIAL and w_h != 0.0:
        low_r = env_values[worst_action(env_values, ruled_out, n)]
        low_h = human_values[worst_action(human_values, ruled_out, n)]
        range_h = human_values[best_action(human_values, ruled_out, n)] - low_h
        return Terms(EXPONENTIAL, soft, low_r, w_r, low_h, w_h, range_h)
    if form == LINEAR_RAW or w_h == 0.0:
        return Terms(LINEAR_RAW, soft, 0.0, w_r, 0.0, w_h, 0.0)
    mean_r, spread_r = mean_and_sd(env_values, ruled_out, n)
    mean_h, spread_h = mean_and_sd(human_values, ruled_out, n)
    # A constant row becomes zeros.
    gain_r = w_r / spread_r if spread_r > 0.0 else 0.0
    gain_h = w_h / spread_h if spread_h > 0.0 else 0.0
    if soft:
        # R keeps the sharpness that learning gave it (`docs/decisions/policy-gradient.md`).
        scale = max(1.0, spread_r) if form == LINEAR else 1.0
        gain_h = w_h * scale / spread_h if spread_h > 0.0 else 0.0
        return Terms(form, soft, 0.0, w_r, mean_h, gain_h, 0.0)
    if form == ADVISE:
        mean_r = env_values[best_action(env_values, ruled_out, n)]
    return Terms(form, soft, mean_r, gain_r, mean_h, gain_h, 0.0)


@inner_kernel
def score(env_value: float, human_value: float, terms: Terms) -> tuple[float, float]:
    """Return f(R, H) of one action, and its derivative by the action's R (of Advise: that of log f).

    Linear: w_r R + w_h H (Eq. 3), each less its mean and divided by its sd where the form says so.
    Exponential: w_r (R - min R)(1 + h^w_h), h being H mapped to [0, 1], 1 - h in its place where w_h < 0
    (section 3.1); w_r is 1 in every scheme. Advise: e^(w_r R) P(w_h H).
    """
    if terms.form == EXPONENTIAL:
        fraction = (human_value - terms.centre_h) / terms.range_h if terms.range_h > 0.0 else 0.0
        fraction = min(max(fraction, 0.0), 1.0)  # of actions that are ruled out
        if terms.gain_h < 0.0:
            fraction = 1.0 - fraction
        gain = terms.gain_r * (1.0 + math.pow(fraction, abs(terms.gain_h)))
        return gain * (env_value - terms.centre_r), gain
    environment = (env_value - terms.centre_r) * terms.gain_r
    human = (human_value - terms.centre_h) * terms.gain_h
    if terms.form == ADVISE:
        right = chance_of_right(human)
        if terms.soft:
            return environment + math.log(max(right, LEAST_CHANCE)), terms.gain_r
        return exponential(environment) * right, terms.gain_r
    return environment + human, terms.gain_r


@kernel
def choose(
    env_values: Floats, human_values: Floats, ruled_out: Bools, n: int, form: int, w_r: float, w_h: float
) -> int:
    """Return argmax f(R, H) over the actions that are not ruled out (Eq. 2); the lowest index wins ties.

    Args:
        env_values: R of each action, shape (>= n,).
        human_values: H of each action, shape (>= n,).
        ruled_out: actions that are not to be taken, shape (>= n,). If all are, the answer is 0.
        n: number of actions, >= 1.
        form: LINEAR, EXPONENTIAL, LINEAR_RAW or ADVISE (`core.combination.episode_weights`).
        w_r: weight of R, >= 0.
        w_h: weight of H. 0 gives exactly `best_action(env_values)` whatever the form.
    """
    if w_h == 0.0:
        return best_action(env_values, ruled_out, n)
    if w_r == 0.0 and form != EXPONENTIAL:
        if w_h > 0.0:
            return best_action(human_values, ruled_out, n)
        return worst_action(human_values, ruled_out, n)
    terms = terms_of(env_values, human_values, ruled_out, n, form, w_r, w_h, False)
    best = -1
    best_value = 0.0
    for action in range(n):
        if not ruled_out[action]:
            value = score(env_values[action], human_values[action], terms)[0]
            if best < 0 or value > best_value:
                best = action
                best_value = value
    return max(best, 0)


@kernel
def fill_logits(
    env_values: Floats,
    human_values: Floats,
    ruled_out: Bools,
    n: int,
    form: int,
    w_r: float,
    w_h: float,
    logits: Floats,
    gains: Floats,
) -> int:
    """Write f(R, H) of each action as logits, and their derivative by the action's R.

    Linear: w_r R + w_h s H', H' being H standardised over the actions and s the larger of 1 and the sd of R.
    That is Eq. 3 with both standardised, times a factor of the decision: R keeps the sharpness that learning
    gave it (`docs/decisions/policy-gradient.md`). Advise: w_r R + log P(w_h H'). The others: as in `choose`.

    Args:
        env_values: R of each action, shape (>= n,).
        human_values: H of each action, shape (>= n,).
        ruled_out: actions that are not to be taken, shape (>= n,).
        n: number of actions, >= 1.
        form: as in `choose`.
        w_r: weight of R, > 0.
        w_h: weight of H.
        logits: written, shape (>= n,).
        gains: written, shape (>= n,).

    Returns:
        The action whose R counts as 0 in the derivative; -1 where all gains are equal, so that none has to.
    """
    terms = terms_of(env_values, human_values, ruled_out, n, form, w_r, w_h, True)
    for action in range(n):
        logits[action], gains[action] = score(env_values[action], human_values[action], terms)
    return worst_action(env_values, ruled_out, n) if terms.form == EXPONENTIAL else -1


@kernel
def takes_control(seed: int, decision: int, handover: float) -> bool:
    """Return whether the human model's best action is taken in this decision (control sharing).

    Args:
        seed: seed of the episode's stream, in [0, 2**62).
        decision: number of the decision in the episode, >= 0.
        handover: probability, in [0, 1].

    Returns:
        True with probability `handover`; the same for the same arguments in compiled and plain Python.
    """
    return uniform_at(seed, decision) < handover
