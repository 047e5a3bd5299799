"""The rule "side-by-side": learners side by side, and the signed match of the one without the participant."""

import math
import struct
from typing import Annotated

import msgspec

from core.combination.agreement import Agreement
from core.combination.ranking import EpisodeReport
from core.combination.trust.contract import (
    Evidence,
    Needs,
    RecentEpisodes,
    Trust,
    check_memory,
    check_weight,
)
from core.combination.trust.measures import signed_human_weight
from core.configuration.fields import number
from core.numerics.streams import stream

ATTITUDES = (0.0, 1.0, -1.0)
"""Of the learners, in their order: without the participant, with them, against them."""


class SideBySide(msgspec.Struct, frozen=True, forbid_unknown_fields=True, tag="side-by-side"):
    """Learners side by side, one per attitude, and the signed match of the one without the participant
    (ours).

    One learner chooses without the participant, one believes them (w_h = weight), one believes the opposite
    (w_h = -weight). One plays each episode, all learn from it, each about its own choices. So the first
    becomes good at what nobody taught it, and whether its choices agree with the participant says whom to
    believe (`docs/decisions/side-by-side.md`). It needs learners that can learn from what another one does:
    compiled play of Keepaway has them (`core.keepaway.arl_autoplay`).
    """

    weight: Annotated[float, number(gt=0, le=1e9, usual=(0.001, 1000))] = 1.0
    """|w_h| of the two that go by the participant: as much say as the environment, both being
    standardised."""
    own_share: Annotated[float, number(ge=0, le=1)] = 0.2
    """Fraction of episodes that the learner without the participant plays once the participant is believed,
    or their opposite. Before that each plays a third."""
    other_share: Annotated[float, number(ge=0, le=1)] = 0.05
    """Fraction of episodes that the learner of the opposite attitude plays then."""
    warm_up_episodes: Annotated[int, number("compared episodes", ge=2, le=1_000_000)] = 60
    """Compared episodes without the participant after which their agreement counts: before, that learner
    knows nothing."""
    episodes: Annotated[int, number("compared episodes", ge=2, le=1_000_000)] = 20
    """How many of its recent compared episodes count."""
    margin: Annotated[float, number(ge=0, lt=1)] = 0.1
    """As in `Signed`."""
    standard_errors: Annotated[float, number("standard errors", ge=0, le=1e9)] = 2.0
    """As in `Signed`."""

    def __post_init__(self) -> None:
        check_weight(self.weight)
        if not (min(self.own_share, self.other_share) >= 0 and 0 < self.own_share + self.other_share <= 1):
            raise ValueError(
                f"shares are >= 0, their sum in (0, 1], got {self.own_share} and {self.other_share}"
            )
        if not (0 <= self.margin < 1 and self.standard_errors >= 0):
            raise ValueError(
                f"margin is an agreement in [0, 1), standard_errors >= 0: {self.margin}, "
                f"{self.standard_errors}"
            )
        check_memory(self.episodes, self.warm_up_episodes, least=2, names=("episodes", "warm_up_episodes"))

    @property
    def needs(self) -> Needs:
        """One learner per attitude."""
        return Needs(side_by_side=tuple(attitude * float(self.weight) for attitude in ATTITUDES))

    def begin(self, *, root_seed: int) -> Trust:
        """Return trust of 0: the learner without the participant plays first."""
        return _SideBySide(self, root_seed)


class _SideBySide(Trust):
    def __init__(self, rule: SideBySide, root_seed: int) -> None:
        self._rule = rule
        self._root_seed = root_seed
        self._recent = RecentEpisodes(rule.episodes)
        self._believed = 0.0
        self._attitude = 0.0
        self._n_compared = 0
        self._n_own = 0

    def match(self, agreement: Agreement) -> float:
        """Return best minus worst."""
        return agreement.signed

    def revise(self, report: EpisodeReport, evidence: Evidence) -> None:
        """Judge the participant by the episodes without them, and decide whose turn the next episode is."""
        if report.agreement is None:
            return
        rule = self._rule
        self._n_compared += 1
        if self._attitude == 0.0:
            self._n_own += 1
            self._recent.add(report.performance, self.match(report.agreement))
            if self._n_own >= rule.warm_up_episodes:
                self._believed = self._judged()
        point = float(stream(self._root_seed, "side by side", self._n_compared).random())
        if self._believed == 0.0:
            self._attitude = ATTITUDES[int(3 * point)]
        elif point < rule.own_share:
            self._attitude = 0.0
        else:
            opposite = point < rule.own_share + rule.other_share
            self._attitude = -self._believed if opposite else self._believed
        self.w_h = self._attitude * rule.weight

    def state_bytes(self) -> bytes:
        """Return w_h, the two attitudes, how many episodes were compared, and the recent ones."""
        attitudes = struct.pack("<ddqq", self._believed, self._attitude, self._n_compared, self._n_own)
        return super().state_bytes() + attitudes + self._recent.state_bytes()

    def _judged(self) -> float:
        """Return the attitude that agreement without the participant speaks for; 0 where it speaks for
        none.
        """
        w = signed_human_weight(
            self._recent.performances,
            self._recent.numbers,
            gain=1.0,
            standard_errors=self._rule.standard_errors,
            margin=self._rule.margin,
        )
        return 0.0 if w == 0.0 else math.copysign(1.0, w)
