"""From what was on screen and what was pressed to the samples a human reward model learns from."""

import math
from array import array
from bisect import bisect_left, bisect_right
from collections import deque
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import Any, TypeVar

import numpy as np

from core.domain import Features
from core.feedback.credit import STILL_SHOWN_NS, CurrentStep, PreviousStep, credit
from core.feedback.delays import PressRule, rule_for
from core.feedback.samples import CreditConfig, FeedbackSample, MassAccount, PressCredit
from core.numerics.clock import NS_PER_S

__all__ = ["CreditAssigner", "CreditConfig", "FeedbackSample", "MassAccount", "PressCredit"]

LATENESS_NS = 200_000_000
"""A report may come this long after what it reports (terminal, queues): a press still finds its step open,
and frames whose times cross by less are put in order."""

FORGET_AFTER_NS = 60 * NS_PER_S
"""So long after a step can receive no more credit its features are kept all the same."""

Answer = TypeVar("Answer")
_Entry = tuple[Any, ...]
"""What happened: a method of `_Ledger`, and its arguments."""


class CreditAssigner:
    """Follows a session and keeps the list of samples it has given so far.

    Call the methods in the order of events. Steps have numbers that never fall; a step may be covered and
    shown again; between steps there may be gaps.
    """

    def __init__(self, config: CreditConfig) -> None:
        self.config = config
        self._features: dict[int, Features] = {}
        self._ledger = _Ledger(config, self._features)
        # Everything that happened, so that a press can be taken out of the past. Two entries per step for
        # hours: small.
        self._log: list[_Entry] = []
        self._known: set[int] = set()
        self._taken = 0

    @property
    def samples(self) -> Sequence[FeedbackSample]:
        """All samples so far, in the order in which a model is to see them."""
        return self._ledger.samples

    @property
    def account(self) -> MassAccount:
        """Where the mass of all presses went."""
        return self._ledger.account

    def take(self) -> Sequence[FeedbackSample]:
        """Return the samples that are new since the last call."""
        new = self._ledger.samples[self._taken :]
        self._taken = len(self._ledger.samples)
        return new

    def step_shown(self, step: int, shown_ns: int, features: Features) -> None:
        """Note that a step came on screen, or came back after it had been covered.

        Args:
            step: its number, >= that of every step before.
            shown_ns: when; whatever was on screen until then is hidden by it.
            features: psi(s, a) of the step, shape (G,).
        """
        if step not in self._features:
            self._features[step] = features.copy()
        self._do(_Ledger.step_shown, step, shown_ns)

    def step_hidden(self, step: int, hidden_ns: int) -> None:
        """Note that a step left the screen with nothing in its place: a pause, the end of an episode."""
        self._do(_Ledger.step_hidden, step, hidden_ns)

    def interrupted(self, last_ns: int) -> None:
        """Note that the program stood still from `last_ns` on, and has gone on since (`core.events.TimeGap`).

        What was on screen is hidden from `last_ns` on. No later press is credited to what was on screen
        before: what would have fallen there counts as `in_gaps`. A burst of presses ends there.
        """
        self._do(_Ledger.interrupted, last_ns)

    def add_press(self, press: int, time_ns: int, value: float) -> PressCredit:
        """Share out a press.

        Args:
            press: its number; no other press has the same.
            time_ns: when.
            value: what it says, > 0 good, < 0 bad, 0 neither: then the label of its samples is 0.
        """
        if press in self._known:
            raise ValueError(f"press {press} was given already")
        given = self._do(_Ledger.add_press, press, time_ns, value)
        self._known.add(press)
        return given

    def retract(self, press: int) -> None:
        """Take a press back: `samples` and `account` become those of a session without it.

        Afterwards a model has to be fitted to all `samples` again; `take` goes on from their end.
        """
        kept = [entry for entry in self._log if entry[0] is not _Ledger.add_press or entry[1] != press]
        if len(kept) == len(self._log):
            raise ValueError(f"press {press} cannot be retracted: it was never given, or retracted before")
        self._log = kept
        self._ledger = _Ledger(self.config, self._features)
        for event, *facts in kept:
            event(self._ledger, *facts)
        self._taken = len(self._ledger.samples)

    def finish(self, now_ns: int) -> None:
        """Give out the samples of all steps: the session is over, and no press can come any more."""
        self._do(_Ledger.finish, now_ns)

    def _do(self, event: Callable[..., Answer], *facts: Any) -> Answer:
        answer = event(self._ledger, *facts)
        self._log.append((event, *facts))  # only what succeeded can be repeated
        return answer


@dataclass(frozen=True, slots=True)
class _Press:
    time_ns: int
    value: float
    opener: int
    """First press of its burst."""


