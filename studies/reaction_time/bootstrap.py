"""Parametric bootstrap of a gamma delay: draw samples from the fit, fit each again, see how the results
scatter.

Two uses. Percentiles of the refitted quantities are intervals by themselves: right for mean, median, sd and
95 % point, too narrow for shape, scale and offset of the shifted gamma. For those the refits give the
critical value of the likelihood ratio that the profile intervals then use instead of chi-squared (measured in
docs/trusting-a-fit.md).
"""

from collections.abc import Iterable
from dataclasses import dataclass
from itertools import islice

import numpy as np
from scipy import stats

from core.numerics.arrays import Floats
from studies.reaction_time import gamma_profile
from studies.reaction_time.families import FAMILIES, FamilyFit
from studies.reaction_time.family import Family
from studies.reaction_time.intervals import Interval, profile_log_likelihood, quantile_table
from studies.reaction_time.quantities import gamma_quantities, quantities_of, require_gamma
from studies.reaction_time.sample import FitError, Sample

CALIBRATED = ("shape", "scale_s", "offset_s", "q05_s")
"""Quantities whose likelihood ratio is farther from chi-squared than chance at 100 trials."""

MOST_ROUNDS = 10
"""Times that a whole set of samples is drawn, at most, to have enough that can be fitted."""


@dataclass(frozen=True, slots=True, eq=False)
class Resamples:
    """Samples drawn from a fit, and their own fits."""

    samples: tuple[Sample, ...]
    log_likelihoods: Floats
    """Maximum log-likelihood of each sample, shape (n_resamples,)."""
    quantities: dict[str, Floats]
    """Every quantity of each refit, shape (n_resamples,)."""


def resample(fit: FamilyFit, sample: Sample, n_resamples: int, *, rng: np.random.Generator) -> Resamples:
    """Draw `n_resamples` samples of as many trials from a gamma or shifted gamma fit, and fit each.

    Where trials were timed out, simulated trials are too: all at the same limit if all waited equally long,
    otherwise each at the limit of its own trial. A simulated sample that nobody would fit (fewer than
    `MIN_RESPONSES` responses, or all alike) is drawn again.

    Raises:
        FitError: where so many trials are timed out that hardly any simulated sample keeps enough responses.
    """
    family = FAMILIES[fit.family]
    require_gamma(family)
    p = fit.parameters
    offset = p.get("offset_s", 0.0)
    limits = _limits(sample)
    samples: list[Sample] = []
    for _ in range(MOST_ROUNDS):
        draws = offset + rng.gamma(p["shape"], p["scale_s"], size=(n_resamples, sample.n))
        usable = (one for row in draws if (one := _censor(row, limits)) is not None)
        samples += islice(usable, n_resamples - len(samples))
        if len(samples) == n_resamples:
            break
    else:
        raise FitError(
            f"too few trials without a time-out ({sample.observed_s.size} of {sample.n}): the fit cannot be "
            f"simulated; "
            "lengthen the time-out or run more trials"
        )
    found = np.empty((n_resamples, 3))
    tops = np.array([_fit(one, family, row) for one, row in zip(samples, found, strict=True)])
    return Resamples(tuple(samples), tops, gamma_quantities(found[:, 0], found[:, 1], found[:, 2]))


def percentile_intervals(resamples: Resamples, *, level: float = 0.95) -> dict[str, Interval]:
    """Return the central `level` part of each refitted quantity."""
    tail = 0.5 * (1.0 - level)
    ends = {name: np.quantile(values, [tail, 1.0 - tail]) for name, values in resamples.quantities.items()}
    return {
        name: Interval(low=float(low), high=float(high), level=level) for name, (low, high) in ends.items()
    }


def critical_values(
    fit: FamilyFit, resamples: Resamples, *, level: float = 0.95, names: Iterable[str] = CALIBRATED
) -> dict[str, float]:
    """Return the `level` quantile of the likelihood ratio under the fit, never below that of chi-squared.

    The ratio of each simulated sample compares its own maximum with its profile at the value that made it.
    """
    family = FAMILIES[fit.family]
    truth = quantities_of(fit)
    least = float(stats.chi2.ppf(level, 1))
    cuts = {}
    for name in names:
        if name == "offset_s" and not family.shifted:
            continue
        profiles = np.array([_profile_at(one, family, name, truth[name]) for one in resamples.samples])
        cuts[name] = max(least, float(np.quantile(2.0 * (resamples.log_likelihoods - profiles), level)))
    return cuts


def _profile_at(sample: Sample, family: Family, name: str, value: float) -> float:
    if name == "offset_s":  # an offset on its upper bound lies a tick above the fastest simulated response
        value = min(value, float(sample.observed_s[0]) - 1e-9)
    return profile_log_likelihood(sample, family, name, value)


def _limits(sample: Sample) -> Floats:
    limits = np.full(sample.n, np.inf)
    waits = sample.censored_s
    if waits.size and np.ptp(waits) < 1e-9:
        limits[:] = waits[0]
    else:
        limits[: waits.size] = waits
    return limits


def _censor(times: Floats, limits: Floats) -> Sample | None:
    """Return the sample that these trials make; None where it could not be fitted."""
    late = times >= limits
    try:
        return Sample(np.maximum(times[~late], 1e-6), limits[late])
    except FitError:
        return None


def _fit(sample: Sample, family: Family, out: Floats) -> float:
    """Fill out with (shape, scale, offset); return the log-likelihood."""
    out[2] = 0.0
    return float(
        gamma_profile.profile(
            sample.observed_s,
            sample.waits,
            family.shifted,
            gamma_profile.FREE,
            0.0,
            family.bound,
            quantile_table(0.5),
            out,
        )
    )
