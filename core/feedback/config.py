"""Settings of credit assignment and of simulated participants. No numerical library is imported."""

import math
from typing import Annotated, Literal

import msgspec

from core.configuration.fields import number
from core.feedback.delays import Delay, Density, GammaDelay, PerValueDelay, PreviousStep

Knowledge = Literal["expert", "lay", "myopic"]
"""By what a simulated participant judges; each domain says what these see."""


class CreditConfig(msgspec.Struct, frozen=True, kw_only=True, forbid_unknown_fields=True):
    """How presses become samples."""

    delay: Delay = PreviousStep()
    """Density of the delay, or a rule. Previous step: TAMER's rule for Tetris (`docs/decisions`)."""
    scheme: Literal["individual", "aggregate"] = "individual"
    """Individual: one sample per press and step, weighted by its share (K-CAP 2009). Aggregate: one sample
    per step, its label the sum of value * share over all presses (TAMER's later default)."""
    silence: Literal["no-update", "zero-label"] = "no-update"
    """What a step without any press says: nothing, or 0 (TAMER's code; with the aggregate scheme only)."""
    merge_within_s: Annotated[float, number("seconds", ge=0, le=1e6, usual=(0, 10))] = 0.0
    """A press of the same value within this time of the press before belongs to the same burst, and a burst
    counts as its first press. 0: every press counts (as in the paper and in TAMER)."""

    def __post_init__(self) -> None:
        if self.silence == "zero-label" and self.scheme == "individual":
            raise ValueError("silence='zero-label' needs scheme='aggregate': only a whole step can be silent")
        if not 0 <= self.merge_within_s < math.inf:
            raise ValueError(f"merge_within_s is >= 0 seconds, got {self.merge_within_s}")


class TrainerConfig(msgspec.Struct, frozen=True, kw_only=True, forbid_unknown_fields=True):
    """What kind of participant is simulated."""

    press_probability: Annotated[float, number(ge=0, le=1)] = 0.03
    """Chance per step to say anything: about 2 presses in an episode of 60 steps (section 4: 2 on
    average)."""
    max_presses: Annotated[int, number("judgements", ge=0, le=1_000_000)] = 5
    """Judgements per episode, bursts counted once (section 4: no more than 5 times in any Tetris episode)."""
    mean_presses: Annotated[float, number("judgements", ge=0, le=1_000_000)] | None = None
    """Judgements per long episode on average: the most for an episode is then drawn from a binomial
    distribution with this mean and at most `max_presses`. None: always `max_presses`. (Section 4: at most 5,
    on average 2.)"""
    knowledge: Knowledge = "expert"
    """By what they judge. Expert: a controller far beyond the learner's features; lay: what meets the eye;
    myopic: the immediate effect of the step alone (B-Pref's myopia, to the end)."""
    good_share: Annotated[float, number(ge=0, le=1)] = 0.25
    """An action among this fraction of the best ones is good, any other is bad. (Our choice.)"""
    skip_margin: Annotated[float, number(ge=0, le=1)] = 0.0
    """No judgement where the action's rank is within this fraction of the border between good and bad."""
    equal_margin: Annotated[float, number("standard deviations", ge=0, le=1e6, usual=(0, 10))] = 0.0
    """No judgement where the action's value is within this many sd of the values on offer from the border
    between good and bad (B-Pref's "equal": values too close to tell apart)."""
    mistake_rate: Annotated[float, number(ge=0, le=1)] = 0.1
    """Chance of the wrong key by mistake (B-Pref: 0.1). 1 is an adversary."""
    deliberate_rate: Annotated[float, number(ge=0, le=1)] = 0.0
    """Chance of a deliberately wrong press (section 4: about 0.1 in Keepaway, on instruction)."""
    delay: Density | PerValueDelay = GammaDelay()
    """From the end of the step's time on screen, when its outcome is seen, to the press (Fig. 4). A delay
    per value goes by what the press says, in sessions; experiments have one density for all."""
    anticipation_rate: Annotated[float, number(ge=0, le=1)] = 0.0
    """Chance of pressing before the outcome is seen, at a random moment of the step."""
    burst_rate: Annotated[float, number(ge=0, le=1)] = 0.0
    """Chance that a judgement is given by several presses (TAMER's logs: two of four people nearly
    always)."""
    burst_presses: Annotated[int, number("presses", ge=1, le=1000)] = 3
    """Presses in a burst. (Our choice.)"""
    burst_interval_s: Annotated[float, number("seconds", gt=0, le=1e6, usual=(0.001, 10))] = 0.19
    """Between the presses of a burst (TAMER's logs: medians of 0.18 to 0.20 s)."""
    fatigue_half_life_episodes: Annotated[float, number("watched episodes", gt=0)] | None = None
    """Watched episodes after which presses have become half as likely; None: never tired."""
    stops_after_episodes: Annotated[int, number("watched episodes", ge=0, le=1_000_000_000)] | None = None
    """Says nothing any more after this many watched episodes; None: stays."""

    def __post_init__(self) -> None:
        rates = ("press_probability", "mistake_rate", "deliberate_rate", "anticipation_rate", "burst_rate")
        for name in (*rates, "good_share", "skip_margin"):
            if not 0 <= getattr(self, name) <= 1:
                raise ValueError(f"{name} is in [0, 1], got {getattr(self, name)}")
        if not 0 <= self.equal_margin < math.inf:
            raise ValueError(f"equal_margin is >= 0 standard deviations, got {self.equal_margin}")
        if self.max_presses < 0 or self.burst_presses < 1:
            raise ValueError(
                f"need max_presses >= 0 and burst_presses >= 1: {self.max_presses}, {self.burst_presses}"
            )
        if self.mean_presses is not None and not 0 <= self.mean_presses <= self.max_presses:
            raise ValueError(f"mean_presses is 0..max_presses ({self.max_presses}), got {self.mean_presses}")
        if not 0 < self.burst_interval_s < math.inf:
            raise ValueError(f"burst_interval_s is > 0 seconds, got {self.burst_interval_s}")
        if self.fatigue_half_life_episodes is not None and not self.fatigue_half_life_episodes > 0:
            raise ValueError(f"fatigue_half_life_episodes is > 0: {self.fatigue_half_life_episodes}")
        if self.stops_after_episodes is not None and self.stops_after_episodes < 0:
            raise ValueError(f"stops_after_episodes is >= 0, got {self.stops_after_episodes}")
