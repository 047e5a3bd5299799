"""What a press was taken for, at once: the step that the credit rule gives more of it than any other.

The learner credits a press when the step on screen is over. The participant cannot wait for that, so the
worker answers from what has been on screen so far, with the function that gives credit.
"""

from collections import deque

from core.events import FrameShown, Input, KeyPressed, ScreenCleared
from core.feedback.delays import Delay, rule_for

REMEMBERED = 128
"""Intervals on screen that are kept: far more than any delay reaches back."""


class StepsShown:
    """Which step was on screen when."""

    def __init__(self, *rules: Delay) -> None:
        """Begin with an empty screen.

        Args:
            rules: by which each participant's presses are credited, in order.
        """
        self._rules = rules
        self._intervals: deque[tuple[int, int, int]] = deque(maxlen=REMEMBERED)
        """Step, time shown and time hidden, oldest first."""
        self._step = -1
        self._since_ns = 0

    def note(self, event: Input) -> None:
        """Take in what has happened on the screen."""
        match event:
            case FrameShown(step=step, flushed_ns=time_ns) if step != self._step:
                self._hide(time_ns)
                self._step, self._since_ns = step, time_ns
            case ScreenCleared(time_ns=time_ns, reason=reason):
                self._hide(time_ns)
                self._step = -1
                if reason == "question":  # no later press is credited to what was before
                    self._intervals.clear()
            case _:
                pass

    def taken_for(self, press: KeyPressed) -> int:
        """Return the step that gets the largest share, the later one of equals; -1 where none gets any."""
        import numpy as np  # not at the top: the screen's process imports this module with the worker's

        from core.feedback.credit import STILL_SHOWN_NS, credit

        intervals = list(self._intervals)
        if self._step >= 0:
            intervals.append((self._step, self._since_ns, STILL_SHOWN_NS))
        if not intervals:
            return -1
        table = np.array(intervals, dtype=np.int64)
        steps = table[:, 0]
        rule = rule_for(self._rules[press.person], press.value or 0.0)
        shares = credit(press.time_ns, table[:, 1], table[:, 2], rule, steps=steps).shares
        by_step = {int(step): float(shares[steps == step].sum()) for step in steps}
        best = max(by_step, key=lambda step: (by_step[step], step))
        return best if by_step[best] > 0 else -1

    def _hide(self, time_ns: int) -> None:
        if self._step >= 0:
            # Two reports of the screen may cross on their way.
            earliest_ns = self._intervals[-1][2] if self._intervals else 0
            shown_ns = max(self._since_ns, earliest_ns)
            self._intervals.append((self._step, shown_ns, max(shown_ns, time_ns)))
