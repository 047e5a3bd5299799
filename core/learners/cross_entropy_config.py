"""Settings of the noisy cross-entropy method (`core.learners.cross_entropy`). No numerical library is
imported.
"""

import math
from typing import Annotated, ClassVar

import msgspec

from core.configuration.fields import number
from core.learners.kinds import LearnerKind


def _check_at_least(name: str, value: float, lowest: float) -> None:
    if not (math.isfinite(value) and value >= lowest):
        raise ValueError(f"{name} is finite and >= {lowest}, got {value}")


class NoNoise(msgspec.Struct, frozen=True, forbid_unknown_fields=True, tag="none"):
    """The plain cross-entropy method: the variance is that of the elite."""

    def variance(self, iteration: int) -> float:
        """Return 0."""
        return 0.0


class ConstantNoise(msgspec.Struct, frozen=True, forbid_unknown_fields=True, tag="constant"):
    """The same variance is added in every iteration."""

    level: Annotated[float, number(ge=0, le=1e12)] = 4.0
    """Added variance, >= 0 (Szita & Lorincz 2006)."""

    def __post_init__(self) -> None:
        _check_at_least("level", self.level, 0.0)

    def variance(self, iteration: int) -> float:
        """Return the level."""
        return self.level


class DecreasingNoise(msgspec.Struct, frozen=True, forbid_unknown_fields=True, tag="decreasing"):
    """max(start - t / per, 0) is added in iteration t."""

    start: Annotated[float, number(ge=0, le=1e12)] = 5.0
    """Added variance at t = 0, >= 0 (Szita & Lorincz 2006)."""
    per: Annotated[float, number("iterations", gt=0, le=1e12, usual=(1e-3, 1e9))] = 10.0
    """Iterations in which the added variance falls by 1, > 0 (Szita & Lorincz 2006)."""

    def __post_init__(self) -> None:
        _check_at_least("start", self.start, 0.0)
        if not (math.isfinite(self.per) and self.per > 0):
            raise ValueError(f"per is > 0 iterations, got {self.per}")

    def variance(self, iteration: int) -> float:
        """Return the variance added at the end of iteration t >= 0."""
        return max(self.start - iteration / self.per, 0.0)


Noise = NoNoise | ConstantNoise | DecreasingNoise
"""Any noise schedule; msgspec decodes it by its tag, the field "type"."""


class CrossEntropyConfig(
    msgspec.Struct, frozen=True, kw_only=True, forbid_unknown_fields=True, tag="cross-entropy"
):
    """Settings of the noisy cross-entropy method."""

    kind: ClassVar[LearnerKind] = "search"

    population: Annotated[int, number("policies", ge=1, le=100_000, usual=(2, 10_000))] = 100
    """Samples per iteration (Szita & Lorincz 2006; Thiery & Scherrer 2009)."""
    elite_fraction: Annotated[float, number(gt=0, le=1)] = 0.1
    """Fraction of the population that makes the next distribution, in (0, 1] (the same)."""
    initial_variance: Annotated[float, number(gt=0, le=1e12, usual=(1e-6, 1e9))] = 100.0
    """Variance of each weight at the start, > 0, around mean 0 (the same)."""
    noise: Noise = DecreasingNoise()
    """What is added to the variance after each iteration (the schedule with their best result)."""

    def __post_init__(self) -> None:
        if self.population < 1 or not 0.0 < self.elite_fraction <= 1.0:
            raise ValueError(
                f"need population >= 1 and elite_fraction in (0, 1]: {self.population}, {self.elite_fraction}"
            )
        if not (math.isfinite(self.initial_variance) and self.initial_variance > 0):
            raise ValueError(f"initial_variance is > 0, got {self.initial_variance}")

    @property
    def elite_size(self) -> int:
        """Number of elite samples, >= 1."""
        return max(1, round(self.population * self.elite_fraction))