class _Ledger:
    """The state behind `CreditAssigner`; takes events in order and forgets none of their effects.

    A session of hours has tens of thousands of steps, and few presses: what only a press needs of a step is
    made by the press, and features are forgotten once no press can need them any more.
    """

    def __init__(self, config: CreditConfig, features: dict[int, Features]) -> None:
        self.samples: list[FeedbackSample] = []
        self.account = MassAccount()
        self._config = config
        # One entry per interval on screen; all three ascend.
        self._shown_ns = array("q")
        self._hidden_ns = array("q")
        self._interval_steps = array("q")
        # One entry per step, in order: its number, and how many presses had come when it was shown.
        self._steps = array("q")
        self._features = features
        self._n_presses_before = array("q")
        self._n_presses = 0
        # Of the steps that have received credit.
        self._labels: dict[int, float] = {}
        self._presses: dict[int, list[int]] = {}
        self._n_final = 0
        self._n_looked_at = 0
        # (when its features are forgotten, step) of final steps near which no press was made.
        self._untouched: deque[tuple[int, int]] = deque()
        self._last_press: _Press | None = None
        # Intervals on screen before the last interruption, and when that began.
        self._n_before_gap = 0
        self._gap_ns = 0
        self._finished = False

    def step_shown(self, step: int, shown_ns: int) -> None:
        self._check_open()
        if self._shown_ns:
            last, still_shown = self._interval_steps[-1], self._hidden_ns[-1] == STILL_SHOWN_NS
            if step == last and still_shown:
                return  # a new frame of the same step
            if step < last:
                raise ValueError(f"step {step} is shown after step {last}: steps must not go back")
            earliest_ns = self._shown_ns[-1] if still_shown else self._hidden_ns[-1]
            shown_ns = _not_before(earliest_ns, shown_ns, f"step {step} shown")
            if still_shown:
                self._hidden_ns[-1] = shown_ns
        if not self._steps or step > self._steps[-1]:
            self._steps.append(step)
            self._n_presses_before.append(self._n_presses)
        self._shown_ns.append(shown_ns)
        self._hidden_ns.append(STILL_SHOWN_NS)
        self._interval_steps.append(step)
        self._give_out_final_steps(shown_ns)
        self._forget_features(shown_ns)

    def step_hidden(self, step: int, hidden_ns: int) -> None:
        self._check_open()
        if not self._was_shown(step):
            raise ValueError(f"step {step} was never shown, so it cannot be hidden")
        if self._interval_steps[-1] == step and self._hidden_ns[-1] == STILL_SHOWN_NS:
            hidden_ns = _not_before(self._shown_ns[-1], hidden_ns, f"step {step} hidden")
            self._hidden_ns[-1] = hidden_ns
        self._give_out_final_steps(hidden_ns)

    def interrupted(self, last_ns: int) -> None:
        self._check_open()
        if self._shown_ns and self._hidden_ns[-1] == STILL_SHOWN_NS:
            self._hidden_ns[-1] = _not_before(self._shown_ns[-1], last_ns, "the interruption")
        self._n_before_gap, self._gap_ns = len(self._shown_ns), last_ns
        self._last_press = None

    def add_press(self, press: int, time_ns: int, value: float) -> PressCredit:
        self._check_open()
        if not math.isfinite(value):
            raise ValueError(f"press {press}: a value is > 0 (good), < 0 (bad) or 0 (neither), got {value}")
        opener = self._opener(press, time_ns, value)
        self._n_presses += 1
        self._last_press = _Press(time_ns, value, opener)
        given = (
            PressCredit(press, merged_into=opener)
            if opener != press
            else self._share_out(press, time_ns, value)
        )
        self.account = self.account.plus(given)
        self._give_out_final_steps(time_ns)
        return given

    def finish(self, now_ns: int) -> None:
        if not self._finished and self._shown_ns and self._hidden_ns[-1] == STILL_SHOWN_NS:
            self._hidden_ns[-1] = max(now_ns, self._shown_ns[-1])
        self._finished = True
        self._give_out_final_steps(now_ns)

    def _check_open(self) -> None:
        if self._finished:
            raise ValueError("the session was finished: no step or press can follow")

    def _opener(self, press: int, time_ns: int, value: float) -> int:
        """Return the first press of the burst to which this one belongs; itself if it opens one."""
        last = self._last_press
        window_ns = round(self._config.merge_within_s * NS_PER_S)
        if last is None or window_ns == 0 or value != last.value or time_ns - last.time_ns > window_ns:
            return press
        return last.opener

    def _share_out(self, press: int, time_ns: int, value: float) -> PressCredit:
        rule = rule_for(self._config.delay, value)
        first = self._first_relevant_interval(time_ns, rule)
        result = credit(
            time_ns,
            np.array(self._shown_ns[first:], dtype=np.int64),
            np.array(self._hidden_ns[first:], dtype=np.int64),
            rule,
            steps=np.array(self._interval_steps[first:], dtype=np.int64),
        )
        by_step: dict[int, float] = {}
        beyond_gap = 0.0
        n_cut_off = self._n_before_gap - first if time_ns > self._gap_ns else 0
        for n, credit_share in enumerate(result.shares.tolist()):
            step = self._interval_steps[first + n]
            if n < n_cut_off:
                beyond_gap += credit_share
            elif credit_share > 0:
                by_step[step] = by_step.get(step, 0.0) + credit_share
        too_late = 0.0
        if self._config.scheme == "aggregate":
            for step in [step for step in by_step if self._is_given_out(step)]:
                too_late += by_step.pop(step)
        for step, credit_share in by_step.items():
            self._give(press, step, value, credit_share)
        return PressCredit(
            press,
            tuple(by_step),
            tuple(by_step.values()),
            result.before_first,
            result.in_gaps + beyond_gap,
            too_late,
        )

    def _give(self, press: int, step: int, value: float, credit_share: float) -> None:
        if step not in self._features:
            raise ValueError(
                f"press {press} is for step {step}, which left the screen more than "
                f"{FORGET_AFTER_NS // NS_PER_S} s ago"
            )
        if self._config.scheme == "individual":
            self.samples.append(
                FeedbackSample(self._features[step], value, min(credit_share, 1.0), step, (press,))
            )
        else:
            self._labels[step] = self._labels.get(step, 0.0) + value * credit_share
            self._presses.setdefault(step, []).append(press)

    def _was_shown(self, step: int) -> bool:
        index = bisect_left(self._steps, step)
        return index < len(self._steps) and self._steps[index] == step

    def _forget_features(self, now_ns: int) -> None:
        """Forget the features of steps that no press can reach any more, and near which none was made.

        Steps near a press keep theirs: when the press is taken back, another one of its burst may reach them.
        """
        if self._config.silence == "zero-label":
            return  # every step becomes a sample, and samples are kept
        while self._n_looked_at < len(self._steps) and self._is_final(self._n_looked_at, now_ns):
            if self._n_presses_before[self._n_looked_at] == self._n_presses:
                self._untouched.append((now_ns + FORGET_AFTER_NS, self._steps[self._n_looked_at]))
            self._n_looked_at += 1
        while self._untouched and self._untouched[0][0] < now_ns:
            self._features.pop(self._untouched.popleft()[1], None)

    def _first_relevant_interval(self, press_ns: int, rule: PressRule) -> int:
        """Return the first interval that can matter; what lies before it is beyond the delay's reach."""
        match rule:
            case PreviousStep() | CurrentStep():
                on_screen = bisect_right(self._shown_ns, press_ns) - 1
                if on_screen < 0:
                    return 0
                first_of_step = bisect_left(self._interval_steps, self._interval_steps[on_screen])
                return max(first_of_step - 1, 0)
            case density:
                horizon_ns = math.ceil(density.horizon_s * NS_PER_S) + 1
                return max(bisect_right(self._shown_ns, press_ns - horizon_ns) - 1, 0)

    def _give_out_final_steps(self, now_ns: int) -> None:
        """Give out the aggregate sample of each step that can receive no more credit."""
        if self._config.scheme == "individual":
            return
        while self._n_final < len(self._steps) and self._is_final(self._n_final, now_ns):
            step = self._steps[self._n_final]
            presses = tuple(self._presses.get(step, ()))
            if presses or self._config.silence == "zero-label":
                label = self._labels.get(step, 0.0)
                self.samples.append(FeedbackSample(self._features[step], label, 1.0, step, presses))
            self._n_final += 1

    def _is_given_out(self, step: int) -> bool:
        return self._n_final > 0 and step <= self._steps[self._n_final - 1]

    def _is_final(self, index: int, now_ns: int) -> bool:
        if self._finished:
            return True
        # A step can come back on screen until the next one has been shown.
        successors = 2 if isinstance(self._config.delay, PreviousStep) else 1
        if index + successors >= len(self._steps):
            return False
        interval = bisect_left(self._interval_steps, self._steps[index + successors])
        if isinstance(self._config.delay, PreviousStep | CurrentStep):
            closed_ns = self._shown_ns[interval]
        else:
            closed_ns = self._hidden_ns[interval - 1] + math.ceil(self._config.delay.horizon_s * NS_PER_S)
        return now_ns > closed_ns + LATENESS_NS


def _not_before(earliest_ns: int, time_ns: int, what: str) -> int:
    """Return the time, or `earliest_ns` where two reports of the screen crossed on their way."""
    if time_ns < earliest_ns - LATENESS_NS:
        raise ValueError(
            f"{what} at {time_ns} ns, but the screen is known until {earliest_ns} ns: times must not go back"
        )
    return max(time_ns, earliest_ns)
