"""Compiled profile likelihood of the gamma and shifted gamma, with or without time-outs.

The profile of a quantity g at a value v is the highest log-likelihood among all parameters with g = v. For
each offset the constraint leaves one unknown (or none), which has a closed equation or is found by golden
section; the offset is searched as in `kernels`. Fitting with time-outs is the same search without a
constraint.
"""

import math

import numpy as np
from numpy.typing import NDArray

from core.numerics.compiled import kernel
from studies.reaction_time import golden
from studies.reaction_time.gamma_functions import gamma_shape, log_gamma_survival
from studies.reaction_time.kernels import gap_grid, log_moments

FREE, SHAPE, SCALE, OFFSET, MEAN, SD, QUANTILE = 0, 1, 2, 3, 4, 5, 6

GRID = 40
LOG_SHAPE_LOW, LOG_SHAPE_HIGH, TABLE_SIZE = -4.0, 14.0, 601
"""Range of log shape searched, and of the table of log quantiles."""

GRID_STEPS = 40
"""Steps of the coarse grid that a golden-section search begins with."""
NEWTON_DIFFERENCE = 1e-4
"""In log shape and log scale: what derivatives are taken over."""


@kernel
def _value(
    n: int, mean: float, s: float, waits: NDArray[np.float64], offset: float, k: float, scale: float
) -> float:
    """Log-likelihood from the sufficient statistics of x - offset, plus log survival: waits[j] is (length,
    how many).
    """
    total = n * ((k - 1.0) * (math.log(mean) - s) - mean / scale - k * math.log(scale) - math.lgamma(k))
    for j in range(waits.shape[0]):
        total += waits[j, 1] * log_gamma_survival(k, (waits[j, 0] - offset) / scale)
    return total


@kernel
def _scale_for(which: int, value: float, offset: float, log_k: float, table: NDArray[np.float64]) -> float:
    """Scale at which the constrained quantity equals `value`, given shape and offset; <= 0 where none
    does.
    """
    if which == MEAN:
        return (value - offset) / math.exp(log_k)
    if which == SD:
        return value / math.exp(0.5 * log_k)
    # Quantile: offset + scale * exp(table(log k)); cubic interpolation between equally spaced knots.
    position = (log_k - LOG_SHAPE_LOW) / (LOG_SHAPE_HIGH - LOG_SHAPE_LOW) * (TABLE_SIZE - 1)
    j = min(max(int(position), 1), TABLE_SIZE - 3)
    u = position - j
    p0, p1, p2, p3 = table[j - 1], table[j], table[j + 1], table[j + 2]
    log_h = (
        -u * (u - 1.0) * (u - 2.0) / 6.0 * p0
        + (u + 1.0) * (u - 1.0) * (u - 2.0) / 2.0 * p1
        - (u + 1.0) * u * (u - 2.0) / 2.0 * p2
        + (u + 1.0) * u * (u - 1.0) / 6.0 * p3
    )
    return (value - offset) / math.exp(log_h)


@kernel
def _along(
    t: float,
    which: int,
    value: float,
    n: int,
    mean: float,
    s: float,
    waits: NDArray[np.float64],
    offset: float,
    table: NDArray[np.float64],
) -> float:
    """Log-likelihood on the constraint: t is log scale where the shape is fixed, log shape elsewhere."""
    if which == SHAPE:
        return _value(n, mean, s, waits, offset, value, math.exp(t))
    if which == SCALE:
        return _value(n, mean, s, waits, offset, math.exp(t), value)
    scale = _scale_for(which, value, offset, t, table)
    if scale <= 0.0:
        return -math.inf
    return _value(n, mean, s, waits, offset, math.exp(t), scale)


@kernel
def _golden_between(
    a: float,
    b: float,
    which: int,
    value: float,
    n: int,
    mean: float,
    s: float,
    waits: NDArray[np.float64],
    offset: float,
    table: NDArray[np.float64],
) -> tuple[float, float]:
    """Return (t, log-likelihood) at the top of `_along` between a and b, where there is one top only."""
    bracket = np.empty(golden.PLACES)
    golden.begin(bracket, a, b)
    for place in (golden.C, golden.D):
        bracket[golden.AT + place] = _along(bracket[place], which, value, n, mean, s, waits, offset, table)
    while bracket[golden.B] - bracket[golden.A] > 1e-5:
        new = golden.narrow(bracket)
        bracket[golden.AT + new] = _along(bracket[new], which, value, n, mean, s, waits, offset, table)
    return golden.top(bracket)


