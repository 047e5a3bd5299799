"""Few trials: let the participants inform each other (empirical Bayes).

Log mean and log shape (and, for the shifted gamma, the log of the offset's odds below the group's fastest
response) are taken as normal over people. The group's means and covariance are estimated from all
participants together by expectation-maximisation with a normal approximation of each person's likelihood at
its top (Laplace); a participant's pooled estimate is then the top of likelihood times that normal: nobody is
pulled far whose own data say much.
"""

import math
from collections.abc import Mapping

import msgspec
import numpy as np
from scipy import special

from core.feedback.credit import GammaDelay
from core.numerics.arrays import Floats
from studies.reaction_time.ascent import climb
from studies.reaction_time.censored import log_survival
from studies.reaction_time.kernels import GAMMA
from studies.reaction_time.sample import FitError, Sample

FEWEST_PEOPLE = 5
SMALLEST_SPREAD = 1e-3
"""Least sd of a log parameter over people: a thousandth is no difference."""
_HALF_STEP = 1e-3


class Group(msgspec.Struct, frozen=True, kw_only=True):
    """How the participants' delays are spread."""

    shifted: bool
    offset_limit_s: float
    """Upper end of offsets: the fastest response of all participants; 0 for the two-parameter gamma."""
    mean: tuple[float, ...]
    """Means over people of log(mean - offset), log shape and, if shifted, log odds of offset /
    offset_limit_s."""
    covariance: tuple[tuple[float, ...], ...]
    n_people: int
    n_iterations: int


class PooledDelay(msgspec.Struct, frozen=True, kw_only=True):
    """One participant's delay, own data and group together."""

    shape: float
    scale_s: float
    offset_s: float
    own_share: float
    """How much of the log mean comes from the participant's own data: 1 - posterior variance / group
    variance."""

    def gamma_delay(self) -> GammaDelay:
        """Return the density that credit assignment takes."""
        return GammaDelay(shape=self.shape, scale_s=self.scale_s, offset_s=self.offset_s)


def pool(
    samples: Mapping[str, Sample], *, shifted: bool = False, max_iterations: int = 30, tolerance: float = 1e-3
) -> tuple[Group, dict[str, PooledDelay]]:
    """Estimate the group and every participant's pooled delay.

    Args:
        samples: participant to reaction times, at least five people.
        shifted: pool the offset too.
        max_iterations: of expectation-maximisation.
        tolerance: largest change of a group mean that counts as standing still.

    Raises:
        FitError: with too few people.
    """
    if len(samples) < FEWEST_PEOPLE:
        raise FitError(
            f"pooling needs at least {FEWEST_PEOPLE} participants, got {len(samples)}: fit each alone"
        )
    people = list(samples.values())
    limit = min(float(sample.observed_s[0]) for sample in people) if shifted else 0.0
    starts = [_start(sample, limit) for sample in people]
    mean, covariance = np.mean(starts, axis=0), np.diag(np.full(len(starts[0]), 0.25))
    changes: list[float] = []
    while len(changes) < max_iterations and (not changes or changes[-1] >= tolerance):
        posteriors = [_posterior(*pair, mean, covariance, limit) for pair in zip(people, starts, strict=True)]
        starts = [top for top, _ in posteriors]
        before, mean = mean, np.mean(starts, axis=0)
        spread = np.array(starts) - mean
        covariance = spread.T @ spread / len(people) + np.mean([c for _, c in posteriors], axis=0)
        covariance += np.diag(np.maximum(SMALLEST_SPREAD**2 - np.diag(covariance), 0.0))
        changes.append(float(np.abs(mean - before).max()))
    group = Group(
        shifted=shifted,
        offset_limit_s=limit,
        mean=tuple(mean.tolist()),
        covariance=tuple(tuple(row) for row in covariance.tolist()),
        n_people=len(people),
        n_iterations=len(changes),
    )
    return group, {name: pooled(sample, group) for name, sample in samples.items()}


def pooled(sample: Sample, group: Group) -> PooledDelay:
    """Return one participant's delay given the group; the participant need not have been among it."""
    mean, covariance = np.array(group.mean), np.array(group.covariance)
    top, own = _posterior(sample, mean.copy(), mean, covariance, group.offset_limit_s)
    shape, scale_s, offset_s = _natural(top, group.offset_limit_s)
    return PooledDelay(
        shape=shape,
        scale_s=scale_s,
        offset_s=offset_s,
        own_share=float(np.clip(1.0 - own[0, 0] / covariance[0, 0], 0.0, 1.0)),
    )


def typical(group: Group) -> tuple[float, float, float]:
    """Return shape, scale and offset (seconds) of the participant in the middle of the group."""
    return _natural(np.array(group.mean), group.offset_limit_s)


def _natural(theta: Floats, limit: float) -> tuple[float, float, float]:
    """Return (shape, scale, offset) of (log(mean - offset), log shape[, log odds of the offset])."""
    shape = math.exp(theta[1])
    offset = limit * float(special.expit(theta[2])) if limit > 0.0 else 0.0
    return shape, math.exp(theta[0]) / shape, offset


def _start(sample: Sample, limit: float) -> Floats:
    """Moments above half the limit."""
    offset = 0.5 * limit
    mean = float(sample.observed_s.mean()) - offset
    shape = min((mean / float(sample.observed_s.std())) ** 2, 1e4)
    start = [math.log(mean), math.log(shape)]
    return np.array([*start, 0.0] if limit > 0.0 else start)


def _log_likelihood(theta: Floats, sample: Sample, limit: float) -> float:
    shape, scale, offset = _natural(theta, limit)
    y = sample.observed_s - offset
    if not y[0] > 0.0:
        return -math.inf
    total = (
        (shape - 1.0) * np.log(y).sum()
        - y.sum() / scale
        - y.size * (shape * math.log(scale) + math.lgamma(shape))
    )
    if sample.censored_s.size:
        waited = np.maximum(sample.censored_s - offset, 1e-12)
        total += log_survival(GAMMA, shape, scale, waited).sum()
    return float(total)


def _posterior(
    sample: Sample, start: Floats, mean: Floats, covariance: Floats, limit: float
) -> tuple[Floats, Floats]:
    """Return the top of likelihood times group density, and the covariance of its normal approximation."""
    precision = np.linalg.inv(covariance)

    def height(theta: Floats) -> float:
        away = theta - mean
        return _log_likelihood(theta, sample, limit) - 0.5 * float(away @ precision @ away)

    low, high = np.minimum(mean - 8.0, start), np.maximum(mean + 8.0, start)
    top, value = climb(height, start, low, high)
    return top, _covariance(height, top, value, covariance)


def _covariance(height: object, top: Floats, value: float, fallback: Floats) -> Floats:
    """Inverse of the negative second derivatives at the top; the group's where they show none."""
    assert callable(height)
    n = top.size
    curvature = np.empty((n, n))
    steps = _HALF_STEP * np.eye(n)
    for i in range(n):
        for j in range(n):
            corners = [height(top + a * steps[i] + b * steps[j]) * a * b for a in (1, -1) for b in (1, -1)]
            curvature[i, j] = -sum(corners) / (4.0 * _HALF_STEP**2)
    if not np.isfinite(curvature).all() or np.linalg.eigvalsh(curvature)[0] <= 0.0:
        return fallback
    return np.asarray(np.linalg.inv(curvature))
