"""The rule "signed": Eq. 4 over recent episodes, by the signed match less its standard errors."""

from typing import Annotated

import msgspec

from core.combination.agreement import Agreement
from core.combination.ranking import EpisodeReport
from core.combination.trust.contract import Evidence, Needs, RecentEpisodes, Trust, check_gain, check_memory
from core.combination.trust.measures import signed_human_weight
from core.configuration.fields import number


class Signed(msgspec.Struct, frozen=True, forbid_unknown_fields=True, tag="signed"):
    """Eq. 4 over recent episodes with the signed match, less its standard errors (ours; `docs/decisions`).

    w = sum pm_i a_i / sum pm_i, se = sd(a) sqrt(sum pm_i^2) / sum pm_i, w_h = gain sign(w) max(0, |w| - c se
    - margin). Where a pm_i is negative, each counts by how far it lies above the lowest (`as_weights`).
    """

    episodes: Annotated[int, number("compared episodes", ge=2, le=1_000_000)] = 200
    """How many recent compared episodes count."""
    gain: Annotated[float, number(gt=0, le=1e9, usual=(0.001, 1000))] = 2.0
    """Factor that brings a good participant near the environment's weight."""
    standard_errors: Annotated[float, number("standard errors", ge=0, le=1e9, usual=(0, 100))] = 2.0
    """c: what is not this many standard errors from 0 is taken for 0."""
    margin: Annotated[float, number(ge=0, lt=1)] = 0.0
    """Agreement that is taken for chance whatever its standard error, in [0, 1): a human model learned from
    noise is one random policy in all episodes, and agrees with good ones by a fixed number
    (`docs/decisions/margin-of-agreement.md`)."""
    minimum_episodes: Annotated[int, number("compared episodes", ge=2, le=1_000_000)] = 10
    """With fewer episodes w_h = 0: their standard deviation says nothing."""
    consistent_above: Annotated[float, number("standard errors", ge=0)] | None = None
    """w_h = 0 unless the presses so far follow the human model better than chance by so many standard errors
    (`core.learners.consistency`); None: not looked at."""

    def __post_init__(self) -> None:
        if self.consistent_above is not None and not self.consistent_above >= 0:
            raise ValueError(f"consistent_above is >= 0 standard errors or None, got {self.consistent_above}")
        if not 0 <= self.margin < 1:
            raise ValueError(f"margin is an agreement in [0, 1), got {self.margin}")
        check_memory(self.minimum_episodes, self.episodes, least=2)
        check_gain(self.gain, self.standard_errors)

    @property
    def needs(self) -> Needs:
        """Consistency where it is looked at."""
        return Needs(consistency=self.consistent_above is not None)

    def begin(self, *, root_seed: int) -> Trust:
        """Return trust of 0."""
        return _Signed(self)


class _Signed(Trust):
    def __init__(self, rule: Signed) -> None:
        self._rule = rule
        self._recent = RecentEpisodes(rule.episodes)

    def match(self, agreement: Agreement) -> float:
        """Return best minus worst."""
        return agreement.signed

    def revise(self, report: EpisodeReport, evidence: Evidence) -> None:
        """Take the weighted mean over recent episodes; 0 while there are few, or presses look random."""
        if report.agreement is None:
            return
        rule, recent = self._rule, self._recent
        recent.add(report.performance, self.match(report.agreement))
        random = rule.consistent_above is not None and report.consistency <= rule.consistent_above
        if random or len(recent) < rule.minimum_episodes:
            self.w_h = 0.0
        else:
            self.w_h = signed_human_weight(
                recent.performances,
                recent.numbers,
                gain=rule.gain,
                standard_errors=rule.standard_errors,
                margin=rule.margin,
            )

    def state_bytes(self) -> bytes:
        """Return w_h and the recent episodes."""
        return super().state_bytes() + self._recent.state_bytes()
