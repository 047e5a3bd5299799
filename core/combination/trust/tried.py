"""The rule "tried": attitudes to the participant are tried out, and performance says which one is kept."""

import struct
from typing import Annotated, ClassVar

import msgspec

from core.combination.ranking import EpisodeReport
from core.combination.trust.contract import (
    Evidence,
    Needs,
    RecentEpisodes,
    Trust,
    check_memory,
    check_weight,
)
from core.combination.trust.measures import rank_test
from core.configuration.fields import number
from core.numerics.streams import stream


class Tried(msgspec.Struct, frozen=True, forbid_unknown_fields=True, tag="tried"):
    """The participant's word is tried out, and performance says what to make of it (ours;
    `docs/decisions/tried-trust.md`).

    w_h = attitude * weight. The attitude is 1 (believe), 0, or -1 (believe the opposite), whichever went with
    the better episodes. Others are tried in a fraction of the episodes, but only while there is something to
    try: while the presses can be foreseen from what they are about (`core.learners.consistency`), as random
    ones cannot.
    """

    needs: ClassVar[Needs] = Needs(consistency=True)

    weight: Annotated[float, number(gt=0, le=1e9, usual=(0.001, 1000))] = 1.0
    """|w_h| of a participant who is believed: as much say as the environment, both being standardised."""
    consistent_above: Annotated[float, number("standard errors", ge=0)] = 2.0
    """Standard errors by which presses must be foreseen better than chance for an attitude to be tried."""
    trial_share: Annotated[float, number(ge=0, le=1)] = 0.3
    """Fraction of episodes in which 1 or -1 is tried while the attitude is 0."""
    control_share: Annotated[float, number(ge=0, le=1)] = 0.05
    """Fraction of episodes played without the participant while it is 1 or -1."""
    better_by: Annotated[float, number("standard errors", ge=0)] = 3.0
    """Standard errors of the rank test (Mann & Whitney) by which another attitude must do better to be taken
    over."""
    minimum_episodes: Annotated[int, number("compared episodes", ge=2, le=1_000_000)] = 5
    """Episodes under an attitude before it is compared."""
    episodes: Annotated[int, number("compared episodes", ge=2, le=1_000_000)] = 200
    """How many recent compared episodes count."""

    def __post_init__(self) -> None:
        if not (0 <= self.trial_share <= 1 and 0 <= self.control_share <= 1):
            raise ValueError(f"shares are in [0, 1], got {self.trial_share} and {self.control_share}")
        check_weight(self.weight)
        if not min(self.better_by, self.consistent_above) >= 0:
            raise ValueError(
                f"need better_by >= 0 and consistent_above >= 0: {self.better_by}, {self.consistent_above}"
            )
        check_memory(self.minimum_episodes, self.episodes, least=2)

    def begin(self, *, root_seed: int) -> Trust:
        """Return trust of 0, nothing tried yet."""
        return _Tried(self, root_seed)


class _Tried(Trust):
    def __init__(self, rule: Tried, root_seed: int) -> None:
        self._rule = rule
        self._root_seed = root_seed
        self._recent = RecentEpisodes(rule.episodes)
        self._believed = 0.0
        self._attitude = 0.0
        self._n_compared = 0

    def revise(self, report: EpisodeReport, evidence: Evidence) -> None:
        """Note how the present attitude did, and decide which one the next episode is played with."""
        if report.agreement is None:
            return
        rule = self._rule
        self._recent.add(report.performance, self._attitude)
        self._n_compared += 1
        self._believed = self._attitude = self._best_attitude()
        rng = stream(self._root_seed, "trial", self._n_compared)
        tries, which = rng.random(2).tolist()
        if self._believed != 0.0:
            if tries < rule.control_share:
                self._attitude = 0.0
        elif report.consistency > rule.consistent_above and tries < rule.trial_share:
            self._attitude = 1.0 if which < 0.5 else -1.0
        self.w_h = self._attitude * rule.weight

    def state_bytes(self) -> bytes:
        """Return w_h, the two attitudes, and the recent episodes."""
        attitudes = struct.pack("<ddq", self._believed, self._attitude, self._n_compared)
        return super().state_bytes() + attitudes + self._recent.state_bytes()

    def _best_attitude(self) -> float:
        """Return the attitude that does best: the believed one, unless another is better by enough."""
        recent = list(zip(self._recent.performances, self._recent.numbers, strict=True))
        played = {attitude: [pm for pm, used in recent if used == attitude] for attitude in (0.0, 1.0, -1.0)}
        present = played.pop(self._believed)
        best, lead = self._believed, self._rule.better_by
        for attitude, performances in played.items():
            if min(len(performances), len(present)) >= self._rule.minimum_episodes:
                score = rank_test(performances, present)
                if score > lead:
                    best, lead = attitude, score
        return best
