"""Settings of trust (Eqs. 4, 5 and others), of bootstrap learning, and of asking. No compiled code is imported."""

import math
from typing import Annotated, Literal

import msgspec

from core.settings import number

MatchKind = Literal["rate", "chance-corrected", "signed"]
"""Degree of match: fraction of equal choices; the same above chance; best minus worst (`docs/decisions`)."""


class Equation4(msgspec.Struct, frozen=True, forbid_unknown_fields=True, tag="equation-4"):
    """w_h is the performance-weighted mean match of the top policies (Eq. 4)."""

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


class Equation5(msgspec.Struct, frozen=True, forbid_unknown_fields=True, tag="equation-5"):
    """w_h moves from episode to episode, weighted by performance (Eq. 5)."""

    match: Literal["rate", "signed"] = "rate"
    """m^k of the episode's policy, as in `Equation4`."""
    cumulative: bool = False
    """Weigh the past by the performance of all compared episodes so far; as printed, by the last one's."""


class Signed(msgspec.Struct, frozen=True, forbid_unknown_fields=True, tag="signed"):
    """Eq. 4 over recent episodes with the signed match, less its standard errors (ours; `docs/decisions`).

    w = sum pm_i a_i / sum pm_i, se = sd(a) sqrt(sum pm_i^2) / sum pm_i, w_h = gain sign(w) max(0, |w| - c se - margin).
    """

    episodes: Annotated[int, number("compared episodes", ge=2, le=1_000_000)] = 200
    """How many recent compared episodes count."""
    gain: Annotated[float, number(gt=0, le=1e9, usual=(0.001, 1000))] = 2.0
    """Factor that brings a good participant near the environment's weight."""
    standard_errors: Annotated[float, number("standard errors", ge=0, le=1e9, usual=(0, 100))] = 2.0
    """c: what is not this many standard errors from 0 is taken for 0."""
    margin: Annotated[float, number(ge=0, lt=1)] = 0.0
    """Agreement that is taken for chance whatever its standard error, in [0, 1): a human model learned from noise is one
    random policy in all episodes, and agrees with good ones by a fixed number (`docs/decisions/margin-of-agreement.md`)."""
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
        _check_memory(self.minimum_episodes, self.episodes, least=2)
        _check_gain(self.gain, self.standard_errors)


class RankCorrelation(msgspec.Struct, frozen=True, forbid_unknown_fields=True, tag="rank-correlation"):
    """Trust somebody if policies that agree with them do better (ours; `docs/decisions/signed-match.md`).

    r = Spearman's correlation between performance and agreement over recent episodes, less its standard error
    1 / sqrt(n - 1); w_h = gain r.
    """

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
        _check_memory(self.minimum_episodes, self.episodes, least=3)
        _check_gain(self.gain, self.standard_errors)


class Tried(msgspec.Struct, frozen=True, forbid_unknown_fields=True, tag="tried"):
    """The human's word is tried out, and performance says what to make of it (ours; `docs/decisions/tried-trust.md`).

    w_h = attitude * weight. The attitude is 1 (believe), 0, or -1 (believe the opposite), whichever went with the better
    episodes. Others are tried in a share of the episodes, but only while there is something to try: while the presses
    can be foreseen from what they are about (`core.learners.consistency`), as random ones cannot.
    """

    weight: Annotated[float, number(gt=0, le=1e9, usual=(0.001, 1000))] = 1.0
    """|w_h| of somebody who is believed: as much say as the environment, both being standardised."""
    consistent_above: Annotated[float, number("standard errors", ge=0)] = 2.0
    """Standard errors by which presses must be foreseen better than chance for an attitude to be tried."""
    trial_share: Annotated[float, number(ge=0, le=1)] = 0.3
    """Share of episodes in which 1 or -1 is tried while the attitude is 0."""
    control_share: Annotated[float, number(ge=0, le=1)] = 0.05
    """Share of episodes played without the human while it is 1 or -1."""
    better_by: Annotated[float, number("standard errors", ge=0)] = 3.0
    """Standard errors of the rank test (Mann & Whitney) by which another attitude must do better to be taken over."""
    minimum_episodes: Annotated[int, number("compared episodes", ge=2, le=1_000_000)] = 5
    """Episodes under an attitude before it is compared."""
    episodes: Annotated[int, number("compared episodes", ge=2, le=1_000_000)] = 200
    """How many recent compared episodes count."""

    def __post_init__(self) -> None:
        if not (0 <= self.trial_share <= 1 and 0 <= self.control_share <= 1):
            raise ValueError(f"shares are in [0, 1], got {self.trial_share} and {self.control_share}")
        _check_weight(self.weight)
        if not min(self.better_by, self.consistent_above) >= 0:
            raise ValueError(
                f"need better_by >= 0 and consistent_above >= 0: {self.better_by}, {self.consistent_above}"
            )
        _check_memory(self.minimum_episodes, self.episodes, least=2)


