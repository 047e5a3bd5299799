"""Notice that the program stood still: the machine slept, or the process was stopped."""

from collections.abc import Callable

from core.events import TimeGap
from core.numerics.clock import NS_PER_S, Clock, suspended_ns

LONGEST_NS = NS_PER_S
"""Longer without being able to draw a frame is a gap."""
LOOKS_PER_S = 5
"""How often the time is looked at."""


class GapWatch:
    """Compares the time with that of the last look. Made when a session begins; looked at all through it."""

    def __init__(self, clock: Clock, suspended: Callable[[], int] = suspended_ns) -> None:
        """Take the first look.

        Args:
            clock: of the session's events.
            suspended: how long the machine has been suspended in all, ns.
        """
        self._clock = clock
        self._suspended = suspended
        self._last_ns = clock.now_ns()
        self._suspended_ns = suspended()

    def look(self) -> TimeGap | None:
        """Return the gap that ends now; None where there is none."""
        last_ns, suspended_before_ns = self._last_ns, self._suspended_ns
        self._last_ns, self._suspended_ns = self._clock.now_ns(), self._suspended()
        asleep_ns = self._suspended_ns - suspended_before_ns
        # Two clocks are not read in the same moment: microseconds are not a sleep.
        asleep_ns = asleep_ns if asleep_ns > NS_PER_S // 100 else 0
        if self._last_ns - last_ns + asleep_ns <= LONGEST_NS:
            return None
        return TimeGap(last_ns=last_ns, time_ns=self._last_ns, suspended_ns=asleep_ns)


def length_s(gap: TimeGap) -> float:
    """Return how long a gap was, in seconds of the wall."""
    return (gap.time_ns - gap.last_ns + gap.suspended_ns) / NS_PER_S
