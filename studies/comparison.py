"""Comparing two conditions: tests that assume little, effect sizes, and the correction for asking often."""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike, NDArray

from studies.statistics import Interval


def probability_of_improvement(treated: ArrayLike, control: ArrayLike) -> float:
    """Return P(treated > control) + P(equal) / 2 for independent draws of both (Agarwal et al. 2021).

    That is Mann and Whitney's U over the number of pairs.

    Args:
        treated: results, shape (n,), n >= 1.
        control: results, shape (m,), m >= 1.
    """
    first, second = np.asarray(treated, dtype=np.float64), np.asarray(control, dtype=np.float64)
    if first.ndim != 1 or second.ndim != 1 or not len(first) or not len(second):
        raise ValueError(f"need two rows of results, got shapes {first.shape} and {second.shape}")
    return float(_wins(first, second).mean())


def _wins(first: NDArray[np.float64], second: NDArray[np.float64]) -> NDArray[np.float64]:
    """Return 1 where an entry of `first` is above one of `second`, 1/2 where equal, else 0, shape (n, m)."""
    above = first[:, None] > second[None, :]
    equal = first[:, None] == second[None, :]
    return np.asarray(above + equal / 2, dtype=np.float64)


def probability_interval(
    treated: ArrayLike,
    control: ArrayLike,
    *,
    rng: np.random.Generator,
    level: float = 0.95,
    resamples: int = 2000,
) -> Interval:
    """Return `probability_of_improvement` with a bootstrap interval, both conditions resampled by
    themselves.
    """
    first, second = np.asarray(treated, dtype=np.float64), np.asarray(control, dtype=np.float64)
    estimate = probability_of_improvement(first, second)
    # How often each result is drawn in each resample.
    n, m = len(first), len(second)
    drawn_first = rng.multinomial(n, np.full(n, 1 / n), size=resamples)
    drawn_second = rng.multinomial(m, np.full(m, 1 / m), size=resamples)
    drawn = ((drawn_first @ _wins(first, second)) * drawn_second).sum(axis=1) / (n * m)
    low, high = np.quantile(drawn, [(1 - level) / 2, (1 + level) / 2])
    return Interval(estimate, float(low), float(high), level)


def sign_flip_p(differences: ArrayLike, *, rng: np.random.Generator, flips: int = 20_000) -> float:
    """Return the two-sided p value of paired differences having mean 0, by flipping their signs at random.

    Exact but for the sampling of flips where differences are symmetric about 0 without an effect; it assumes
    no shape. Ties with what was seen count as extreme.

    Args:
        differences: of pairs, shape (n,), n >= 1.
        rng: named stream.
        flips: random sign patterns.

    Returns:
        A number in [1 / (flips + 1), 1].
    """
    sample = np.asarray(differences, dtype=np.float64)
    if sample.ndim != 1 or not len(sample) or not np.isfinite(sample).all():
        raise ValueError(f"need finite differences of shape (n,), n >= 1, got {sample}")
    signs = rng.integers(0, 2, size=(flips, len(sample))) * 2 - 1
    seen = abs(float(sample.sum()))
    # A flip that undoes itself must not miss equality by rounding.
    extreme = np.abs(signs @ sample) >= seen - 1e-12 * float(np.abs(sample).sum())
    return float((1 + int(extreme.sum())) / (flips + 1))


def holm(p_values: ArrayLike) -> NDArray[np.float64]:
    """Return p values adjusted for their number (Holm 1979): below alpha, they hold together at alpha.

    Args:
        p_values: of all hypotheses asked, shape (n,), in [0, 1].
    """
    p = np.asarray(p_values, dtype=np.float64)
    if p.ndim != 1 or (p < 0).any() or (p > 1).any():
        raise ValueError(f"p values are in [0, 1] and in one row, got {p}")
    order = np.argsort(p, kind="stable")
    scaled = p[order] * np.arange(len(p), 0, -1)
    adjusted = np.empty_like(p)
    adjusted[order] = np.minimum(np.maximum.accumulate(scaled), 1.0)
    return adjusted


def paired_effect_size(differences: ArrayLike) -> float:
    """Return Cohen's d_z: mean over standard deviation (n - 1) of the differences; inf or 0 where none
    varies.
    """
    sample = np.asarray(differences, dtype=np.float64)
    if sample.ndim != 1 or len(sample) < 2:
        raise ValueError(f"an effect size needs at least 2 differences, got shape {sample.shape}")
    mean, spread = float(sample.mean()), float(sample.std(ddof=1))
    if spread == 0:
        return 0.0 if mean == 0 else float(np.copysign(np.inf, mean))
    return mean / spread


@dataclass(frozen=True, slots=True)
class Verdict:
    """One comparison, as a report states it."""

    treated: str
    control: str
    ratio: Interval
    """Geometric mean of treated / control over pairs."""
    difference: Interval
    """Mean of treated - control over pairs."""
    improvement: Interval
    """Probability of improvement."""
    effect_size: float
    """d_z of the logarithms' differences."""
    p: float
    """Two-sided, sign flips of the logarithms' differences."""
    p_holm: float
    """The same, adjusted for all comparisons of the report."""


def adjusted(verdicts: Sequence[Verdict]) -> list[Verdict]:
    """Return the verdicts with `p_holm` for their number."""
    from dataclasses import replace

    corrected = holm([verdict.p for verdict in verdicts])
    return [replace(verdict, p_holm=float(p)) for verdict, p in zip(verdicts, corrected, strict=True)]
