"""Agreement of an environment policy with a human policy: the one record of it, and the degree of match
m_i.
"""

from dataclasses import dataclass
from typing import Literal

MatchKind = Literal["rate", "chance-corrected", "signed"]
"""Degree of match: fraction of equal choices; the same above chance; best minus worst (`docs/decisions`)."""


@dataclass(frozen=True, slots=True)
class Agreement:
    """Choices of an environment policy compared with those of a human policy (`core.combination.tally` counts
    them).
    """

    decisions: int
    """How many decisions were compared, >= 1."""
    agreed: int
    """At how many the environment policy chose the human policy's best action."""
    agreed_worst: int
    """At how many it chose the human policy's worst action."""

    def __post_init__(self) -> None:
        if not (self.decisions >= 1 and min(self.agreed, self.agreed_worst) >= 0):
            raise ValueError(f"agreement needs at least one decision and counts >= 0: {self}")
        if max(self.agreed, self.agreed_worst) > self.decisions:
            raise ValueError(f"more agreements than decisions: {self}")

    @property
    def rate(self) -> float:
        """Fraction of equal choices, in [0, 1]."""
        return self.agreed / self.decisions

    @property
    def signed(self) -> float:
        """Fraction of the participant's best minus fraction of the participant's worst actions, in [-1,
        1].
        """
        return (self.agreed - self.agreed_worst) / self.decisions


def degree_of_match(agreement: Agreement, kind: MatchKind, chance: float = 0.0) -> float:
    """Return m_i.

    Args:
        agreement: counts.
        kind: rate in [0, 1]; chance-corrected max(0, (rate - chance) / (1 - chance)); signed in [-1, 1].
        chance: agreement rate of unrelated policies, in [0, 1).
    """
    if kind == "signed":
        return agreement.signed
    if kind == "rate":
        return agreement.rate
    return max(0.0, (agreement.rate - chance) / (1.0 - chance))