@kernel
def _golden_along(
    low: float,
    high: float,
    which: int,
    value: float,
    n: int,
    mean: float,
    s: float,
    waits: NDArray[np.float64],
    offset: float,
    table: NDArray[np.float64],
) -> tuple[float, float]:
    """Return (t, log-likelihood) at the top of `_along` between low and high, ends included.

    Along a constant sd there may be more tops than one, and plateaus of -inf; a narrow top may look low on a
    coarse grid (times that differ little). So every grid point that no neighbour exceeds is looked around.
    """
    step = (high - low) / GRID_STEPS
    before, here = -math.inf, _along(low, which, value, n, mean, s, waits, offset, table)
    best_t, best = low, here
    for place in range(GRID_STEPS + 1):
        after = -math.inf
        if place < GRID_STEPS:
            after = _along(low + (place + 1) * step, which, value, n, mean, s, waits, offset, table)
        elif here > best:
            best_t, best = high, here
        if here > -math.inf and here >= before and here >= after:
            a, b = low + max(place - 1, 0) * step, low + min(place + 1, GRID_STEPS) * step
            t, top = _golden_between(a, b, which, value, n, mean, s, waits, offset, table)
            if top > best:
                best_t, best = t, top
        before, here = here, after
    return best_t, best


@kernel
def _uphill(
    n: int,
    mean: float,
    s: float,
    waits: NDArray[np.float64],
    offset: float,
    p: float,
    q: float,
    here: float,
) -> tuple[float, float]:
    """Return the Newton step at (p, q) = (log shape, log scale), where the log-likelihood is `here`.

    Derivatives are differences over `NEWTON_DIFFERENCE`. Where the log-likelihood is not concave, the step
    goes half a unit along the gradient.
    """
    step = NEWTON_DIFFERENCE
    pp = _value(n, mean, s, waits, offset, math.exp(p + step), math.exp(q))
    pm = _value(n, mean, s, waits, offset, math.exp(p - step), math.exp(q))
    qp = _value(n, mean, s, waits, offset, math.exp(p), math.exp(q + step))
    qm = _value(n, mean, s, waits, offset, math.exp(p), math.exp(q - step))
    both = _value(n, mean, s, waits, offset, math.exp(p + step), math.exp(q + step))
    gp, gq = (pp - pm) / (2.0 * step), (qp - qm) / (2.0 * step)
    hpp = (pp - 2.0 * here + pm) / (step * step)
    hqq = (qp - 2.0 * here + qm) / (step * step)
    hpq = (both - pp - qp + here) / (step * step)
    determinant = hpp * hqq - hpq * hpq
    if hpp < 0.0 and determinant > 0.0:
        return (hpq * gq - hqq * gp) / determinant, (hpq * gp - hpp * gq) / determinant
    size = math.sqrt(gp * gp + gq * gq)
    return 0.5 * gp / size, 0.5 * gq / size


@kernel
def _free(
    n: int,
    mean: float,
    s: float,
    waits: NDArray[np.float64],
    offset: float,
    shape_min: float,
    table: NDArray[np.float64],
    out: NDArray[np.float64],
) -> float:
    """Best shape >= shape_min and scale above an offset, filled into out[0:2]; return the log-likelihood.

    Without waits in closed form; with waits by Newton steps in (log shape, log scale), halved until they
    climb.
    """
    k = max(gamma_shape(s), shape_min)
    if waits.size == 0:
        out[0] = k
        out[1] = mean / k
        return _value(n, mean, s, waits, offset, k, mean / k)
    p, q = math.log(k), math.log(mean / k)
    here = _value(n, mean, s, waits, offset, math.exp(p), math.exp(q))
    for _ in range(60):
        dp, dq = _uphill(n, mean, s, waits, offset, p, q, here)
        length = max(abs(dp), abs(dq))
        if length > 1.0:
            dp, dq = dp / length, dq / length
        there = _value(n, mean, s, waits, offset, math.exp(p + dp), math.exp(q + dq))
        while there < here and length > 1e-9:
            dp, dq, length = 0.5 * dp, 0.5 * dq, 0.5 * length
            there = _value(n, mean, s, waits, offset, math.exp(p + dp), math.exp(q + dq))
        if there < here:
            break
        p, q, gain, here = p + dp, q + dq, there - here, there
        if gain < 1e-10:
            break
    if p < math.log(max(shape_min, 1e-300)):
        q, here = _golden_along(q - 5.0, q + 8.0, SHAPE, shape_min, n, mean, s, waits, offset, table)
        p = math.log(shape_min)
    out[0] = math.exp(p)
    out[1] = math.exp(q)
    return here


