"""How sure a gamma delay is: profile-likelihood and bootstrap intervals of its parameters and of what they mean.

Shape and scale of a gamma trade off against each other, and both against the offset; the mean and the quantiles are
known far better. Reports therefore lead with mean, mode, sd, 5 %, 50 % and 95 %.
"""

import math
from collections.abc import Callable
from functools import cache

import msgspec
import numpy as np
from numpy.typing import NDArray
from scipy import optimize, special, stats

from studies.reaction_time import gamma_profile, kernels
from studies.reaction_time.families import FAMILIES, GAMMA, SHIFTED_GAMMA, Family, FamilyFit
from studies.reaction_time.sample import FitError, Sample

Array = NDArray[np.float64]
QUANTITIES = ("shape", "scale_s", "offset_s", "mean_s", "mode_s", "sd_s", "q05_s", "q50_s", "q95_s")
_QUANTILES = {"q05_s": 0.05, "q50_s": 0.5, "q95_s": 0.95}
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


def gamma_quantities(shape: Array | float, scale_s: Array | float, offset_s: Array | float) -> dict[str, Array]:
    """Return parameters and derived mean, mode, sd and quantiles (seconds), broadcast over the arguments."""
    k, scale, offset = np.broadcast_arrays(
        np.asarray(shape, np.float64), np.asarray(scale_s, np.float64), np.asarray(offset_s, np.float64)
    )
    result = {
        "shape": k,
        "scale_s": scale,
        "offset_s": offset,
        "mean_s": offset + k * scale,
        "mode_s": offset + np.maximum(k - 1.0, 0.0) * scale,
        "sd_s": np.sqrt(k) * scale,
    }
    for name, p in _QUANTILES.items():
        result[name] = offset + scale * special.gammaincinv(k, p)
    return result


def quantities_of(fit: FamilyFit) -> dict[str, float]:
    """Return `gamma_quantities` of a gamma or shifted gamma fit as numbers."""
    p = fit.parameters
    found = gamma_quantities(p["shape"], p["scale_s"], p.get("offset_s", 0.0))
    return {name: float(value) for name, value in found.items()}


@cache
def _quantile_table(p: float) -> Array:
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
    _require_gamma(family)
    table = _quantile_table(_QUANTILES.get(quantity, 0.5))
    out = np.empty(3)
    return float(
        gamma_profile.profile(
            sample.observed_s,
            sample.censored_s,
            family.shifted,
            _WHICH[quantity],
            value,
            family.bound,
            table,
            out,
        )
    )


def profile_interval(sample: Sample, fit: FamilyFit, quantity: str, *, level: float = 0.95) -> Interval:
    """Return the values whose profile likelihood is within chi2(level, 1) / 2 of the maximum.

    Args:
        sample: the reaction times that were fitted.
        fit: the maximum-likelihood fit of a gamma or shifted gamma to them.
        quantity: one of `QUANTITIES` except the mode (which has no smooth profile where the shape is 1).
        level: nominal coverage, in (0, 1).
    """
    family = FAMILIES[fit.family]
    cut = fit.log_likelihood - 0.5 * float(stats.chi2.ppf(level, 1))
    centre = quantities_of(fit)[quantity]

    def excess(value: float) -> float:
        return profile_log_likelihood(sample, family, quantity, value) - cut

    if quantity == "offset_s":
        return _offset_interval(sample, family, centre, excess, level)
    floor = family.bound if quantity == "shape" else 0.0
    low, low_is_bound = _fall(excess, centre, 1.0 / 1.3, max(floor, 1e-6))
    high, high_is_bound = _fall(excess, centre, 1.3, SHAPE_CAP if quantity == "shape" else 1e3)
    return Interval(low=low, high=high, level=level, low_is_bound=low_is_bound, high_is_bound=high_is_bound)


def profile_intervals(sample: Sample, fit: FamilyFit, *, level: float = 0.95) -> dict[str, Interval]:
    """Return `profile_interval` for every quantity that has one (an offset only where one is fitted)."""
    names = [name for name in _WHICH if name != "offset_s" or FAMILIES[fit.family].shifted]
    return {name: profile_interval(sample, fit, name, level=level) for name in names}


