"""Climb to the top of a smooth function of two or three unknowns inside a box.

Damped Newton steps with numerical derivatives. scipy's L-BFGS-B finds the same tops but needs about ten
milliseconds per step where its linear algebra's threads compete for a core: hundreds of times the arithmetic.
"""

from collections.abc import Callable, Sequence

import numpy as np

from core.numerics.arrays import Floats

_STEP = 1e-4
_ENOUGH = 1e-9


def climb(
    function: Callable[[Floats], float],
    start: Sequence[float] | Floats,
    low: Sequence[float] | Floats,
    high: Sequence[float] | Floats,
    *,
    max_steps: int = 200,
) -> tuple[Floats, float]:
    """Return (where, value) of a local maximum of `function` with low <= x <= high.

    Args:
        function: smooth where finite; -inf is allowed away from the start. Unknowns of order one.
        start: inside the box.
        low: lower ends, -inf for none.
        high: upper ends, inf for none.
        max_steps: Newton steps at most; each costs about ten calls of `function`.
    """
    low, high = np.asarray(low, np.float64), np.asarray(high, np.float64)
    x = np.clip(np.asarray(start, np.float64), low, high)
    value = function(x)
    damping = 1e-3
    for _ in range(max_steps):
        gradient, curvature = _derivatives(function, x, value)
        free = [i for i in range(x.size) if not _pushes_out(x[i], gradient[i], low[i], high[i])]
        if not free:
            break
        gained = 0.0
        while damping < 1e12:
            step = _solve(
                [[-curvature[i][j] + damping * (i == j) for j in free] for i in free],
                [gradient[i] for i in free],
            )
            if step is not None:
                moved = x.copy()
                moved[free] = np.clip(x[free] + np.clip(step, -2.0, 2.0), low[free], high[free])
                there = function(moved)
                if there > value:
                    gained, x, value = there - value, moved, there
                    damping = max(0.1 * damping, 1e-9)
                    break
            damping *= 10.0
        if gained < _ENOUGH:
            break
    return x, value


def _pushes_out(at: float, slope: float, low: float, high: float) -> bool:
    return (at <= low and slope <= 0.0) or (at >= high and slope >= 0.0)


def _derivatives(
    function: Callable[[Floats], float], x: Floats, value: float
) -> tuple[list[float], list[list[float]]]:
    """Return gradient and matrix of second derivatives by central differences."""
    n = x.size
    up, down = [0.0] * n, [0.0] * n
    for i in range(n):
        up[i], down[i] = function(_moved(x, i)), function(_moved(x, i, sign=-1.0))
    gradient = [(up[i] - down[i]) / (2.0 * _STEP) for i in range(n)]
    curvature = [[0.0] * n for _ in range(n)]
    for i in range(n):
        curvature[i][i] = (up[i] - 2.0 * value + down[i]) / _STEP**2
        for j in range(i):
            both = function(_moved(_moved(x, i), j))
            curvature[i][j] = curvature[j][i] = (both - up[i] - up[j] + value) / _STEP**2
    return gradient, curvature


def _moved(x: Floats, i: int, sign: float = 1.0) -> Floats:
    moved = x.copy()
    moved[i] += sign * _STEP
    return moved


def _solve(matrix: list[list[float]], right: list[float]) -> list[float] | None:
    """Solve a small symmetric system; None unless the matrix is positive definite."""
    n = len(right)
    rows = [[*row, value] for row, value in zip(matrix, right, strict=True)]
    for i in range(n):
        if not rows[i][i] > 0.0:
            return None
        for k in range(i + 1, n):
            factor = rows[k][i] / rows[i][i]
            rows[k] = [a - factor * b for a, b in zip(rows[k], rows[i], strict=True)]
    solution = [0.0] * n
    for i in reversed(range(n)):
        solution[i] = (rows[i][n] - sum(rows[i][j] * solution[j] for j in range(i + 1, n))) / rows[i][i]
    return solution
