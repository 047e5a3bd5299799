"""Maximum likelihood with time-outs: a trial that waited c seconds without a response adds log P(time > c).

No closed forms remain, so two parameters are climbed at each offset and the offset is profiled as in
`kernels`. Agrees with `scipy.stats.CensoredData` likelihoods (tested), which is exact for right-censoring.
"""

from __future__ import annotations

import math

import numpy as np
from scipy import optimize, special

from core.numerics.arrays import Floats
from studies.reaction_time import gamma_profile, kernels
from studies.reaction_time.ascent import climb
from studies.reaction_time.family import Family
from studies.reaction_time.sample import Sample

_GRID = 14


def log_density(kind: int | None, a: float, b: float, y: Floats, c: float = 0.0) -> Floats:
    """Log density at y > 0 above the offset; (a, b) in the family's order, c is tau of the ex-Gaussian."""
    if kind == kernels.GAMMA:
        return special.xlogy(a - 1.0, y) - y / b - a * math.log(b) - math.lgamma(a)
    if kind == kernels.LOG_NORMAL:
        logs = np.log(y)
        return -logs - 0.5 * ((logs - a) / b) ** 2 - math.log(b * math.sqrt(2.0 * math.pi))
    if kind == kernels.WALD:
        return 0.5 * (math.log(b / (2.0 * math.pi)) - 3.0 * np.log(y) - b * (y - a) ** 2 / (a * a * y))
    if kind == kernels.WEIBULL:
        ratio = y / b
        return math.log(a / b) + special.xlogy(a - 1.0, ratio) - ratio**a
    z = (y - a) / b
    u = z - b / c
    return -math.log(c) + 0.5 * (b / c) ** 2 - (y - a) / c + special.log_ndtr(u)


def log_survival(kind: int | None, a: float, b: float, y: Floats, c: float = 0.0) -> Floats:
    """Log probability of a time above y > 0, parameters as in `log_density`."""
    if kind == kernels.GAMMA:
        ratio = y / b
        tail = special.gammaincc(a, ratio)
        far = (a - 1.0) * np.log(ratio) - ratio - math.lgamma(a)  # leading term where the tail underflows
        return np.where(tail > 1e-280, np.log(np.maximum(tail, 1e-300)), far)
    if kind == kernels.LOG_NORMAL:
        return special.log_ndtr((a - np.log(y)) / b)
    if kind == kernels.WALD:
        root = np.sqrt(b / y)
        above = special.log_ndtr(-root * (y / a - 1.0))
        below = 2.0 * b / a + special.log_ndtr(-root * (y / a + 1.0))
        return above + np.log1p(-np.exp(np.minimum(below - above, -1e-15)))
    if kind == kernels.WEIBULL:
        return -((y / b) ** a)
    return np.logaddexp(special.log_ndtr((a - y) / b), math.log(c) + log_density(kind, a, b, y, c))


def fit_censored(family: Family, sample: Sample) -> tuple[Floats, float]:
    """Return (parameters in the family's order, log-likelihood) with right-censored trials."""
    if family.kernel is None:
        return _fit_ex_gaussian(sample)
    if family.kernel == kernels.GAMMA:
        return _fit_gamma(family, sample)
    climb = _Climb(family, sample)
    if not family.shifted:
        pair, total = climb.at(0.0)
        return pair, total
    low = float(sample.observed_s[0])
    gaps = np.empty(_GRID)
    kernels.gap_grid(low, gaps)
    values = np.array([climb.at(low - gap)[1] for gap in gaps[::-1]])[::-1]
    best_offset, best = low - float(gaps[int(values.argmax())]), float(values.max())
    for j in range(_GRID):
        before, after = max(j - 1, 0), min(j + 1, _GRID - 1)
        if values[j] < max(values[before], values[after]):
            continue
        found = optimize.minimize_scalar(
            lambda v: -climb.at(low - math.exp(v))[1],
            bounds=(math.log(gaps[before]), math.log(gaps[after])),
            method="bounded",
            options={"xatol": 2e-4},
        )
        if -found.fun > best:
            best_offset, best = low - math.exp(float(found.x)), float(-found.fun)
    pair, best = climb.at(best_offset)
    return np.append(pair, best_offset), best


