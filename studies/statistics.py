"""Statistics of results: arrays in, numbers out. Every resampling takes a named stream."""

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
    sample = _sample(values)
    means = _resampled_means(sample, resamples, rng)
    low, high = np.quantile(means, [(1 - level) / 2, (1 + level) / 2])
    return Interval(float(sample.mean()), float(low), float(high), level)


def paired_difference(
    treated: ArrayLike,
    control: ArrayLike,
    *,
    rng: np.random.Generator,
    level: float = 0.95,
    resamples: int = 2000,
) -> Interval:
    """Return the mean of treated - control with a bootstrap interval; entry i of both has the same seed."""
    first, second = _sample(treated), _sample(control)
    if first.shape != second.shape:
        raise ValueError(f"pairs need equal numbers of results, got {len(first)} and {len(second)}")
    return mean_interval(first - second, rng=rng, level=level, resamples=resamples)


def _sample(values: ArrayLike) -> NDArray[np.float64]:
    sample = np.asarray(values, dtype=np.float64)
    if sample.ndim != 1 or len(sample) == 0:
        raise ValueError(f"need results of shape (n,), n >= 1, got shape {sample.shape}")
    if not np.isfinite(sample).all():
        raise ValueError(f"results must be finite; entry {int(np.argmin(np.isfinite(sample)))} is not")
    return sample


def _resampled_means(
    sample: NDArray[np.float64], resamples: int, rng: np.random.Generator
) -> NDArray[np.float64]:
    picks = rng.integers(0, len(sample), size=(resamples, len(sample)))
    means: NDArray[np.float64] = sample[picks].mean(axis=1)
    return means
