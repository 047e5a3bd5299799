"""Compiled functions of the gamma density: derivatives of log Gamma, the shape equation, survival."""

import math

from core.numerics.compiled import kernel


@kernel
def digamma(x: float) -> float:
    """Derivative of log Gamma at x > 0: recurrence up to 8, then the asymptotic series (error < 1e-13)."""
    shift = 0.0
    while x < 8.0:
        shift -= 1.0 / x
        x += 1.0
    y = 1.0 / (x * x)
    tail = 1 / 240.0 - y * (1 / 132.0 - y * (691 / 32760.0 - y / 12.0))
    series = y * (1 / 12.0 - y * (1 / 120.0 - y * (1 / 252.0 - y * tail)))
    return shift + math.log(x) - 0.5 / x - series


@kernel
def trigamma(x: float) -> float:
    """Derivative of digamma at x > 0, the same way."""
    shift = 0.0
    while x < 8.0:
        shift += 1.0 / (x * x)
        x += 1.0
    y = 1.0 / (x * x)
    tail = 1 / 42.0 - y * (1 / 30.0 - y * (5 / 66.0 - y * (691 / 2730.0 - y * 7 / 6.0)))
    series = y * (1 / 6.0 - y * (1 / 30.0 - y * tail)) / x
    return shift + 1.0 / x + 0.5 * y + series


@kernel
def log_minus_digamma(k: float) -> float:
    """Return log k - digamma(k) for k > 0: decreasing, without the cancellation at large k."""
    if k < 50.0:
        return math.log(k) - digamma(k)
    y = 1.0 / (k * k)
    return 0.5 / k + y * (1 / 12.0 - y * (1 / 120.0 - y / 252.0))


@kernel
def gamma_shape(s: float) -> float:
    """Solve log k - digamma(k) = s for k, s > 0 (maximum-likelihood equation of the gamma shape).

    Newton steps on 1/k from a rational start; the left side is decreasing, so the root is unique.
    """
    k = (3.0 - s + math.sqrt((s - 3.0) ** 2 + 24.0 * s)) / (12.0 * s)
    for _ in range(30):
        slope = 1.0 / k - trigamma(k) if k < 1e4 else -0.5 / (k * k) - 1.0 / (6.0 * k * k * k)
        inverse = 1.0 / k - (log_minus_digamma(k) - s) / (slope * -(k * k))
        new = 1.0 / inverse if inverse > 0.0 else 2.0 * k
        moved = abs(new - k)
        k = new
        if moved <= 1e-13 * k:
            break
    return k


@kernel
def log_gamma_survival(k: float, z: float) -> float:
    """Log of the regularised upper incomplete gamma function, k > 0, z >= 0: series below, fraction above."""
    if z <= 0.0:
        return 0.0
    front = k * math.log(z) - z - math.lgamma(k)
    if z < k + 1.0:
        term = 1.0 / k
        total = term
        for j in range(1, 100_000):
            term *= z / (k + j)
            total += term
            if term < 1e-16 * total:
                break
        return math.log1p(-min(math.exp(front) * total, 1.0 - 1e-16))
    b = z + 1.0 - k
    c = 1e300
    d = 1.0 / b
    h = d
    for j in range(1, 100_000):
        a = -j * (j - k)
        b += 2.0
        d = 1.0 / (a * d + b)
        c = b + a / c
        h *= c * d
        if abs(c * d - 1.0) < 1e-15:
            break
    return front + math.log(h)