class _Climb:
    """Best two parameters above a given offset."""

    def __init__(self, family: Family, sample: Sample) -> None:
        assert family.kernel is not None
        self._kind = family.kernel
        self._bound = family.bound
        self._is_log_normal = family.kernel == kernels.LOG_NORMAL
        self._observed = sample.observed_s
        self._step = np.zeros(2)
        self._waited, self._counts = sample.waits.T

    def at(self, offset: float) -> tuple[Floats, float]:
        """Return the best (first, second) above `offset` and their log-likelihood."""
        y, waited = self._observed - offset, self._waited - offset
        alive = waited > 0.0  # a wait shorter than the offset tells nothing: survival is 1
        waited, counts = waited[alive], self._counts[alive]

        def height(theta: Floats) -> float:
            first, second = self._natural(theta)
            with np.errstate(all="ignore"):
                total = log_density(self._kind, first, second, y).sum()
                total += (counts * log_survival(self._kind, first, second, waited)).sum()
            return float(total) if np.isfinite(total) else -math.inf

        start = np.empty(2)
        kernels.fit_at_offset(np.concatenate([y, waited]), 0.0, self._kind, self._bound, start)
        theta = np.array([start[0] if self._is_log_normal else math.log(start[0]), math.log(start[1])])
        low, high = self._box(theta)
        # The step from the closed fit to the optimum hardly changes from one offset to the next.
        found, value = climb(height, theta + self._step, low, high)
        self._step = found - theta
        return np.array(self._natural(found)), value

    def _natural(self, theta: Floats) -> tuple[float, float]:
        first = float(theta[0]) if self._is_log_normal else math.exp(theta[0])
        return first, math.exp(theta[1])

    def _box(self, start: Floats) -> tuple[Floats, Floats]:
        """Six units of log either way, inside the family's bound."""
        low, high = start - 6.0, start + 6.0
        if self._bound > 0.0 and self._is_log_normal:
            high[1] = math.log(self._bound)
        elif self._bound > 0.0:
            low[0] = math.log(self._bound)
        return low, high


def _fit_gamma(family: Family, sample: Sample) -> tuple[Floats, float]:
    out = np.empty(3)
    no_table = np.zeros(gamma_profile.TABLE_SIZE)
    total = gamma_profile.profile(
        sample.observed_s,
        sample.waits,
        family.shifted,
        gamma_profile.FREE,
        0.0,
        family.bound,
        no_table,
        out,
    )
    return out[: len(family.parameters)], float(total)


def _fit_ex_gaussian(sample: Sample) -> tuple[Floats, float]:
    waited, counts = sample.waits.T
    everything = np.concatenate([sample.observed_s, sample.censored_s])
    mean, sd = float(everything.mean()), float(everything.std())
    least = math.log(kernels.SMALLEST_WIDTH_S)
    most = math.log(10.0 * float(np.ptp(everything)) + 1.0)

    def height(theta: Floats) -> float:
        mu, sigma, tau = sd * float(theta[0]), math.exp(theta[1]), math.exp(theta[2])
        total = log_density(None, mu, sigma, sample.observed_s, tau).sum()
        return float(total + (counts * log_survival(None, mu, sigma, waited, tau)).sum())

    tops = []
    for fraction in (0.05, 0.5, 0.95):
        tau, sigma = sd * math.sqrt(fraction), sd * math.sqrt(1.0 - fraction)
        start = [(mean - tau) / sd, math.log(sigma), math.log(tau)]
        tops.append(climb(height, start, [-math.inf, least, least], [math.inf, most, most]))
    theta, total = max(tops, key=lambda top: top[1])
    return np.array([sd * theta[0], math.exp(theta[1]), math.exp(theta[2])]), total
