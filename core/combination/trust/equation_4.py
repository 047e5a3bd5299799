"""The rule "equation-4": the performance-weighted mean match of the top policies."""

from typing import Annotated, Literal

import msgspec

from core.combination.agreement import MatchKind, degree_of_match
from core.combination.ranking import EpisodeReport
from core.combination.trust.contract import Evidence, Needs, Trust
from core.combination.trust.measures import human_weight
from core.configuration.fields import number
from core.numerics.streams import stream

HIGHEST_CHANCE = 0.99
"""An estimate of chance agreement above this counts as this: a match is divided by 1 - chance."""


class Equation4(msgspec.Struct, frozen=True, forbid_unknown_fields=True, tag="equation-4"):
    """w_h is the performance-weighted mean match of the top policies (Eq. 4).

    Where a performance is negative (a sum of costs), each policy counts by how far its performance lies above
    the lowest one compared (`core.combination.trust.measures.as_weights`).
    """

    match: MatchKind = "rate"
    """m_i: the paper counts equal choices; a rate keeps w_h in [0, 1]."""
    measured: Literal["as-played", "window"] = "as-played"
    """m_i from the last episode in which policy i was played, or anew from recent decisions."""
    chance: Annotated[float, number(ge=0, lt=1)] | None = None
    """Agreement of unrelated policies, in [0, 1), where `match` is chance-corrected; None: estimated from
    recent decisions by random policies."""

    def __post_init__(self) -> None:
        if self.chance is not None and not 0 <= self.chance < 1:
            raise ValueError(f"chance is an agreement rate in [0, 1), got {self.chance}")

    @property
    def estimates_chance(self) -> bool:
        """Whether chance agreement is estimated from recent decisions."""
        return self.match == "chance-corrected" and self.chance is None

    @property
    def needs(self) -> Needs:
        """A window where matches or chance are measured anew."""
        return Needs(window=self.measured == "window" or self.estimates_chance)

    def begin(self, *, root_seed: int) -> Trust:
        """Return trust of 0."""
        return _Equation4(self, root_seed)


class _Equation4(Trust):
    def __init__(self, rule: Equation4, root_seed: int) -> None:
        self._rule = rule
        self._root_seed = root_seed

    def revise(self, report: EpisodeReport, evidence: Evidence) -> None:
        """Take the mean over the policies that have been compared."""
        known = [
            (policy.performance, m)
            for policy, m in zip(evidence.ranked, self.matches(evidence), strict=True)
            if m is not None
        ]
        self.w_h = human_weight([pm for pm, _ in known], [m for _, m in known])

    def matches(self, evidence: Evidence) -> list[float | None]:
        """Return m_i of each ranked policy; None for all while there is no human policy, or nothing to
        measure by.
        """
        rule, human = self._rule, evidence.human_weights
        unknown: list[float | None] = [None] * len(evidence.ranked)
        if human is None:
            return unknown
        chance = rule.chance or 0.0
        agreements = [policy.agreement for policy in evidence.ranked]
        if rule.needs.window:
            window = evidence.window
            if window is None or not len(window):
                return unknown
            if rule.estimates_chance:
                # The same random policies each time: looking at a match does not move it.
                chance = window.chance(human, rng=stream(self._root_seed, "chance"))
                chance = min(chance, HIGHEST_CHANCE)
            if rule.measured == "window":
                agreements = [window.compare(policy.theta, human) for policy in evidence.ranked]
        return [None if a is None else degree_of_match(a, rule.match, chance) for a in agreements]
