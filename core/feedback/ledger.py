"""What was on screen, what was pressed, and the samples that follow: the state behind `CreditAssigner`."""

import math
from array import array
from bisect import bisect_left, bisect_right
from collections import deque
from dataclasses import dataclass

import numpy as np

from core.domain import Features
from core.feedback.credit import STILL_SHOWN_NS, CurrentStep, PreviousStep, credit
from core.feedback.delays import PressRule, rule_for
from core.feedback.samples import CreditConfig, FeedbackSample, MassAccount, PressCredit
from core.numerics.clock import NS_PER_S

LATENESS_NS = 200_000_000
"""A report may come this long after what it reports (terminal, queues): a press still finds its step open,
and frames whose times cross by less are put in order."""

FORGET_AFTER_NS = 60 * NS_PER_S
"""So long after a step can receive no more credit it is kept all the same."""

KEPT_STEPS = 3
"""So many of the last steps are kept however old they are: one of them may be on screen still."""


@dataclass(frozen=True, slots=True)
class _Press:
    time_ns: int
    value: float
    opener: int
    """First press of its burst."""


@dataclass(frozen=True, slots=True)
class Mark:
    """A moment to which a ledger can go back. Its counts go from the beginning of the session."""

    n_samples: int
    account: MassAccount
    n_intervals: int
    last_hidden_ns: int
    n_steps: int
    n_presses: int
    labels: dict[int, float]
    presses: dict[int, list[int]]
    n_final: int
    n_looked_at: int
    untouched: tuple[tuple[int, int], ...]
    last_press: "_Press | None"
    n_before_gap: int
    gap_ns: int


