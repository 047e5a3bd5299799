"""How sure a gamma delay is: profile-likelihood intervals of its parameters and of what they mean.

Shape and scale of a gamma trade off against each other, and both against the offset; the mean and the
quantiles are known far better. Reports therefore lead with mean, mode, sd, 5 %, 50 % and 95 %.
"""

import math
from collections.abc import Callable, Mapping
from functools import cache

import msgspec
import numpy as np
from scipy import optimize, special, stats

from core.numerics.arrays import Floats
from studies.reaction_time import gamma_profile, kernels
from studies.reaction_time.families import FAMILIES, FamilyFit
from studies.reaction_time.family import Family
from studies.reaction_time.quantities import QUANTILES, quantities_of, require_gamma
from studies.reaction_time.sample import FitError, Sample

_WHICH = {
    "shape": gamma_profile.SHAPE,
    "scale_s": gamma_profile.SCALE,
    "offset_s": gamma_profile.OFFSET,
    "mean_s": gamma_profile.MEAN,
    "sd_s": gamma_profile.SD,
    "q05_s": gamma_profile.QUANTILE,
    "q50_s": gamma_profile.QUANTILE,
    "q95_s": gamma_profile.QUANTILE,
}
SHAPE_CAP = 1e5
"""An upper limit of the shape above this is reported as open: the density is a normal one by then."""


class Interval(msgspec.Struct, frozen=True, kw_only=True):
    """An interval of one quantity."""

    low: float
    high: float
    level: float
    """Nominal coverage, e.g. 0.95."""
    low_is_bound: bool = False
    """The interval ends at the edge of the allowed region, not where the likelihood falls."""
    high_is_bound: bool = False


@cache
def quantile_table(p: float) -> Floats:
    """Return log quantiles of the unit-scale gamma on the shapes `gamma_profile` expects."""
    shapes = np.exp(
        np.linspace(gamma_profile.LOG_SHAPE_LOW, gamma_profile.LOG_SHAPE_HIGH, gamma_profile.TABLE_SIZE)
    )
    return np.asarray(np.log(np.maximum(special.gammaincinv(shapes, p), 1e-300)))


def profile_log_likelihood(sample: Sample, family: Family, quantity: str, value: float) -> float:
    """Return the highest log-likelihood with `quantity` equal to `value`; -inf where no parameters give it.

    Args:
        sample: the participant's reaction times; time-outs count as right-censored.
        family: `GAMMA` or `SHIFTED_GAMMA`.
        quantity: one of `QUANTITIES` except the mode.
        value: seconds, or a number for the shape; > 0 (an offset: 0 <= value < fastest response).
    """
    require_gamma(family)
    table = quantile_table(QUANTILES.get(quantity, 0.5))
    out = np.empty(3)
    return float(
        gamma_profile.profile(
            sample.observed_s,
            sample.waits,
            family.shifted,
            _WHICH[quantity],
            float(value),
            family.bound,
            table,
            out,
        )
    )


def profile_interval(
    sample: Sample, fit: FamilyFit, quantity: str, *, level: float = 0.95, cut: float | None = None
) -> Interval:
    """Return the values whose profile likelihood is within cut / 2 of the maximum.

    Args:
        sample: the reaction times that were fitted.
        fit: the maximum-likelihood fit of a gamma or shifted gamma to them.
        quantity: one of `QUANTITIES` except the mode (which has no smooth profile where the shape is 1).
        level: nominal coverage, in (0, 1).
        cut: critical value of the likelihood ratio; chi2(level, 1) unless given (see
            `bootstrap.critical_values`).

    Raises:
        FitError: where the likelihood at the fit itself is not found again.
    """
    if cut is None:
        cut = float(stats.chi2.ppf(level, 1))
    family = FAMILIES[fit.family]
    threshold = fit.log_likelihood - 0.5 * cut
    centre = quantities_of(fit)[quantity]

    def excess(value: float) -> float:
        return profile_log_likelihood(sample, family, quantity, value) - threshold

    if not excess(centre) >= 0.0:
        raise FitError(
            f"the likelihood of these {sample.n} trials has no interval of {quantity} around {centre:.4g}: "
            f"numerical trouble"
        )
    if quantity == "offset_s":
        return _offset_interval(sample, family, centre, excess, level)
    floor = family.bound if quantity == "shape" else 0.0
    low, low_is_bound = _fall(excess, centre, 1.0 / 1.3, max(floor, 1e-6))
    high, high_is_bound = _fall(excess, centre, 1.3, SHAPE_CAP if quantity == "shape" else 1e3)
    return Interval(low=low, high=high, level=level, low_is_bound=low_is_bound, high_is_bound=high_is_bound)


def profile_intervals(
    sample: Sample, fit: FamilyFit, *, level: float = 0.95, cuts: Mapping[str, float] | None = None
) -> dict[str, Interval]:
    """Return `profile_interval` for every quantity that has one (an offset only where one is fitted)."""
    names = [name for name in _WHICH if name != "offset_s" or FAMILIES[fit.family].shifted]
    given = cuts or {}
    return {name: profile_interval(sample, fit, name, level=level, cut=given.get(name)) for name in names}


def _fall(excess: Callable[[float], float], centre: float, factor: float, limit: float) -> tuple[float, bool]:
    """Return where `excess` crosses zero going from `centre` towards `limit`; the limit itself if it does
    not.
    """
    inside = centre
    if (centre >= limit) if factor > 1.0 else (centre <= limit):
        return centre, True
    while True:
        outside = inside * factor
        beyond = outside >= limit if factor > 1.0 else outside <= limit
        outside = limit if beyond else outside
        if excess(outside) < 0.0:
            root = optimize.brentq(
                lambda t: excess(math.exp(t)), math.log(inside), math.log(outside), xtol=1e-6
            )
            return math.exp(float(root)), False
        if beyond:
            return limit, True
        inside = outside


def _offset_interval(
    sample: Sample, family: Family, centre: float, excess: Callable[[float], float], level: float
) -> Interval:
    """Search offsets from 0 to the fastest response; distances to the latter on a log scale."""
    fastest = float(sample.observed_s[0])
    nearest = fastest - kernels.SMALLEST_GAP_S
    low, low_is_bound = 0.0, True
    if centre > 0.0 and excess(0.0) < 0.0:
        low, low_is_bound = float(optimize.brentq(excess, 0.0, centre, xtol=1e-7)), False
    high, high_is_bound = nearest, True
    if centre < nearest and excess(nearest) < 0.0:
        gap = optimize.brentq(
            lambda v: excess(fastest - math.exp(v)),
            math.log(kernels.SMALLEST_GAP_S),
            math.log(fastest - centre),
            xtol=1e-6,
        )
        high, high_is_bound = fastest - math.exp(float(gap)), False
    return Interval(low=low, high=high, level=level, low_is_bound=low_is_bound, high_is_bound=high_is_bound)
