"""Which recorded times go into a fit: one policy, stored with the result; rows are judged, never deleted."""

from collections import Counter
from collections.abc import Sequence
from typing import Literal

import msgspec
import numpy as np

from studies.reaction_time.sample import FitError, Sample

Verdict = Literal[
    "kept",
    "timed out",
    "practice",
    "catch",
    "missing",
    "no response",
    "negative",
    "wrong key",
    "repeat",
    "anticipation",
    "slow",
    "absurd",
    "abandoned",
]
"""Why a row is in ("kept", "timed out": as a censored time) or out of a fit."""


class Row(msgspec.Struct, frozen=True, kw_only=True):
    """One recorded trial, whatever file it came from."""

    participant: str
    source: str
    """File and line."""
    rt_s: float | None
    """As recorded, in seconds: None where missing; 0, negative and absurd values as they are."""
    status: str = "ok"
    """Status of our own recordings; "ok" for others."""
    practice: bool = False
    response_asked: bool = True
    """False in catch and no-go trials."""
    waited_s: float | None = None
    """How long the trial waited for a response; None where not known."""
    abandoned: bool = False


SLOW_ABOVE_S: dict[str, float] = {"reaction": 3.0, "evaluation": 10.0}
"""Kind of task to the default of `ExclusionPolicy.slow_above_s`. Reactions: rtdists. Evaluations: in 5,349 of
a robot 5 % take longer than 3 s, and none was slower than its window of 5 s (`docs/results/delays.md`). (Our
choice.)"""


def kind_of_task(task: str) -> Literal["reaction", "evaluation"]:
    """Return whether a task's name says that an agent is judged (evaluation, feedback lag)."""
    lower = task.lower().replace("-", " ").replace("_", " ")
    words = ("evaluat", "feedback", "judg", "rating")
    return "evaluation" if any(word in lower for word in words) else "reaction"


class ExclusionPolicy(msgspec.Struct, frozen=True, kw_only=True, forbid_unknown_fields=True):
    """What counts as a reaction. Times on a limit are kept."""

    anticipation_below_s: float = 0.1
    """Faster is not a reaction (0.10 to 0.15 s for simple reactions, 0.25 s with a decision: PsyToolkit)."""
    slow_above_s: float = 3.0
    """Slower is something else. Limits belong to the task: see `SLOW_ABOVE_S`."""
    absurd_above_s: float = 30.0
    """Slower is a fault of the file."""
    keep_practice: bool = False
    keep_wrong: bool = False
    """Use the times of wrong answers, too."""
    time_outs: Literal["censor", "exclude"] = "censor"
    """Trials without a response: right-censored where the waiting time is known, or left out."""

    def __post_init__(self) -> None:
        if not 0.0 <= self.anticipation_below_s < self.slow_above_s <= self.absurd_above_s:
            raise ValueError(
                "need 0 <= anticipation_below_s < slow_above_s <= absurd_above_s, got "
                f"{self.anticipation_below_s}, {self.slow_above_s} and {self.absurd_above_s} s"
            )


class Selection(msgspec.Struct, frozen=True, kw_only=True):
    """What a policy made of some rows."""

    policy: ExclusionPolicy
    verdicts: tuple[Verdict, ...]
    """One per row, in the rows' order."""
    counts: dict[str, dict[str, int]]
    """Participant to verdict to number of rows."""
    unusable: dict[str, str]
    """Participant to the reason why too little is left to fit."""


def judge(row: Row, policy: ExclusionPolicy) -> Verdict:
    """Return what the policy says of one row."""
    if row.abandoned:
        return "abandoned"
    if row.practice and not policy.keep_practice:
        return "practice"
    if not row.response_asked:
        return "catch"
    if row.status == "time-out" or row.rt_s == 0.0:
        censored = policy.time_outs == "censor" and row.waited_s is not None
        return "timed out" if censored else "no response"
    if row.rt_s is None:
        return "missing"
    if row.rt_s < 0.0:
        return "anticipation" if row.status == "anticipation" else "negative"
    if row.rt_s > policy.absurd_above_s:
        return "absurd"
    if row.status == "wrong key" and not policy.keep_wrong:
        return "wrong key"
    if row.status == "repeat":
        return "repeat"
    if row.status == "anticipation" or row.rt_s < policy.anticipation_below_s:
        return "anticipation"
    return "slow" if row.rt_s > policy.slow_above_s else "kept"


def select(rows: Sequence[Row], policy: ExclusionPolicy) -> tuple[dict[str, Sample], Selection]:
    """Return the samples to fit, by participant in order of appearance, and what happened to every row.

    A participant with too few usable responses has no sample but a reason in `Selection.unusable`.
    """
    verdicts = tuple(judge(row, policy) for row in rows)
    observed: dict[str, list[float]] = {row.participant: [] for row in rows}
    waited: dict[str, list[float]] = {participant: [] for participant in observed}
    counts: dict[str, Counter[str]] = {participant: Counter() for participant in observed}
    for row, verdict in zip(rows, verdicts, strict=True):
        counts[row.participant][verdict] += 1
        if verdict == "kept" and row.rt_s is not None:
            observed[row.participant].append(row.rt_s)
        elif verdict == "timed out" and row.waited_s is not None:
            waited[row.participant].append(row.waited_s)
    samples: dict[str, Sample] = {}
    unusable: dict[str, str] = {}
    for participant, times in observed.items():
        try:
            samples[participant] = Sample(np.array(times), np.array(waited[participant]))
        except FitError as error:
            unusable[participant] = str(error)
    plain = {participant: dict(sorted(counter.items())) for participant, counter in counts.items()}
    return samples, Selection(policy=policy, verdicts=verdicts, counts=plain, unusable=unusable)
