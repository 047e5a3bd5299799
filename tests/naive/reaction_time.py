"""What the fits of `studies.reaction_time` mean: scipy's densities, and a search so fine that it cannot miss.

Nothing here is shared with the code under test: parameters at a fixed offset come from the textbook equations
solved for a whole grid of offsets at once, the ex-Gaussian from a grid of (sigma, tau) with a polish.
"""

import numpy as np
from numpy.typing import NDArray
from scipy import optimize, special, stats

Array = NDArray[np.float64]


def offsets_below(low: float, n: int = 400) -> Array:
    """Return offsets from 0 to just below the fastest response, half of them crowding towards it."""
    return np.unique(
        np.concatenate([np.linspace(0.0, low - 1e-9, n // 2), low - np.geomspace(1e-9, low, n // 2)])
    )


def finest(profile, low: float) -> tuple[float, float]:
    """Return (offset, value) at the top of `profile` (array in, array out): a grid, then five grids inside
    it."""
    grid = offsets_below(low)
    for _ in range(6):
        values = profile(grid)
        j = int(values.argmax())
        best = float(grid[j]), float(values[j])
        grid = np.linspace(grid[max(j - 1, 0)], grid[min(j + 1, len(grid) - 1)], 41)
    return best


def gamma_shapes(s: Array) -> Array:
    """Solve log k - digamma(k) = s by bisection on log k, for many s at once."""
    low, high = np.full(s.shape, -5.0), np.full(s.shape, 20.0)
    for _ in range(55):
        middle = 0.5 * (low + high)
        above = middle - special.digamma(np.exp(middle)) > s
        low, high = np.where(above, middle, low), np.where(above, high, middle)
    return np.exp(low)


def gamma_profile(x: Array, offsets: Array, shape_min: float) -> Array:
    y = x[None, :] - offsets[:, None]
    mean, mean_log = y.mean(axis=1), np.log(y).mean(axis=1)
    k = np.maximum(gamma_shapes(np.log(mean) - mean_log), shape_min)
    return len(x) * ((k - 1) * mean_log - k - k * np.log(mean / k) - special.gammaln(k))


def log_normal_profile(x: Array, offsets: Array) -> Array:
    logs = np.log(x[None, :] - offsets[:, None])
    return np.array([stats.norm.logpdf(row, row.mean(), row.std()).sum() - row.sum() for row in logs])


def wald_profile(x: Array, offsets: Array) -> Array:
    y = x[None, :] - offsets[:, None]
    mean = y.mean(axis=1)
    lam = 1.0 / ((1.0 / y).mean(axis=1) - 1.0 / mean)
    return stats.invgauss.logpdf(y, (mean / lam)[:, None], scale=lam[:, None]).sum(axis=1)


def weibull_profile(x: Array, offsets: Array, shape_min: float) -> Array:
    """Bisection on the likelihood equation of the shape, for all offsets at once."""
    logs = np.log(x[None, :] - offsets[:, None])
    logs -= logs.max(axis=1, keepdims=True)
    low, high = np.full(len(offsets), 1e-3), np.full(len(offsets), 1e3)
    for _ in range(60):
        c = np.sqrt(low * high)
        power = np.exp(c[:, None] * logs)
        above = (power * logs).sum(axis=1) / power.sum(axis=1) - 1 / c - logs.mean(axis=1) > 0
        low, high = np.where(above, low, c), np.where(above, c, high)
    c = np.maximum(np.sqrt(low * high), shape_min)
    y = x[None, :] - offsets[:, None]
    scale = y.max(axis=1) * np.exp(c[:, None] * logs).mean(axis=1) ** (1 / c)
    return stats.weibull_min.logpdf(y, c[:, None], scale=scale[:, None]).sum(axis=1)


PROFILES = {
    "gamma": lambda x: lambda o: gamma_profile(x, o, 0.0),
    "shifted gamma": lambda x: lambda o: gamma_profile(x, o, 1.0),
    "log-normal": lambda x: lambda o: log_normal_profile(x, o),
    "shifted log-normal": lambda x: lambda o: log_normal_profile(x, o),
    "Wald": lambda x: lambda o: wald_profile(x, o),
    "shifted Wald": lambda x: lambda o: wald_profile(x, o),
    "Weibull": lambda x: lambda o: weibull_profile(x, o, 0.0),
    "shifted Weibull": lambda x: lambda o: weibull_profile(x, o, 1.0),
}


def best_log_likelihood(family: str, x: Array) -> float:
    """Return the highest log-likelihood of a family found by the fine search."""
    if family == "ex-Gaussian":
        return ex_gaussian_best(x)
    profile = PROFILES[family](x)
    if family.startswith("shifted"):
        return finest(profile, float(x.min()))[1]
    return float(profile(np.zeros(1))[0])


def ex_gaussian_best(x: Array) -> float:
    """Grid over the fraction of the variance in tau and the width, mean kept; the best three are polished."""

    def loss(p: Array) -> float:
        if p[1] < 1e-4 or p[2] < 1e-4:
            return np.inf
        return -float(stats.exponnorm.logpdf(x, p[2] / p[1], p[0], p[1]).sum())

    sd = x.std()
    starts = [
        (x.mean() - tau, sigma, tau)
        for sigma in sd * np.array([0.05, 0.2, 0.4, 0.6, 0.8, 1.0])
        for tau in sd * np.array([0.02, 0.2, 0.5, 0.8, 1.0])
    ]
    starts.sort(key=loss)
    options = {"maxiter": 4000, "xatol": 1e-8, "fatol": 1e-8}
    return -min(optimize.minimize(loss, s, method="Nelder-Mead", options=options).fun for s in starts[:3])


def censored_log_likelihood(distribution, observed: Array, waits: Array) -> float:
    """Log density of what was seen plus log survival of what was waited for."""
    return float(distribution.logpdf(observed).sum() + distribution.logsf(waits).sum())


def profile_interval(log_likelihood, grid: Array, cut: float) -> tuple[float, float]:
    """Return the ends of {v in grid: log_likelihood(v) >= max - cut / 2}."""
    values = np.array([log_likelihood(v) for v in grid])
    inside = grid[values >= values.max() - 0.5 * cut]
    return float(inside[0]), float(inside[-1])
