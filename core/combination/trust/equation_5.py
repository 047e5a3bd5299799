"""The rule "equation-5": a weight that moves from episode to episode."""

from typing import ClassVar, Literal

import msgspec

from core.combination.agreement import Agreement, degree_of_match
from core.combination.ranking import EpisodeReport
from core.combination.trust.contract import Evidence, Needs, Trust, weight_bytes
from core.combination.trust.measures import next_human_weight


class Equation5(msgspec.Struct, frozen=True, forbid_unknown_fields=True, tag="equation-5"):
    """w_h moves from episode to episode, weighted by performance (Eq. 5).

    Where one of the two performances is negative (a sum of costs), both episodes count alike, with
    `cumulative` as well.
    """

    needs: ClassVar[Needs] = Needs()

    match: Literal["rate", "signed"] = "rate"
    """m^k of the episode's policy, as in `Equation4`."""
    cumulative: bool = False
    """Weigh the past by the performance of all compared episodes so far; as printed, by the last one's."""

    def begin(self, *, root_seed: int) -> Trust:
        """Return trust of 0."""
        return _Equation5(self)


class _Equation5(Trust):
    def __init__(self, rule: Equation5) -> None:
        self._rule = rule
        self._performance_before = 0.0
        self._compared = False

    def match(self, agreement: Agreement) -> float:
        """Return m_i by the kind that the settings name."""
        return degree_of_match(agreement, self._rule.match)

    def revise(self, report: EpisodeReport, evidence: Evidence) -> None:
        """Move toward the match of the episode's policy."""
        cumulative = self._rule.cumulative
        if report.agreement is not None:
            m_now = self.match(report.agreement)
            if self._compared or not cumulative:
                self.w_h = next_human_weight(self._performance_before, self.w_h, report.performance, m_now)
            else:
                self.w_h = m_now
            self._compared = True
        if not cumulative:
            self._performance_before = report.performance
        elif report.agreement is not None:
            self._performance_before += report.performance

    def state_bytes(self) -> bytes:
        """Return w_h, the performance behind it, and whether anything has been compared."""
        return weight_bytes(self.w_h, self._performance_before, self._compared)
