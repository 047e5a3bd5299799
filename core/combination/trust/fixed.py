"""The rule "fixed": trust that no evidence changes."""

import math
from typing import Annotated, ClassVar

import msgspec

from core.combination.ranking import EpisodeReport
from core.combination.trust.contract import Evidence, Needs, Trust
from core.configuration.fields import number


class FixedWeight(msgspec.Struct, frozen=True, forbid_unknown_fields=True, tag="fixed"):
    """Trust that no evidence changes: takes bootstrap learning out, for comparisons."""

    needs: ClassVar[Needs] = Needs()

    w_h: Annotated[float, number(ge=-1e9, le=1e9, usual=(-1000, 1000))] = 1.0
    """As much say as the environment, both being standardised. (Our choice.)"""

    def __post_init__(self) -> None:
        if not math.isfinite(self.w_h):
            raise ValueError(f"w_h is finite, got {self.w_h}")

    def begin(self, *, root_seed: int) -> Trust:
        """Return trust of `w_h`."""
        return _Fixed(self)


class _Fixed(Trust):
    def __init__(self, rule: FixedWeight) -> None:
        self.w_h = rule.w_h

    def revise(self, report: EpisodeReport, evidence: Evidence) -> None:
        """Do nothing."""