class SideBySide(msgspec.Struct, frozen=True, forbid_unknown_fields=True, tag="side-by-side"):
    """Learners side by side, one per attitude, and the signed match of the one without the human (ours).

    One learner chooses without the human, one believes them (w_h = weight), one believes the opposite (w_h = -weight). One
    plays each episode, all learn from it, each about its own choices. So the first becomes good at what nobody taught it, and
    whether its choices agree with the human says whom to believe (`docs/decisions/side-by-side.md`). It needs learners
    that can learn from what another one does: compiled play of Keepaway has them (`core.keepaway.arl_autoplay`).
    """

    weight: Annotated[float, number(gt=0, le=1e9, usual=(0.001, 1000))] = 1.0
    """|w_h| of the two that go by the human: as much say as the environment, both being standardised."""
    own_share: Annotated[float, number(ge=0, le=1)] = 0.2
    """Share of episodes that the learner without the human plays once the human is believed, or their opposite. Before
    that each plays a third."""
    other_share: Annotated[float, number(ge=0, le=1)] = 0.05
    """Share of episodes that the learner of the opposite attitude plays then."""
    warm_up_episodes: Annotated[int, number("compared episodes", ge=2, le=1_000_000)] = 60
    """Compared episodes without the human after which their agreement counts: before, that learner knows nothing."""
    episodes: Annotated[int, number("compared episodes", ge=2, le=1_000_000)] = 20
    """How many of its recent compared episodes count."""
    margin: Annotated[float, number(ge=0, lt=1)] = 0.1
    """As in `Signed`."""
    standard_errors: Annotated[float, number("standard errors", ge=0, le=1e9)] = 2.0
    """As in `Signed`."""

    def __post_init__(self) -> None:
        _check_weight(self.weight)
        if not (min(self.own_share, self.other_share) >= 0 and 0 < self.own_share + self.other_share <= 1):
            raise ValueError(
                f"shares are >= 0, their sum in (0, 1], got {self.own_share} and {self.other_share}"
            )
        if not (0 <= self.margin < 1 and self.standard_errors >= 0):
            raise ValueError(
                f"margin is an agreement in [0, 1), standard_errors >= 0: {self.margin}, {self.standard_errors}"
            )
        _check_memory(self.episodes, self.warm_up_episodes, least=2, names=("episodes", "warm_up_episodes"))


class FixedWeight(msgspec.Struct, frozen=True, forbid_unknown_fields=True, tag="fixed"):
    """Trust that no evidence changes: takes bootstrap learning out, for comparisons."""

    w_h: Annotated[float, number(ge=-1e9, le=1e9, usual=(-1000, 1000))] = 1.0
    """As much say as the environment, both being standardised. (Our choice.)"""

    def __post_init__(self) -> None:
        if not math.isfinite(self.w_h):
            raise ValueError(f"w_h is finite, got {self.w_h}")


TrustRule = Equation4 | Equation5 | Signed | RankCorrelation | Tried | SideBySide | FixedWeight
"""How w_h follows from performance and match; msgspec decodes it by its tag, the field "type"."""


class BootstrapConfig(msgspec.Struct, frozen=True, kw_only=True, forbid_unknown_fields=True):
    """Bootstrap learning (section 3.1)."""

    trust: TrustRule = Equation4()
    """How w_h follows from performance and match (the paper's first equation for it)."""
    top_policies: Annotated[int, number("policies", ge=1, le=100_000)] = 10
    """N, the number of policies kept. (The paper does not say; as many as the elite of one CE iteration.)"""
    symmetric: bool = True
    """A policy's selection probability rises with its match to the human policy, scaled by w_h: the agent
    "alternately assumes the policy based on each feedback mechanism to be ground truth"."""
    window_decisions: Annotated[int, number("decisions", ge=1, le=1_000_000)] = 200
    """Recent decisions kept for measuring matches anew. (Our choice.)"""

    def __post_init__(self) -> None:
        if self.top_policies < 1 or self.window_decisions < 1:
            raise ValueError(
                f"top_policies and window_decisions are >= 1: {self.top_policies}, {self.window_decisions}"
            )


class AskingConfig(msgspec.Struct, frozen=True, kw_only=True, forbid_unknown_fields=True):
    """When the agent poses a choice of candidate actions (`core.combination.asking`; `docs/decisions/asking.md`)."""

    per_episode: Annotated[int, number("questions", ge=0, le=1_000_000)] = 0
    """Questions per watched episode at most. 0: the agent never asks, as in the paper's experiments."""
    options: Annotated[int, number("actions", ge=2, le=3)] = 3
    """Candidate actions of a question at most, 2 or 3."""
    share: Annotated[float, number(gt=0, lt=1)] = 0.05
    """It asks where its policies disagree more than in all but this share of recent decisions, in (0, 1). (Our choice.)"""
    memory: Annotated[int, number("decisions", ge=1, le=1_000_000)] = 200
    """How many recent decisions that share is of. (Our choice.)"""
    minimum_decisions: Annotated[int, number("decisions", ge=1, le=1_000_000)] = 20
    """It does not ask before it has seen this many. (Our choice.)"""

    def __post_init__(self) -> None:
        if self.per_episode < 0 or self.options not in (2, 3) or not 0 < self.share < 1:
            raise ValueError(
                "asking needs per_episode >= 0, 2 or 3 options and a share in (0, 1), got "
                f"{self.per_episode}, {self.options}, {self.share}"
            )
        _check_memory(self.minimum_decisions, self.memory, least=1, names=("minimum_decisions", "memory"))


def _check_memory(
    minimum: int, kept: int, *, least: int, names: tuple[str, str] = ("minimum_episodes", "episodes")
) -> None:
    """Refuse a minimum that says nothing, or that what is kept can never reach."""
    if not least <= minimum <= kept:
        raise ValueError(f"need {least} <= {names[0]} <= {names[1]}, got {minimum} and {kept}")


def _check_weight(weight: float) -> None:
    if not (math.isfinite(weight) and weight > 0):
        raise ValueError(f"need weight > 0, got {weight}")


def _check_gain(gain: float, standard_errors: float) -> None:
    if not (math.isfinite(gain) and gain > 0 and standard_errors >= 0):
        raise ValueError(f"need gain > 0 and standard_errors >= 0: {gain}, {standard_errors}")
