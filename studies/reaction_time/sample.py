"""One participant's reaction times as the fits take them: seconds, checked once."""

from dataclasses import dataclass, field

import numpy as np
from numpy.typing import ArrayLike, NDArray

MIN_RESPONSES = 5
"""Fewer responses than this are not fitted: three parameters need at least that many."""


LEAST_SPREAD = 2e-3
"""Least sd of the responses as a fraction of their mean. People have 0.1 to 0.5; shapes above its square
cannot be told."""


class FitError(ValueError):
    """These reaction times cannot be fitted; the message says why and what to do."""


def _empty() -> NDArray[np.float64]:
    return np.empty(0)


@dataclass(frozen=True, slots=True, eq=False)
class Sample:
    """Reaction times of one participant in one condition."""

    observed_s: NDArray[np.float64]
    """Times of the responses, seconds, shape (n,), n >= 5, > 0, sd at least 0.2 % of the mean; kept
    sorted."""
    censored_s: NDArray[np.float64] = field(default_factory=_empty)
    """For each trial without a response, how long it waited: the time lies above. Seconds, shape (m,), >
    0."""

    waits: NDArray[np.float64] = field(init=False)
    """Different values of `censored_s` and how many trials have each: shape (n_different, 2)."""

    def __post_init__(self) -> None:
        for name in ("observed_s", "censored_s"):
            values = np.sort(np.ascontiguousarray(getattr(self, name), dtype=np.float64))
            if values.ndim != 1:
                raise FitError(f"{name} must be one-dimensional, got shape {values.shape}")
            if not (np.isfinite(values).all() and (values > 0.0).all()):
                raise FitError(
                    f"{name} must be finite and > 0 s: exclude missing, zero and negative times first"
                )
            object.__setattr__(self, name, values)
        object.__setattr__(
            self, "waits", np.column_stack(np.unique(self.censored_s, return_counts=True)).astype(float)
        )
        if self.observed_s.size < MIN_RESPONSES:
            raise FitError(
                f"{self.observed_s.size} usable responses, need at least {MIN_RESPONSES}: "
                "run more trials or look at what the exclusion policy took out"
            )
        mean, sd = float(self.observed_s.mean()), float(self.observed_s.std())
        if sd < LEAST_SPREAD * mean:
            raise FitError(
                f"all {self.observed_s.size} times are {mean:.6g} s, sd {sd:.2g} s: nobody reacts so evenly, "
                "and a density needs some spread; is this the column of reaction times?"
            )

    @property
    def n(self) -> int:
        """Trials, with and without a response."""
        return self.observed_s.size + self.censored_s.size


def sample(observed_s: ArrayLike, censored_s: ArrayLike = ()) -> Sample:
    """Return a checked `Sample` from anything array-like, in seconds."""
    return Sample(np.asarray(observed_s, dtype=np.float64), np.asarray(censored_s, dtype=np.float64))
