"""Statistics of results: arrays in, numbers out. Every resampling takes a named stream."""

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike, NDArray


@dataclass(frozen=True, slots=True)
class Interval:
    """An estimate with its interval."""

    estimate: float
    low: float
    high: float
    level: float = 0.95

    def __str__(self) -> str:
        return f"{self.estimate:.3g} [{self.low:.3g}, {self.high:.3g}]"


FEW_TRIALS = 10
"""Fewer trials than this make intervals that are too short to be taken at their word."""
_COVERAGE = {
    2: (50, 46),
    3: (74, 69),
    4: (81, 75),
    5: (84, 78),
    6: (86, 80),
    7: (87, 82),
    8: (88, 83),
    9: (89, 84),
}
"""Trials to how often (%) the 95 % percentile bootstrap interval of a mean holds the true one: normal and
exponential results. From 3000 simulated samples each, 600 resamples; a test does it again."""


def few_trials_note(n: int, what: str = "trials") -> str | None:
    """Return in words what so few trials do to intervals and tests; None where there are enough.

    Args:
        n: trials per condition, >= 1.
        what: what they are called, in the plural.
    """
    if n >= FEW_TRIALS:
        return None
    if n == 1:
        return (
            f"Only 1 of the {what} was played: there is no interval and no test. An interval that is shown "
            f"is the one number itself. Play at least {FEW_TRIALS}."
        )
    normal, exponential = _COVERAGE[n]
    found = (
        f"Only {n} {what}: intervals are too short. One that is called 95 % holds the true mean in about "
        f"{normal} % of cases, "
        f"and in {exponential} % where scores spread as those of games do (exponentially)."
    )
    smallest_p = 2.0 / 2.0**n
    if smallest_p >= 0.05:
        found += f" No p value can be below {smallest_p:.2g} with {n} pairs."
    return f"{found} Play at least {FEW_TRIALS}."


def mean_interval(
    values: ArrayLike, *, rng: np.random.Generator, level: float = 0.95, resamples: int = 2000
) -> Interval:
    """Return the mean with a bootstrap percentile interval.

    Args:
        values: independent results, shape (n,), n >= 1.
        rng: named stream; equal streams give equal intervals.
        level: coverage, in (0, 1).
        resamples: number of bootstrap samples.

    Returns:
        The interval is the point itself where n = 1 or all values are equal.
    """
    return _percentile_interval(_sample(values), _means, level, resamples, rng)


def median_interval(
    values: ArrayLike, *, rng: np.random.Generator, level: float = 0.95, resamples: int = 2000
) -> Interval:
    """Return the median with a bootstrap percentile interval; arguments as in `mean_interval`."""
    return _percentile_interval(_sample(values), _medians, level, resamples, rng)


def interquartile_mean_interval(
    values: ArrayLike, *, rng: np.random.Generator, level: float = 0.95, resamples: int = 2000
) -> Interval:
    """Return the mean without the lowest and the highest quarter, with a bootstrap percentile interval.

    floor(n / 4) values are left out on each side. Arguments as in `mean_interval`.
    """
    return _percentile_interval(_sample(values), _interquartile_means, level, resamples, rng)


def paired_ratio(
    treated: ArrayLike,
    control: ArrayLike,
    *,
    rng: np.random.Generator,
    level: float = 0.95,
    resamples: int = 2000,
) -> Interval:
    """Return the geometric mean of treated / control with a bootstrap interval; both > 0, paired by entry.

    For results whose spread grows with their size, as scores of games that end by chance.
    """
    first, second = _pair(treated, control)
    if min(first.min(), second.min()) <= 0:
        raise ValueError("a ratio of geometric means needs results > 0")
    found = mean_interval(np.log(first / second), rng=rng, level=level, resamples=resamples)
    return Interval(float(np.exp(found.estimate)), float(np.exp(found.low)), float(np.exp(found.high)), level)


def paired_difference(
    treated: ArrayLike,
    control: ArrayLike,
    *,
    rng: np.random.Generator,
    level: float = 0.95,
    resamples: int = 2000,
) -> Interval:
    """Return the mean of treated - control with a bootstrap interval; entry i of both has the same seed."""
    first, second = _pair(treated, control)
    return mean_interval(first - second, rng=rng, level=level, resamples=resamples)


def _sample(values: ArrayLike) -> NDArray[np.float64]:
    sample = np.asarray(values, dtype=np.float64)
    if sample.ndim != 1 or len(sample) == 0:
        raise ValueError(f"need results of shape (n,), n >= 1, got shape {sample.shape}")
    if not np.isfinite(sample).all():
        raise ValueError(f"results must be finite; entry {int(np.argmin(np.isfinite(sample)))} is not")
    return sample


def _pair(treated: ArrayLike, control: ArrayLike) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    first, second = _sample(treated), _sample(control)
    if first.shape != second.shape:
        raise ValueError(f"pairs need equal numbers of results, got {len(first)} and {len(second)}")
    return first, second


def _resampled(sample: NDArray[np.float64], resamples: int, rng: np.random.Generator) -> NDArray[np.float64]:
    """Return bootstrap samples, shape (resamples, n)."""
    picked: NDArray[np.float64] = sample[rng.integers(0, len(sample), size=(resamples, len(sample)))]
    return picked


def _percentile_interval(
    sample: NDArray[np.float64],
    statistic: Callable[[NDArray[np.float64]], NDArray[np.float64]],
    level: float,
    resamples: int,
    rng: np.random.Generator,
) -> Interval:
    estimate = float(statistic(sample[None, :])[0])
    return _interval(estimate, statistic(_resampled(sample, resamples, rng)), level)


def _interval(estimate: float, resampled: NDArray[np.float64], level: float) -> Interval:
    low, high = np.quantile(resampled, [(1 - level) / 2, (1 + level) / 2])
    return Interval(estimate, float(low), float(high), level)


def _means(samples: NDArray[np.float64]) -> NDArray[np.float64]:
    return np.asarray(samples.mean(axis=1))


def _medians(samples: NDArray[np.float64]) -> NDArray[np.float64]:
    return np.asarray(np.median(samples, axis=1))


def _interquartile_means(samples: NDArray[np.float64]) -> NDArray[np.float64]:
    cut = samples.shape[1] // 4
    return np.asarray(np.sort(samples, axis=1)[:, cut : samples.shape[1] - cut].mean(axis=1))
