"""The rule "recent": the mean match of the last episodes, whatever their performance."""

from typing import Annotated, ClassVar

import msgspec

from core.combination.ranking import EpisodeReport
from core.combination.trust.contract import Evidence, Needs, RecentEpisodes, Trust
from core.configuration.fields import number


class Recent(msgspec.Struct, frozen=True, forbid_unknown_fields=True, tag="recent"):
    """w_h is the plain mean match of the last compared episodes."""

    needs: ClassVar[Needs] = Needs()

    episodes: Annotated[int, number("compared episodes", ge=1, le=1_000_000)] = 20
    """How many recent compared episodes count. (Our choice.)"""

    def begin(self, *, root_seed: int) -> Trust:
        """Return trust of 0."""
        return _Recent(self)


class _Recent(Trust):
    def __init__(self, rule: Recent) -> None:
        self._episodes = RecentEpisodes(rule.episodes)

    def revise(self, report: EpisodeReport, evidence: Evidence) -> None:
        """Take the mean; an episode without a human policy changes nothing."""
        if report.agreement is not None:
            self._episodes.add(report.performance, self.match(report.agreement))
            self.w_h = sum(self._episodes.numbers) / len(self._episodes)

    def state_bytes(self) -> bytes:
        """Return w_h and the episodes it is the mean of."""
        return super().state_bytes() + self._episodes.state_bytes()
