"""Kernels of linear models: sums in index order, so that every machine and plain Python give the same bits.

(BLAS orders its sums by the processor it finds, which would make a recording replay on one machine only.)
"""

import math

import numpy as np

from core.numerics.arrays import Floats
from core.numerics.compiled import kernel


@kernel
def action_values(rows: Floats, weights: Floats) -> Floats:
    """Return the value of each action: rows (n, F) times weights (F,), shape (n,)."""
    n, n_features = rows.shape
    out = np.empty(n)
    for action in range(n):
        total = 0.0
        for i in range(n_features):
            total += rows[action, i] * weights[i]
        out[action] = total
    return out


@kernel
def add_to_moments(
    x: Floats, label: float, weight: float, centred: bool, totals: Floats, means: Floats, scatter: Floats
) -> None:
    """Take one weighted sample into running moments (Welford's update; exact zeros for constant inputs).

    Args:
        x: inputs, shape (G,).
        label: target.
        weight: weight of the sample, > 0.
        centred: moments around the running mean; around 0 otherwise.
        totals: [sum of weights], shape (1,), changed in place.
        means: weighted means of the inputs and, last, of the label, shape (G + 1,), changed in place; stay 0
            unless centred.
        scatter: sums of weight * product of deviations, inputs and, last, label, lower triangle, shape
            (G + 1, G + 1), changed in place.
    """
    n = x.shape[0]
    before = totals[0]
    totals[0] = before + weight
    factor = weight * before / totals[0] if centred else weight
    deviations = np.empty(n + 1)
    for i in range(n):
        deviations[i] = x[i] - means[i]
    deviations[n] = label - means[n]
    for i in range(n + 1):
        scaled = factor * deviations[i]
        for j in range(i + 1):
            scatter[i, j] += scaled * deviations[j]
    if centred:
        for i in range(n + 1):
            means[i] += weight / totals[0] * deviations[i]


@kernel
def solve_ridge(total: float, scatter: Floats, l2: float, standardise: bool, out: Floats) -> None:
    """Fill `out` with the ridge weights in the inputs' own units, by Cholesky's decomposition.

    Args:
        total: sum of sample weights.
        scatter: as filled by `add_to_moments`, shape (G + 1, G + 1).
        l2: penalty on the weights of the (standardised) inputs, > 0.
        standardise: divide each input by its sd before penalising.
        out: shape (G,). Inputs that never varied get 0.
    """
    n = out.shape[0]
    scale: Floats = np.ones(n)
    for i in range(n):
        if scatter[i, i] <= 0.0:
            scale[i] = 0.0  # leaves the input out
        elif standardise:
            scale[i] = 1.0 / math.sqrt(scatter[i, i] / total)
    lower = np.zeros((n, n))
    for i in range(n):
        for j in range(i + 1):
            value = scatter[i, j] * scale[i] * scale[j]
            if i == j:
                value += l2
            for k in range(j):
                value -= lower[i, k] * lower[j, k]
            if i == j:
                # Exactly, every pivot is >= l2; rounding may take a little of a tiny l2 away.
                lower[i, i] = math.sqrt(max(value, 0.5 * l2))
            else:
                lower[i, j] = value / lower[j, j]
    for i in range(n):
        out[i] = scatter[n, i] * scale[i]
        for k in range(i):
            out[i] -= lower[i, k] * out[k]
        out[i] /= lower[i, i]
    for back in range(n):
        i = n - 1 - back
        for k in range(i + 1, n):
            out[i] -= lower[k, i] * out[k]
        out[i] /= lower[i, i]
    for i in range(n):
        out[i] *= scale[i]


@kernel
def gradient_step(
    x: Floats, label: float, weight: float, step_size: float, intercept: bool, weights: Floats
) -> None:
    """Move `weights` by one step of the weighted squared error's gradient.

    Args:
        x: inputs, shape (G,).
        label: target.
        weight: weight of the sample.
        step_size: > 0.
        intercept: learn the bias, too.
        weights: weights of the inputs and, last, the bias, shape (G + 1,), changed in place.
    """
    n = x.shape[0]
    prediction = 0.0
    for i in range(n):
        prediction += weights[i] * x[i]
    prediction += float(weights[n])
    move = step_size * weight * (label - prediction)
    for i in range(n):
        weights[i] += move * x[i]
    if intercept:
        weights[n] += move


@kernel
def standardised(x: Floats, total: float, means: Floats, scatter: Floats) -> Floats:
    """Return (x - mean) / sd by running moments, shape (G,); 0 for inputs that never varied."""
    out = np.zeros(x.shape[0])
    for i in range(x.shape[0]):
        if scatter[i, i] > 0.0:
            out[i] = (x[i] - means[i]) / math.sqrt(scatter[i, i] / total)
    return out
