"""What looks wrong about a set of reaction times without making it unusable: said, never repaired."""

import re
from collections.abc import Iterator, Mapping, Sequence

import numpy as np
from numpy.typing import NDArray

from studies.reaction_time.sample import Sample

FEWEST_TRIALS = 10
"""Two samples of fewer trials may agree by chance (times are often whole milliseconds)."""
FEWEST_FOR_STEPS = 20
"""Fewer times may stand on a grid by chance."""
SAME_STEP = 0.9
"""Least mean resultant length of the times' phases in a step: 1 where all are whole steps apart. Times on a
grid of 16.67 ms have 0.99 in whole milliseconds, and 0.93 with a jitter of 1 ms."""
STEPS_S = {
    0.1: "tenths of a second",
    0.05: "50 ms",
    0.04: "40 ms",
    1 / 30: "frames at 30 Hz",
    0.02: "frames at 50 Hz",
    1 / 60: "frames at 60 Hz",
    1 / 64: "ticks of the Windows clock",
    1 / 72: "frames at 72 Hz",
    1 / 75: "frames at 75 Hz",
    1 / 85: "frames at 85 Hz",
    1 / 90: "frames at 90 Hz",
    0.01: "hundredths of a second",
    1 / 120: "frames at 120 Hz",
    0.008: "polls of a USB keyboard at 125 Hz",
    1 / 144: "frames at 144 Hz",
}
"""Steps in seconds that displays, keyboards and rounding make, the longest first."""
PILE = 3
PILE_SHARE = 0.02
_SHOWN = 4


def alike_names(names: Sequence[str]) -> Iterator[str]:
    """Yield a sentence for codes that differ in case, spaces, punctuation or leading zeros only."""
    groups: dict[str, list[str]] = {}
    for name in names:
        key = re.sub(r"(?<!\d)0+(?=\d)|\.0$", "", name.lower())
        groups.setdefault(re.sub(r"[\W_]+", "", key), []).append(name)
    for group in groups.values():
        if len(group) > 1:
            yield f"the participants {' and '.join(map(repr, group))} may be one: they are fitted apart"


def copied_times(samples: Mapping[str, Sample]) -> Iterator[str]:
    """Yield a sentence for participants with the same times, or whose times all come in pairs."""
    first: dict[bytes, str] = {}
    for name, sample in samples.items():
        times = sample.observed_s
        if times.size < FEWEST_TRIALS:
            continue
        other = first.setdefault(times.tobytes(), name)
        if other != name:
            yield f"{other!r} and {name!r} have the same {times.size} times: is it one participant twice?"
        if times.size % 2 == 0 and (times[::2] == times[1::2]).all():
            yield f"each of the times of {name!r} is there twice: was a file read, or stored, twice?"


def step_of(times_s: NDArray[np.float64]) -> float | None:
    """Return the longest step of `STEPS_S` of which all times are whole multiples apart, or None.

    Args:
        times_s: reaction times, shape (n,), seconds. Fewer than `FEWEST_FOR_STEPS`, or all within a few
    steps: None.
    """
    if times_s.size < FEWEST_FOR_STEPS:
        return None
    spread = float(times_s.std())
    for step_s in sorted(STEPS_S, reverse=True):
        phases = np.exp(2j * np.pi * times_s / step_s)
        # A smooth density much wider than a step has a resultant near 0.
        if spread > step_s and abs(phases.mean()) >= SAME_STEP:
            return step_s
    return None


def steps_of_time(samples: Mapping[str, Sample]) -> Iterator[str]:
    """Yield a sentence for participants whose times stand in steps, with what that does to a fit."""
    found: dict[float, list[str]] = {}
    for name, sample in samples.items():
        step_s = step_of(sample.observed_s)
        if step_s is not None:
            found.setdefault(step_s, []).append(name)
    for step_s, names in found.items():
        ms = 1000.0 * step_s
        yield (
            f"the times of {_some(names)} stand in steps of {ms:.4g} ms ({STEPS_S[step_s]}): each is known to"
            f" a step only. If presses were noticed at the end of a step, means and offsets are {ms / 2:.2g}"
            " ms too long; shapes change little; with many trials the goodness-of-fit test rejects every"
            " density (docs/trusting-a-fit.md)"
        )


def piles_at_the_maximum(samples: Mapping[str, Sample]) -> Iterator[str]:
    """Yield a sentence for participants whose longest time comes so often that it is a time-out."""
    found: dict[float, list[str]] = {}
    counts: dict[float, int] = {}
    for name, sample in samples.items():
        values, n = np.unique(sample.observed_s, return_counts=True)
        usual = int(n[:-1].max(initial=0))
        if n[-1] >= max(PILE, PILE_SHARE * sample.observed_s.size) and n[-1] > usual and values.size > 1:
            longest = float(values[-1])
            found.setdefault(longest, []).append(name)
            counts[longest] = counts.get(longest, 0) + int(n[-1])
    for longest, names in found.items():
        yield (
            f"{counts[longest]} times of {_some(names)} are exactly {longest:g} s, the longest of all: trials"
            f" that timed out, stored as times? --waited {longest:g} counts them as time-outs"
        )


def _some(names: Sequence[str]) -> str:
    shown = ", ".join(map(repr, names[:_SHOWN]))
    return f"{shown} and {len(names) - _SHOWN} more" if len(names) > _SHOWN else shown
