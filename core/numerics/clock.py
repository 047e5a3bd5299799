"""Time as integer nanoseconds of one monotonic clock; wall time once per session, for humans."""

import time
from datetime import UTC, datetime
from typing import Protocol

NS_PER_S = 1_000_000_000
NS_PER_MS = 1_000_000
S_PER_HOUR = 3600.0
LONGEST_NS = 1 << 62
"""Longest time that is taken from a file, nanoseconds: 146 years."""


class Clock(Protocol):
    """Something that tells the time in nanoseconds from an arbitrary zero."""

    def now_ns(self) -> int:
        """Return the time, never earlier than the last one returned."""
        ...


class MonotonicClock:
    """The machine's monotonic clock: shared by all processes of one machine, and by Textual's key times."""

    def now_ns(self) -> int:
        """Return nanoseconds of CLOCK_MONOTONIC."""
        return time.monotonic_ns()


class ManualClock:
    """A clock that moves only when told to: for simulated sessions and tests."""

    def __init__(self, start_ns: int = 0) -> None:
        self._now_ns = start_ns

    def now_ns(self) -> int:
        """Return the time last set."""
        return self._now_ns

    def advance_ns(self, duration_ns: int) -> None:
        """Move forward by `duration_ns` >= 0."""
        if duration_ns < 0:
            raise ValueError(f"a monotonic clock cannot go back by {-duration_ns} ns")
        self._now_ns += duration_ns

    def advance_to_ns(self, time_ns: int) -> None:
        """Move forward to `time_ns`; stay where a later time has been reached already."""
        self._now_ns = max(self._now_ns, time_ns)


def seconds(duration_ns: int) -> float:
    """Return a duration in seconds."""
    return duration_ns / NS_PER_S


def wall_time_utc() -> str:
    """Return the date and time in UTC, ISO 8601 with seconds: for a recording's header only."""
    return datetime.now(UTC).isoformat(timespec="seconds")


def suspended_ns() -> int:
    """Return how long this machine has been suspended since it started, in nanoseconds; 0 where that is not
    known.

    Linux's and macOS's monotonic clocks, as Python reads them, stand still meanwhile; another clock does not.
    """
    monotonic, on_linux, on_macos = (
        getattr(time, name, None) for name in ("CLOCK_MONOTONIC", "CLOCK_BOOTTIME", "CLOCK_UPTIME_RAW")
    )
    if monotonic is not None and on_linux is not None:
        return time.clock_gettime_ns(on_linux) - time.clock_gettime_ns(monotonic)
    if monotonic is not None and on_macos is not None:
        return time.clock_gettime_ns(monotonic) - time.clock_gettime_ns(on_macos)
    return 0
