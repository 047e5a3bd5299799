"""What credit, samples and the human model mean: slow, obvious."""

import math
from collections.abc import Callable, Sequence

import numpy as np
from numpy.typing import NDArray


def gamma_density(delay_s: float, shape: float, scale_s: float) -> float:
    if delay_s <= 0:
        return 0.0
    return delay_s ** (shape - 1) * math.exp(-delay_s / scale_s) / (math.gamma(shape) * scale_s**shape)


def uniform_density(delay_s: float, low_s: float, high_s: float) -> float:
    return 1 / (high_s - low_s) if low_s <= delay_s <= high_s else 0.0


def integral(density: Callable[[float], float], low: float, high: float, n: int = 4000) -> float:
    """Midpoint rule."""
    if high <= low:
        return 0.0
    width = (high - low) / n
    return sum(density(low + (i + 0.5) * width) for i in range(n)) * width


def credit_by_integration(
    press_s: float, intervals: Sequence[tuple[float, float]], density: Callable[[float], float]
) -> list[float]:
    """The share of each interval on screen: time runs backwards from the press."""
    return [integral(density, max(press_s - end, 0.0), max(press_s - begin, 0.0)) for begin, end in intervals]


def ridge(
    features: NDArray[np.float64],
    labels: NDArray[np.float64],
    weights: NDArray[np.float64],
    l2: float,
    intercept: str,
) -> tuple[NDArray[np.float64], float]:
    """Weighted ridge regression on inputs scaled over all samples, by least squares on extra rows.

    Returns weights and intercept in the features' own units. Constant features get weight 0 where inputs are
    centred.
    """
    total, n = weights.sum(), features.shape[1]
    if intercept == "penalised":
        features = np.column_stack([features, np.ones(len(features))])
    centred = intercept == "free"
    mean = weights @ features / total if centred else np.zeros(features.shape[1])
    label_mean = weights @ labels / total if centred else 0.0
    scale = np.sqrt(weights @ (features - mean) ** 2 / total)
    used = scale > 1e-9 * (1 + np.abs(mean))
    root = np.sqrt(weights)[:, None]
    rows = np.vstack(
        [root * (features[:, used] - mean[used]) / scale[used], math.sqrt(l2) * np.eye(used.sum())]
    )
    targets = np.concatenate([root[:, 0] * (labels - label_mean), np.zeros(used.sum())])
    v = np.zeros(features.shape[1])
    v[used] = np.linalg.lstsq(rows, targets, rcond=None)[0] / scale[used]
    if intercept == "penalised":
        return v[:n], float(v[n])
    return v, float(label_mean - v @ mean)


def sgd(
    features: Sequence[Sequence[float]],
    labels: Sequence[float],
    weights: Sequence[float],
    step_size: float,
) -> tuple[list[float], float]:
    """Knox's incremental gradient descent from zero weights, one pass in order, with a bias input of 1."""
    v = [0.0] * len(features[0])
    bias = 0.0
    for row, label, weight in zip(features, labels, weights, strict=True):
        error = label - (sum(a * b for a, b in zip(v, row, strict=True)) + bias)
        v = [a + step_size * weight * error * b for a, b in zip(v, row, strict=True)]
        bias += step_size * weight * error
    return v, bias
