"""Compiled maximum-likelihood fits of two-parameter families above an offset, and the search over the offset.

For a fixed offset o each family here has a closed or one-dimensional optimum; the offset is then found by a
profile over 0 <= o < min(x): a grid, dense where min(x) - o is small, and golden section around every local
maximum of the grid. Twin: `tests/naive/reaction_time.py`.
"""

import math

import numpy as np
from numpy.typing import NDArray

from core.numerics.compiled import kernel
from studies.reaction_time import golden
from studies.reaction_time.gamma_functions import gamma_shape

GAMMA, LOG_NORMAL, WALD, WEIBULL = 0, 1, 2, 3

SMALLEST_GAP_S = 1e-9
"""The offset stays this far below the fastest response: one tick of the clock."""
SHIFTED_SHAPE_MIN = 1.0
"""Shape of shifted gamma and Weibull: below 1 the likelihood has no maximum as the offset nears min(x)."""
SHIFTED_SIGMA_MAX = 2.0
"""Log-sd of the shifted log-normal, for the same reason; responses stay far below it (about 0.2 to 0.8)."""

SMALLEST_WIDTH_S = 1e-4
"""Least sigma and tau of the ex-Gaussian: a tenth of a millisecond."""

_GRID = 40
_LOG_2PI = 1.8378770664093453


@kernel
def log_moments(x: NDArray[np.float64], offset: float) -> tuple[float, float]:
    """Return the mean m of x - offset, and s = log m - mean log(x - offset) >= 0, without cancellation."""
    mean = 0.0
    for value in x:
        mean += value - offset
    mean /= x.size
    s = 0.0
    for value in x:
        s -= math.log1p((value - offset - mean) / mean)
    return mean, s / x.size


@kernel
def _fit_gamma(x: NDArray[np.float64], offset: float, bound: float, out: NDArray[np.float64]) -> float:
    """Fill (shape, scale) with shape >= bound; return the log-likelihood."""
    mean, s = log_moments(x, offset)
    k = max(gamma_shape(s), bound)
    out[0] = k
    out[1] = mean / k
    log_mean = math.log(mean)
    return x.size * ((k - 1.0) * (log_mean - s) - k * (log_mean - math.log(k)) - k - math.lgamma(k))


@kernel
def _fit_log_normal(x: NDArray[np.float64], offset: float, bound: float, out: NDArray[np.float64]) -> float:
    """Fill (mu, sigma) with sigma <= bound where bound > 0; return the log-likelihood."""
    mu = 0.0
    for value in x:
        mu += math.log(value - offset)
    mu /= x.size
    variance = 0.0
    for value in x:
        variance += (math.log(value - offset) - mu) ** 2
    variance /= x.size
    sigma = math.sqrt(variance)
    if bound > 0.0:
        sigma = min(sigma, bound)
    out[0] = mu
    out[1] = sigma
    return -x.size * (mu + math.log(sigma) + 0.5 * _LOG_2PI + 0.5 * variance / (sigma * sigma))


@kernel
def _fit_wald(x: NDArray[np.float64], offset: float, bound: float, out: NDArray[np.float64]) -> float:
    """Fill (mean, lambda) of the inverse Gaussian; no bound is needed; return the log-likelihood."""
    mean = 0.0
    for value in x:
        mean += value - offset
    mean /= x.size
    excess = 0.0  # mean of 1/y - 1/mean, as a sum of terms >= 0
    logs = 0.0
    for value in x:
        y = value - offset
        excess += (y - mean) ** 2 / (y * mean * mean)
        logs += math.log(y)
    lam = x.size / excess
    out[0] = mean
    out[1] = lam
    return 0.5 * x.size * (math.log(lam) - _LOG_2PI - 1.0) - 1.5 * logs


@kernel
def _fit_weibull(x: NDArray[np.float64], offset: float, bound: float, out: NDArray[np.float64]) -> float:
    """Fill (shape, scale) with shape >= bound; return the log-likelihood.

    The shape c solves sum(y^c log y)/sum(y^c) - 1/c - mean(log y) = 0, whose left side increases in c.
    Values are divided by the largest, so y^c never overflows.
    """
    n = x.size
    top = 0.0
    for value in x:
        top = max(top, value - offset)
    mean_log = 0.0
    square_log = 0.0
    for value in x:
        log_y = math.log((value - offset) / top)
        mean_log += log_y
        square_log += log_y * log_y
    mean_log /= n
    spread = math.sqrt(max(square_log / n - mean_log * mean_log, 1e-300))
    c = 1.2825 / spread  # sd of log y is pi / (sqrt(6) c)
    low, high = 0.0, math.inf
    for _ in range(100):
        s0, s1, s2 = 0.0, 0.0, 0.0
        for value in x:
            log_y = math.log((value - offset) / top)
            power = math.exp(c * log_y)
            s0 += power
            s1 += power * log_y
            s2 += power * log_y * log_y
        value_at_c = s1 / s0 - 1.0 / c - mean_log
        if value_at_c > 0.0:
            high = c
        else:
            low = c
        new = c - value_at_c / (s2 / s0 - (s1 / s0) ** 2 + 1.0 / (c * c))
        if not low < new < high:
            new = 0.5 * (low + high) if high < math.inf else 2.0 * c
        moved = abs(new - c)
        c = new
        if moved <= 1e-12 * c:
            break
    c = max(c, bound)
    s0 = 0.0
    for value in x:
        s0 += math.exp(c * math.log((value - offset) / top))
    scale = top * (s0 / n) ** (1.0 / c)
    out[0] = c
    out[1] = scale
    return n * (math.log(c) - c * math.log(scale) + (c - 1.0) * (mean_log + math.log(top)) - 1.0)