@kernel
def _at_offset(
    x: NDArray[np.float64],
    waits: NDArray[np.float64],
    offset: float,
    which: int,
    value: float,
    shape_min: float,
    table: NDArray[np.float64],
    out: NDArray[np.float64],
) -> float:
    """Highest log-likelihood above one offset under the constraint; fill out = (shape, scale, offset)."""
    mean, s = log_moments(x, offset)
    n = x.size
    out[2] = offset
    if which in (FREE, OFFSET):
        return _free(n, mean, s, waits, offset, shape_min, table, out)
    if waits.size == 0 and which == SHAPE:
        out[0] = value
        out[1] = mean / value
        return _value(n, mean, s, waits, offset, value, mean / value)
    if waits.size == 0 and which == MEAN:
        ratio = mean / (value - offset) if value > offset else math.inf
        if ratio == math.inf:
            return -math.inf
        # log k - digamma(k) = s + (ratio - 1 - log ratio)
        k = max(gamma_shape(s + ratio - 1.0 - math.log(ratio)), shape_min)
        out[0] = k
        out[1] = (value - offset) / k
        return _value(n, mean, s, waits, offset, k, out[1])
    if which == SHAPE:
        middle = math.log(mean / value)
        t, best = _golden_along(middle - 5.0, middle + 8.0, which, value, n, mean, s, waits, offset, table)
        out[0] = value
        out[1] = math.exp(t)
        return best
    low = max(LOG_SHAPE_LOW, math.log(max(shape_min, 1e-300)))
    t, best = _golden_along(low, LOG_SHAPE_HIGH, which, value, n, mean, s, waits, offset, table)
    out[0] = math.exp(t)
    out[1] = value if which == SCALE else _scale_for(which, value, offset, t, table)
    return best


@kernel
def profile(
    x: NDArray[np.float64],
    waits: NDArray[np.float64],
    shifted: bool,
    which: int,
    value: float,
    shape_min: float,
    table: NDArray[np.float64],
    out: NDArray[np.float64],
) -> float:
    """Highest log-likelihood with the quantity `which` equal to `value`; fill out = (shape, scale, offset).

    `waits`, shape (m, 2): length and number of equal waits. Waits shorter than an offset tell nothing and
    must be left out by the caller only where shorter than min(x).
    """
    low = x.min()
    if which == OFFSET:
        return _at_offset(x, waits, value, which, value, shape_min, table, out)
    if not shifted:
        return _at_offset(x, waits, 0.0, which, value, shape_min, table, out)
    gaps = np.empty(GRID)
    gap_grid(low, gaps)
    best, best_j = -math.inf, GRID - 1
    for j in range(GRID):
        at_j = _at_offset(x, waits, low - gaps[j], which, value, shape_min, table, out)
        if at_j > best:
            best, best_j = at_j, j
    best_offset = low - gaps[best_j]
    a, b = math.log(gaps[max(best_j - 1, 0)]), math.log(gaps[min(best_j + 1, GRID - 1)])
    bracket = np.empty(golden.PLACES)
    golden.begin(bracket, a, b)
    for place in (golden.C, golden.D):
        offset = low - math.exp(bracket[place])
        bracket[golden.AT + place] = _at_offset(x, waits, offset, which, value, shape_min, table, out)
    for _ in range(golden.STEPS):
        new = golden.narrow(bracket)
        offset = low - math.exp(bracket[new])
        bracket[golden.AT + new] = _at_offset(x, waits, offset, which, value, shape_min, table, out)
    place_of_top, found = golden.top(bracket)
    if found > best:
        best_offset = low - math.exp(place_of_top)
    return _at_offset(x, waits, best_offset, which, value, shape_min, table, out)
