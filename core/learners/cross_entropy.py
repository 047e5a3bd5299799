"""The noisy cross-entropy method: a normal distribution over weight vectors that moves to its best samples.

Szita & Lorincz 2006, with the settings of Thiery & Scherrer 2009: in each iteration a population is drawn
from N(mean, variance) with independent weights; mean and variance become those of the elite, the samples with
the highest performance; a noise schedule is added to the variance, which keeps the search from stopping too
early.
"""

import math
import struct

import numpy as np
from numpy.typing import ArrayLike, NDArray

from core.learners.contract import Candidate
from core.learners.cross_entropy_config import (
    ConstantNoise,
    CrossEntropyConfig,
    DecreasingNoise,
    Noise,
    NoNoise,
)
from core.numerics.streams import stream

__all__ = [
    "ConstantNoise",
    "CrossEntropy",
    "CrossEntropyConfig",
    "CrossEntropyLearner",
    "DecreasingNoise",
    "NoNoise",
    "Noise",
]


class CrossEntropy:
    """The search distribution. What it draws follows from the root seed and the number of the iteration."""

    def __init__(self, config: CrossEntropyConfig, *, n_weights: int, root_seed: int) -> None:
        self.config = config
        self.root_seed = root_seed
        self.iteration = 0
        """Completed iterations."""
        self.mean = np.zeros(n_weights)
        """Shape (n_weights,)."""
        self.variance = np.full(n_weights, config.initial_variance)
        """Shape (n_weights,)."""

    def population(self) -> NDArray[np.float64]:
        """Return this iteration's samples, shape (population, n_weights): the same ones at every call."""
        rng = stream(self.root_seed, "cross-entropy", self.iteration)
        standard = rng.standard_normal((self.config.population, len(self.mean)))
        samples: NDArray[np.float64] = self.mean + np.sqrt(self.variance) * standard
        return samples

    def elite(self, performance: ArrayLike) -> NDArray[np.intp]:
        """Return the indices of the best samples, in the order drawn; of equal ones the first drawn are
        taken.

        Args:
            performance: of each sample, shape (population,).
        """
        values = np.asarray(performance, dtype=np.float64)
        if values.shape != (self.config.population,) or np.isnan(values).any():
            raise ValueError(
                f"need {self.config.population} performances without NaN, got shape {values.shape}: {values}"
            )
        # In the order drawn: who is best among the best then changes no sum, so games of the elite need not
        # be played to their end.
        return np.sort(np.argsort(-values, kind="stable")[: self.config.elite_size])

    def update(self, performance: ArrayLike) -> None:
        """Move to the elite and begin the next iteration.

        The variance is the elite's population variance (divided by n, as in Thiery & Scherrer's program) plus
        the noise of this iteration.
        """
        best = self.population()[self.elite(performance)]
        self.mean = best.mean(axis=0)
        self.variance = best.var(axis=0) + self.config.noise.variance(self.iteration)
        self.iteration += 1


class CrossEntropyLearner:
    """The method one candidate at a time: a `core.learners.contract.EnvironmentLearner`."""

    def __init__(self, config: CrossEntropyConfig, *, n_weights: int, root_seed: int) -> None:
        self.search = CrossEntropy(config, n_weights=n_weights, root_seed=root_seed)
        self._population = self.search.population()
        self._performance: list[float] = []

    def propose(self) -> Candidate:
        """Return the next sample; the same one again until its performance has been reported."""
        index = len(self._performance)
        policy_id = self.search.iteration * self.search.config.population + index
        weights = self._population[index].copy()
        weights.flags.writeable = False
        return Candidate(policy_id, weights)

    def report(self, policy_id: int, performance: float) -> None:
        """Take in the performance measure of the sample last proposed."""
        expected = self.propose().policy_id
        if policy_id != expected:
            raise ValueError(f"policy {expected} waits for its performance, got one for {policy_id}")
        if not math.isfinite(performance):
            raise ValueError(f"policy {policy_id}: performance is finite, got {performance}")
        self._performance.append(performance)
        if len(self._performance) == self.search.config.population:
            self.search.update(self._performance)
            self._population = self.search.population()
            self._performance = []

    def state_digest(self) -> bytes:
        """Return bytes that differ whenever anything differs that decides about later proposals."""
        return (
            struct.pack("<q", self.search.iteration)
            + self.search.mean.tobytes()
            + self.search.variance.tobytes()
            + np.array(self._performance, dtype=np.float64).tobytes()
        )