@kernel
def fit_at_offset(
    x: NDArray[np.float64], offset: float, family: int, bound: float, out: NDArray[np.float64]
) -> float:
    """Fill out[0:2] with the best parameters above a fixed offset < min(x); return the log-likelihood."""
    if family == GAMMA:
        return _fit_gamma(x, offset, bound, out)
    if family == LOG_NORMAL:
        return _fit_log_normal(x, offset, bound, out)
    if family == WALD:
        return _fit_wald(x, offset, bound, out)
    return _fit_weibull(x, offset, bound, out)


@kernel
def gap_grid(low: float, gaps: NDArray[np.float64]) -> None:
    """Fill with increasing values of min(x) - offset, from the smallest gap to `low` (offset 0)."""
    n = gaps.size
    n_linear = n // 3
    n_log = n - n_linear
    ratio = math.log(low / (n_linear + 1) / SMALLEST_GAP_S) / (n_log - 1)
    for j in range(n_log):
        gaps[j] = SMALLEST_GAP_S * math.exp(ratio * j)
    for j in range(n_linear):
        gaps[n_log + j] = low * (j + 2) / (n_linear + 1)
    gaps[n - 1] = low


@kernel
def fit_shifted(x: NDArray[np.float64], family: int, bound: float, out: NDArray[np.float64]) -> float:
    """Fill out[0:3] with (first, second, offset) at the maximum over 0 <= offset < min(x); return it."""
    low = x.min()
    gaps = np.empty(_GRID)
    values = np.empty(_GRID)
    pair = np.empty(2)
    bracket = np.empty(golden.PLACES)
    gap_grid(low, gaps)
    best = -math.inf
    best_offset = 0.0
    for j in range(_GRID):
        values[j] = fit_at_offset(x, low - gaps[j], family, bound, pair)
        if values[j] > best:
            best = values[j]
            best_offset = low - gaps[j]
    for j in range(_GRID):
        left = values[j - 1] if j > 0 else -math.inf
        right = values[j + 1] if j < _GRID - 1 else -math.inf
        if values[j] < left or values[j] < right:
            continue
        a = math.log(gaps[max(j - 1, 0)])
        b = math.log(gaps[min(j + 1, _GRID - 1)])
        golden.begin(bracket, a, b)
        for place in (golden.C, golden.D):
            bracket[golden.AT + place] = fit_at_offset(x, low - math.exp(bracket[place]), family, bound, pair)
        for _ in range(golden.STEPS):
            new = golden.narrow(bracket)
            bracket[golden.AT + new] = fit_at_offset(x, low - math.exp(bracket[new]), family, bound, pair)
        place_of_top, value = golden.top(bracket)
        if value > best:
            best = value
            best_offset = low - math.exp(place_of_top)
    best = fit_at_offset(x, best_offset, family, bound, out)
    out[2] = best_offset
    return best


@kernel
def ex_gaussian(x: NDArray[np.float64], mu: float, sigma: float, tau: float) -> float:
    """Log-likelihood of the ex-Gaussian: a normal(mu, sigma) time plus an exponential one of mean tau.

    f(x) = exp(sigma^2 / (2 tau^2) - (x - mu) / tau) erfc(a) / (2 tau), a = (sigma / tau - (x - mu) / sigma) /
    sqrt 2.
    """
    total = 0.0
    for value in x:
        z = (value - mu) / sigma
        a = (sigma / tau - z) * math.sqrt(0.5)
        if a < 20.0:
            total += 0.5 * (sigma / tau) ** 2 - (value - mu) / tau + math.log(math.erfc(a))
        else:  # erfc underflows: exp(a^2) erfc(a) by its asymptotic series
            y = 1.0 / (2.0 * a * a)
            total += (
                math.log((1.0 - y * (1.0 - 3.0 * y * (1.0 - 5.0 * y))) / (a * math.sqrt(math.pi)))
                - 0.5 * z * z
            )
    return total - x.size * math.log(2.0 * tau)