def simulate_fits(
    fit: FamilyFit, sample: Sample, n_resamples: int, *, rng: np.random.Generator
) -> dict[str, Array]:
    """Draw samples from a fitted gamma and fit each again; return every quantity, shape (n_resamples,).

    Trials that were timed out have their waiting time as the time-out of the simulated trial as well. Where all
    waited equally long, that limit holds for all simulated trials; otherwise only for those trials.
    """
    family = FAMILIES[fit.family]
    _require_gamma(family)
    p = fit.parameters
    offset = p.get("offset_s", 0.0)
    draws = offset + rng.gamma(p["shape"], p["scale_s"], size=(n_resamples, sample.n))
    draws = np.maximum(draws, max(offset, 1e-6) + 1e-9)
    found = np.empty((n_resamples, 3))
    if sample.censored_s.size == 0:
        kernels.fit_many(draws, kernels.GAMMA, family.bound, family.shifted, found)
    else:
        _fit_censored_draws(draws, sample, family, found)
    return gamma_quantities(found[:, 0], found[:, 1], found[:, 2])


def bootstrap_intervals(
    fit: FamilyFit, draws: dict[str, Array], *, level: float = 0.95
) -> dict[str, Interval]:
    """Return intervals of every quantity from `simulate_fits`.

    Shape, scale, sd and mean are turned round their estimate on the log scale (estimate^2 / quantile), because the
    ratio of estimate and truth hardly depends on the truth; location-like quantities on their own scale. Values are
    clipped to the allowed region.
    """
    centre = quantities_of(fit)
    tail = 0.5 * (1.0 - level)
    result = {}
    for name, values in draws.items():
        low, high = np.quantile(values, [tail, 1.0 - tail])
        result[name] = _turn(name, centre[name], float(low), float(high), FAMILIES[fit.family], level)
    return result


def _turn(name: str, centre: float, low: float, high: float, family: Family, level: float) -> Interval:
    if name in ("shape", "scale_s", "sd_s"):
        ends = (centre * centre / high, centre * centre / low)
        floor = family.bound if name == "shape" else 0.0
    else:
        ends = (2.0 * centre - high, 2.0 * centre - low)
        floor = 0.0
    return Interval(
        low=max(ends[0], floor), high=max(ends[1], floor), level=level, low_is_bound=ends[0] < floor
    )


def _fit_censored_draws(draws: Array, sample: Sample, family: Family, found: Array) -> None:
    limits = np.full(sample.n, np.inf)
    if np.ptp(sample.censored_s) < 1e-9:
        limits[:] = sample.censored_s[0]
    else:
        limits[: sample.censored_s.size] = sample.censored_s
    table = _quantile_table(0.5)
    for row, out in zip(draws, found, strict=True):
        late = row >= limits
        if np.count_nonzero(~late) < 2:
            raise FitError("nearly every trial is timed out: the delay cannot be simulated; lengthen the time-out")
        gamma_profile.profile(
            np.sort(row[~late]), limits[late], family.shifted, gamma_profile.FREE, 0.0, family.bound, table, out
        )


def _fall(
    excess: Callable[[float], float], centre: float, factor: float, limit: float
) -> tuple[float, bool]:
    """Return where `excess` crosses zero going from `centre` towards `limit`; the limit itself if it does not."""
    inside = centre
    while True:
        outside = inside * factor
        beyond = outside >= limit if factor > 1.0 else outside <= limit
        outside = limit if beyond else outside
        if excess(outside) < 0.0:
            root = optimize.brentq(lambda t: excess(math.exp(t)), math.log(inside), math.log(outside), xtol=1e-6)
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


def _require_gamma(family: Family) -> None:
    if family not in (GAMMA, SHIFTED_GAMMA):
        raise ValueError(f"intervals are computed for gamma and shifted gamma, not for {family.name!r}")
