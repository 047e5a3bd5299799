"""What credit assignment gives out: the samples for a model, and the account of all mass."""

import dataclasses
from dataclasses import dataclass

from core.domain import Features
from core.feedback.config import CreditConfig
from core.numerics.arrays import in_order

__all__ = ["CreditConfig", "FeedbackSample", "MassAccount", "PressCredit"]


@dataclass(frozen=True, slots=True, eq=False)
class FeedbackSample:
    """One thing a participant said about one step."""

    features: Features
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
    """Fraction of steps whose sample had been given out already: the press was reported far too late."""
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
            credited=self.credited + in_order(given.shares),
            before_first=self.before_first + given.before_first,
            in_gaps=self.in_gaps + given.in_gaps,
            too_late=self.too_late + given.too_late,
        )
