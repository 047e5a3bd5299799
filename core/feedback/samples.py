"""What credit assignment gives out: its settings, the samples for a model, and the account of all mass."""

import dataclasses
import math
from dataclasses import dataclass
from typing import Literal

import msgspec
import numpy as np
from numpy.typing import NDArray

from core.feedback.credit import Delay, PreviousStep


class CreditConfig(msgspec.Struct, frozen=True, kw_only=True, forbid_unknown_fields=True):
    """How presses become samples."""

    delay: Delay = PreviousStep()
    """Density of the delay, or a rule. Previous step: TAMER's rule for Tetris (`docs/decisions`)."""
    scheme: Literal["individual", "aggregate"] = "individual"
    """Individual: one sample per press and step, weighted by its share (K-CAP 2009). Aggregate: one sample per
    step, its label the sum of value * share over all presses (TAMER's later default)."""
    silence: Literal["no-update", "zero-label"] = "no-update"
    """What a step without any press says: nothing, or 0 (TAMER's code; with the aggregate scheme only)."""
    merge_within_s: float = 0.0
    """A press of the same value within this time of the press before belongs to the same burst, and a burst
    counts as its first press. 0: every press counts (as in the paper and in TAMER)."""

    def __post_init__(self) -> None:
        if self.silence == "zero-label" and self.scheme == "individual":
            raise ValueError("silence='zero-label' needs scheme='aggregate': only a whole step can be silent")
        if not 0 <= self.merge_within_s < math.inf:
            raise ValueError(f"merge_within_s is >= 0 seconds, got {self.merge_within_s}")


@dataclass(frozen=True, slots=True, eq=False)
class Sample:
    """One thing a person said about one step."""

    features: NDArray[np.float64]
    """psi(s, a) of the step, shape (G,)."""
    label: float
    weight: float
    """How much the sample counts, in (0, 1]."""
    step: int
    presses: tuple[int, ...]
    """The presses behind it; none for a silent step."""


@dataclass(frozen=True, slots=True)
class PressCredit:
    """Where the mass of one press went; shares, `before_first`, `in_gaps` and `too_late` sum to 1."""

    press: int
    steps: tuple[int, ...] = ()
    shares: tuple[float, ...] = ()
    """Share of each step in `steps`, > 0."""
    before_first: float = 0.0
    in_gaps: float = 0.0
    too_late: float = 0.0
    """Share of steps whose sample had been given out already: the press was reported far too late."""
    merged_into: int | None = None
    """The press that opened the burst; such a press has no mass of its own."""


@dataclass(frozen=True, slots=True)
class MassAccount:
    """Where the mass of all presses went: one per press that was not merged."""

    presses: int = 0
    merged: int = 0
    credited: float = 0.0
    before_first: float = 0.0
    in_gaps: float = 0.0
    too_late: float = 0.0

    def plus(self, given: PressCredit) -> "MassAccount":
        """Return the account after one more press."""
        if given.merged_into is not None:
            return dataclasses.replace(self, merged=self.merged + 1)
        return MassAccount(
            presses=self.presses + 1,
            merged=self.merged,
            credited=self.credited + sum(given.shares),
            before_first=self.before_first + given.before_first,
            in_gaps=self.in_gaps + given.in_gaps,
            too_late=self.too_late + given.too_late,
        )
