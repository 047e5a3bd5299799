"""A density of the delay for each value of a press, fitted to recorded evaluations: a credit rule for
protocols.
"""

from collections.abc import Sequence

import numpy as np

from core.feedback.delays import GammaDelay, PerValueDelay, ValueDelay
from core.numerics.arrays import Floats
from studies.evaluations.presses import Press
from studies.reaction_time.exclusion import SLOW_ABOVE_S, ExclusionPolicy
from studies.reaction_time.families import GAMMA, fit_family
from studies.reaction_time.sample import sample

FEWEST = 20
"""A value with fewer delays gets the density of all."""


def fit_per_value(presses: Sequence[Press], *, fewest: int = FEWEST) -> PerValueDelay:
    """Return gamma densities by value, by maximum likelihood, and one of all presses for other values.

    Delays outside the limits of evaluations (`studies.reaction_time.exclusion`) are left out.

    Args:
        presses: with delays since the event judged.
        fewest: a value with fewer delays has no density of its own.

    Raises:
        ValueError: there are fewer than `fewest` delays in all.
    """
    low_s, high_s = ExclusionPolicy().anticipation_below_s, SLOW_ABOVE_S["evaluation"]
    known = [
        (press.value, press.delay_s)
        for press in presses
        if press.delay_s is not None and low_s <= press.delay_s <= high_s
    ]
    if len(known) < fewest:
        raise ValueError(
            f"need at least {fewest} presses with a delay of {low_s:g} to {high_s:g} s, got {len(known)}"
        )
    values = np.array([value for value, _ in known])
    delays_s = np.array([delay_s for _, delay_s in known])
    found = [
        ValueDelay(float(value), _gamma(delays_s[values == value]))
        for value in np.unique(values)
        if (values == value).sum() >= fewest
    ]
    return PerValueDelay(tuple(found), _gamma(delays_s))


def _gamma(delays_s: Floats) -> GammaDelay:
    fitted = fit_family(GAMMA, sample(delays_s)).parameters
    return GammaDelay(round(fitted["shape"], 3), round(fitted["scale_s"], 4))
