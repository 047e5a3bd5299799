"""The rule "rank-correlation": whether policies that agree with the participant do better."""

from typing import Annotated, ClassVar

import msgspec

from core.combination.ranking import EpisodeReport
from core.combination.trust.contract import Evidence, Needs, RecentEpisodes, Trust, check_gain, check_memory
from core.combination.trust.measures import rank_human_weight
from core.configuration.fields import number


class RankCorrelation(msgspec.Struct, frozen=True, forbid_unknown_fields=True, tag="rank-correlation"):
    """Trust a participant if policies that agree with them do better (ours;
    `docs/decisions/signed-match.md`).

    r = Spearman's correlation between performance and agreement over recent episodes, less its standard error
    1 / sqrt(n - 1); w_h = gain r.
    """

    needs: ClassVar[Needs] = Needs()

    episodes: Annotated[int, number("compared episodes", ge=3, le=1_000_000)] = 200
    """How many recent compared episodes count."""
    gain: Annotated[float, number(gt=0, le=1e9, usual=(0.001, 1000))] = 1.5
    """Factor that brings a good participant near the environment's weight."""
    standard_errors: Annotated[float, number("standard errors", ge=0, le=1e9, usual=(0, 100))] = 1.0
    """What is not this many standard errors from 0 is taken for 0."""
    signed: bool = False
    """A negative correlation gives a negative weight; otherwise 0."""
    minimum_episodes: Annotated[int, number("compared episodes", ge=3, le=1_000_000)] = 10
    """With fewer episodes w_h = 0."""

    def __post_init__(self) -> None:
        check_memory(self.minimum_episodes, self.episodes, least=3)
        check_gain(self.gain, self.standard_errors)

    def begin(self, *, root_seed: int) -> Trust:
        """Return trust of 0."""
        return _RankCorrelation(self)


class _RankCorrelation(Trust):
    def __init__(self, rule: RankCorrelation) -> None:
        self._rule = rule
        self._recent = RecentEpisodes(rule.episodes)

    def revise(self, report: EpisodeReport, evidence: Evidence) -> None:
        """Correlate recent performances with recent matches."""
        if report.agreement is None:
            return
        rule, recent = self._rule, self._recent
        recent.add(report.performance, self.match(report.agreement))
        if len(recent) >= rule.minimum_episodes:
            self.w_h = rank_human_weight(
                recent.performances,
                recent.numbers,
                gain=rule.gain,
                standard_errors=rule.standard_errors,
                signed=rule.signed,
            )

    def state_bytes(self) -> bytes:
        """Return w_h and the recent episodes."""
        return super().state_bytes() + self._recent.state_bytes()
