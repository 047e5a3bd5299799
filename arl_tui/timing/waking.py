"""How late this machine wakes a program that sleeps: no program on it can do better.

A virtual machine that shares its processors may be away for milliseconds without any load of its own to show
for it.
"""

import time

from arl_tui.timing.result import Summary

SLEEP_NS = 5_000_000
SLEEPS = 100
QUIET_P95_MS = 0.5
"""A machine whose plain sleeps end later than this in 1 of 20 cases is not quiet, whatever its load."""


def lateness_ms(sleeps: int = SLEEPS) -> list[float]:
    """Return by how many milliseconds each of some sleeps of 5 ms ended late, >= 0."""
    late = []
    for _ in range(sleeps):
        began_ns = time.monotonic_ns()
        time.sleep(SLEEP_NS / 1e9)
        late.append((time.monotonic_ns() - began_ns - SLEEP_NS) / 1e6)
    return late


def waking_line(waking: Summary) -> str:
    """Return the sentence about the machine."""
    told = (
        f"This machine: a plain sleep of {SLEEP_NS / 1e6:g} ms ended {waking.median:.2f} ms late (median; "
        f"p95 {waking.p95:.2f}, p99 {waking.p99:.2f})."
    )
    if waking.p95 <= QUIET_P95_MS:
        return told
    return (
        f"{told} More than {QUIET_P95_MS:g} ms in 1 of 20 cases is not a quiet machine: bias, sd and tails "
        "above are its, and no program on it can have better ones."
    )