class Ledger:
    """Takes events in order and forgets none of their effects.

    A session of hours has tens of thousands of steps, and few presses: what only a press needs of a step is
    made by the press, and features are forgotten once no press can need them any more. Steps of long ago are
    forgotten where `forget_before` allows it.
    """

    def __init__(self, config: CreditConfig, features: dict[int, Features]) -> None:
        self.samples: list[FeedbackSample] = []
        self.n_settled = 0
        """How many earlier samples were let go of: no press behind them can be taken back."""
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
        # Steps, and intervals on screen, that were forgotten; all other counts go without them.
        self._gone_steps = 0
        self._gone_intervals = 0

    def mark(self) -> Mark:
        """Return this moment, to go back to."""
        return Mark(
            n_samples=self.n_settled + len(self.samples),
            account=self.account,
            n_intervals=self._gone_intervals + len(self._shown_ns),
            last_hidden_ns=self._hidden_ns[-1] if self._hidden_ns else STILL_SHOWN_NS,
            n_steps=self._gone_steps + len(self._steps),
            n_presses=self._n_presses,
            labels=dict(self._labels),
            presses={step: list(presses) for step, presses in self._presses.items()},
            n_final=self._gone_steps + self._n_final,
            n_looked_at=self._gone_steps + self._n_looked_at,
            untouched=tuple(self._untouched),
            last_press=self._last_press,
            n_before_gap=self._gone_intervals + self._n_before_gap,
            gap_ns=self._gap_ns,
        )

    def go_back(self, mark: Mark) -> None:
        """Become what the ledger was at a mark. Features that were forgotten since stay so."""
        del self.samples[mark.n_samples - self.n_settled :]
        self.account = mark.account
        n_intervals = mark.n_intervals - self._gone_intervals
        for of_intervals in (self._shown_ns, self._hidden_ns, self._interval_steps):
            del of_intervals[n_intervals:]
        if n_intervals:
            self._hidden_ns[-1] = mark.last_hidden_ns
        for of_steps in (self._steps, self._n_presses_before):
            del of_steps[mark.n_steps - self._gone_steps :]
        self._n_presses = mark.n_presses
        self._labels = dict(mark.labels)
        self._presses = {step: list(presses) for step, presses in mark.presses.items()}
        self._n_final = max(mark.n_final - self._gone_steps, 0)
        self._n_looked_at = max(mark.n_looked_at - self._gone_steps, 0)
        self._untouched = deque(mark.untouched)
        self._last_press = mark.last_press
        self._n_before_gap = max(mark.n_before_gap - self._gone_intervals, 0)
        self._gap_ns = mark.gap_ns
        self._finished = False

    def settle(self, n_samples: int) -> list[FeedbackSample]:
        """Let go of the samples before number `n_samples` of the session; return those that were still kept.

        The ledger can go back to marks with as many samples or more, and to no earlier one.
        """
        n_new = max(n_samples - self.n_settled, 0)
        settled = self.samples[:n_new]
        del self.samples[:n_new]
        self.n_settled += len(settled)
        return settled

    def forget_before(self, mark: Mark) -> None:
        """Forget the steps before a mark that left the screen so long before it that no press reaches them.

        The ledger can go back to this mark and to later ones, and to no earlier one. A press that would
        reach what is forgotten is refused.
        """
        n_intervals = mark.n_intervals - self._gone_intervals
        at_most = mark.n_steps - self._gone_steps - KEPT_STEPS
        if self._config.scheme == "aggregate":
            at_most = min(at_most, mark.n_final - self._gone_steps - 1)
        if n_intervals == 0 or at_most <= 0:
            return
        before_ns = self._shown_ns[n_intervals - 1] - FORGET_AFTER_NS - self._horizon_ns() - LATENESS_NS
        # The first interval kept is the last one that began by then, or an earlier one of its step.
        first = max(bisect_right(self._shown_ns, before_ns) - 1, 0)
        n_steps = min(bisect_left(self._steps, self._interval_steps[first]), at_most)
        n_gone = bisect_left(self._interval_steps, self._steps[n_steps])
        for step in self._steps[:n_steps]:
            self._features.pop(step, None)
        for of_intervals in (self._shown_ns, self._hidden_ns, self._interval_steps):
            del of_intervals[:n_gone]
        for of_steps in (self._steps, self._n_presses_before):
            del of_steps[:n_steps]
        self._n_final = max(self._n_final - n_steps, 0)
        self._n_looked_at = max(self._n_looked_at - n_steps, 0)
        self._n_before_gap = max(self._n_before_gap - n_gone, 0)
        self._gone_steps += n_steps
        self._gone_intervals += n_gone

    def step_shown(self, step: int, shown_ns: int) -> None:
        """A step came on screen, or came back. Arguments as in `CreditAssigner`."""
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
        """A step left the screen with nothing in its place. Arguments as in `CreditAssigner`."""
        self._check_open()
        if not self._was_shown(step):
            raise ValueError(f"step {step} was never shown, so it cannot be hidden")
        if self._interval_steps[-1] == step and self._hidden_ns[-1] == STILL_SHOWN_NS:
            hidden_ns = _not_before(self._shown_ns[-1], hidden_ns, f"step {step} hidden")
            self._hidden_ns[-1] = hidden_ns
        self._give_out_final_steps(hidden_ns)

    def interrupted(self, last_ns: int) -> None:
        """The program stood still from `last_ns` on. Arguments as in `CreditAssigner`."""
        self._check_open()
        if self._shown_ns and self._hidden_ns[-1] == STILL_SHOWN_NS:
            self._hidden_ns[-1] = _not_before(self._shown_ns[-1], last_ns, "the interruption")
        self._n_before_gap, self._gap_ns = len(self._shown_ns), last_ns
        self._last_press = None

    def add_press(self, press: int, time_ns: int, value: float) -> PressCredit:
        """Share out a press. Arguments as in `CreditAssigner`."""
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
        """Give out the samples of all steps. Arguments as in `CreditAssigner`."""
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
        first = self._first_relevant_interval(press, time_ns, rule)
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
            raise _too_late(press, f"step {step}")
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

    def _first_relevant_interval(self, press: int, press_ns: int, rule: PressRule) -> int:
        """Return the first interval that can matter; what lies before it is beyond the delay's reach."""
        match rule:
            case PreviousStep() | CurrentStep():
                on_screen = bisect_right(self._shown_ns, press_ns) - 1
                if on_screen >= 0:
                    on_screen = bisect_left(self._interval_steps, self._interval_steps[on_screen])
                first = on_screen - 1
            case density:
                horizon_ns = math.ceil(density.horizon_s * NS_PER_S) + 1
                first = bisect_right(self._shown_ns, press_ns - horizon_ns) - 1
        if first < 0 and self._gone_intervals:
            raise _too_late(press, "a step")
        return max(first, 0)

    def _give_out_final_steps(self, now_ns: int) -> None:
        """Give out the aggregate sample of each step that can receive no more credit."""
        if self._config.scheme == "individual":
            return
        while self._n_final < len(self._steps) and self._is_final(self._n_final, now_ns):
            step = self._steps[self._n_final]
            presses = tuple(self._presses.pop(step, ()))  # none can follow: it is given out
            label = self._labels.pop(step, 0.0)
            if presses or self._config.silence == "zero-label":
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
            closed_ns = self._hidden_ns[interval - 1] + self._horizon_ns()
        return now_ns > closed_ns + LATENESS_NS

    def _horizon_ns(self) -> int:
        """Return how long after a step a press can be for it, ns; 0 where the rule goes by steps alone."""
        if isinstance(self._config.delay, PreviousStep | CurrentStep):
            return 0
        return math.ceil(self._config.delay.horizon_s * NS_PER_S)


def _not_before(earliest_ns: int, time_ns: int, what: str) -> int:
    """Return the time, or `earliest_ns` where two reports of the screen crossed on their way."""
    if time_ns < earliest_ns - LATENESS_NS:
        raise ValueError(
            f"{what} at {time_ns} ns, but the screen is known until {earliest_ns} ns: times must not go back"
        )
    return max(time_ns, earliest_ns)


def _too_late(press: int, step: str) -> ValueError:
    return ValueError(
        f"press {press} is for {step}, which left the screen more than {FORGET_AFTER_NS // NS_PER_S} s ago"
    )
