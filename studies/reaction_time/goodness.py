"""Goodness of fit with estimated parameters: the p-value knows that the parameters came from the same data.

`scipy.stats.goodness_of_fit` draws samples from the fit and fits each again. It would call scipy's own `fit`,
which is unsafe with a free offset, so it is handed distributions whose `fit` is the one of `families`.
"""

from functools import cache
from typing import Any

import msgspec
import numpy as np
from numpy.typing import NDArray
from scipy import stats

from studies.reaction_time.families import FAMILIES, FamilyFit, distribution, fit_observed
from studies.reaction_time.sample import FitError, Sample


class Goodness(msgspec.Struct, frozen=True, kw_only=True):
    """How often a sample drawn from the fit lies as far from its own fit as the data from theirs."""

    statistic_name: str
    statistic: float
    p_value: float
    n_resamples: int


def goodness_of_fit(
    sample: Sample,
    fit: FamilyFit,
    *,
    rng: np.random.Generator,
    n_resamples: int = 499,
    statistic: str = "ad",
) -> Goodness:
    """Return the Monte-Carlo p-value of a fit with its parameters re-estimated in every resample.

    Args:
        sample: the fitted reaction times, without time-outs.
        fit: the family fitted to them.
        rng: draws the resamples.
        n_resamples: how many; the smallest possible p-value is 1 / (n_resamples + 1).
        statistic: "ad" (Anderson-Darling, weighs the tails), "ks" or "cvm".

    Raises:
        FitError: with time-outs, where these statistics are not defined.
    """
    if sample.censored_s.size:
        raise FitError(
            f"goodness of fit is not defined with {sample.censored_s.size} timed-out trials: compare AIC, "
            f"look at the Q-Q"
        )
    found = stats.goodness_of_fit(
        _safe_distribution(fit.family),
        sample.observed_s,
        statistic=statistic,  # type: ignore[arg-type]
        n_mc_samples=n_resamples,
        rng=rng,
    )
    return Goodness(
        statistic_name=statistic,
        statistic=float(found.statistic),
        p_value=float(found.pvalue),
        n_resamples=n_resamples,
    )


def q_q(sample: Sample, fit: FamilyFit) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """Return (fitted quantiles, observed times) in seconds, both shape (n,), increasing.

    Plotting positions are (i - 0.5) / n of all trials; time-outs, being longer than what was seen, come last
    and have no point.
    """
    positions = (np.arange(sample.observed_s.size) + 0.5) / sample.n
    return np.asarray(distribution(fit).ppf(positions)), sample.observed_s


@cache
def _safe_distribution(name: str) -> Any:
    """Return scipy's distribution of a family with `fit` replaced by ours."""
    family = FAMILIES[name]
    original = family.freeze([1.0] * len(family.parameters)).dist
    base: Any = type(original)

    class Safe(base):  # type: ignore[misc]
        def fit(self, times: NDArray[np.float64], *args: Any, **kwds: Any) -> tuple[float, float, float]:
            values, _ = fit_observed(family, np.sort(times))
            frozen = family.freeze(values.tolist())
            return float(frozen.args[0]), float(frozen.kwds["loc"]), float(frozen.kwds["scale"])

    return Safe(a=original.a, b=original.b, name=original.name)
