"""Credit assignment: which steps a press is about (section 3.3, Fig. 4).

A press at time t is an answer to something that was on screen a while before. With a density p of that delay,
a step that was on screen during [a, b] gets the integral of p from t - b to t - a. Two rules that use no
density stand beside it: all credit to the step on screen, or to the one before.
"""

import math
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from core.feedback.delays import (
    HORIZON_MASS,
    CurrentStep,
    Delay,
    DelayDensity,
    Density,
    GammaDelay,
    PerValueDelay,
    PressRule,
    PreviousStep,
    UniformDelay,
    describe,
    parse_delay,
)
from core.numerics.clock import NS_PER_S

__all__ = [
    "HORIZON_MASS",
    "STILL_SHOWN_NS",
    "Credit",
    "CurrentStep",
    "Delay",
    "DelayDensity",
    "Density",
    "GammaDelay",
    "PerValueDelay",
    "PreviousStep",
    "UniformDelay",
    "credit",
    "describe",
    "parse_delay",
]

STILL_SHOWN_NS = (1 << 63) - 1
"""In place of `hidden_ns` for a step that is still on screen."""


@dataclass(frozen=True, slots=True, eq=False)
class Credit:
    """How one press is shared out. `shares`, `before_first` and `in_gaps` sum to 1."""

    shares: NDArray[np.float64]
    """Share of each interval, >= 0, shape (n,)."""
    before_first: float
    """Share that falls before the first interval."""
    in_gaps: float
    """Share that falls between intervals (pauses, ends of episodes), or between the last one and the
    press."""


def credit(
    press_ns: int,
    shown_ns: NDArray[np.int64],
    hidden_ns: NDArray[np.int64],
    delay: PressRule | DelayDensity,
    *,
    steps: NDArray[np.int64] | None = None,
) -> Credit:
    """Share out a press among the intervals in which steps were on screen.

    Args:
        press_ns: time of the press.
        shown_ns: when each interval began, shape (n,), ascending. Intervals after the press get nothing.
        hidden_ns: when each ended, shape (n,), not before it began nor after the next one began;
            `STILL_SHOWN_NS` for the last one if it has not ended.
        delay: density of the delay, or a rule: of this press, where each value has its own
            (`core.feedback.delays.rule_for`). Any object with `cdf` and `horizon_s` is a density.
        steps: number of the step shown in each interval, shape (n,), never falling; a step that was covered
            for a while has several intervals. Each interval is a step of its own when left out.

    Returns:
        The shares; what a density leaves beyond its horizon (less than 1e-6) is taken to lie at the horizon.
    """
    if shown_ns.shape != hidden_ns.shape or shown_ns.ndim != 1:
        raise ValueError(f"need one end per beginning, got shapes {shown_ns.shape} and {hidden_ns.shape}")
    if np.any(hidden_ns < shown_ns) or np.any(shown_ns[1:] < hidden_ns[:-1]):
        raise ValueError(
            f"intervals on screen must follow each other: {list(zip(shown_ns, hidden_ns, strict=True))}"
        )
    match delay:
        case CurrentStep():
            return _credit_current(press_ns, shown_ns, hidden_ns)
        case PreviousStep():
            return _credit_previous(press_ns, shown_ns, hidden_ns, steps)
        case density:
            return _credit_by_density(press_ns, shown_ns, hidden_ns, density)


def _mass_up_to(delay_ns: NDArray[np.int64], density: DelayDensity) -> NDArray[np.float64]:
    """Mass of delays shorter than `delay_ns`; all of it from the horizon on."""
    delay_s = delay_ns / NS_PER_S
    return np.where(delay_s >= density.horizon_s, 1.0, density.cdf(delay_s))


def _credit_by_density(
    press_ns: int, shown_ns: NDArray[np.int64], hidden_ns: NDArray[np.int64], density: DelayDensity
) -> Credit:
    if len(shown_ns) == 0:
        return Credit(np.zeros(0), before_first=1.0, in_gaps=0.0)
    # Ages at the press; what comes after the press has age 0, and no mass is younger than that.
    mass_to_shown = _mass_up_to(np.maximum(press_ns - shown_ns, 0), density)
    mass_to_hidden = _mass_up_to(press_ns - np.minimum(hidden_ns, press_ns), density)
    shares = np.maximum(mass_to_shown - mass_to_hidden, 0.0)
    gaps = mass_to_hidden[:-1] - mass_to_shown[1:]
    return Credit(
        shares,
        before_first=float(1.0 - mass_to_shown[0]),
        in_gaps=math.fsum([*gaps.tolist(), float(mass_to_hidden[-1])]),
    )


def _credit_current(press_ns: int, shown_ns: NDArray[np.int64], hidden_ns: NDArray[np.int64]) -> Credit:
    shares = ((shown_ns <= press_ns) & (press_ns < hidden_ns)).astype(np.float64)
    return _with_one_outside(shares, seen_anything=bool(np.any(shown_ns <= press_ns)))


def _credit_previous(
    press_ns: int,
    shown_ns: NDArray[np.int64],
    hidden_ns: NDArray[np.int64],
    steps: NDArray[np.int64] | None,
) -> Credit:
    steps = np.arange(len(shown_ns)) if steps is None else steps
    shares = np.zeros(len(shown_ns))
    last = int(np.searchsorted(shown_ns, press_ns, side="right")) - 1
    if last >= 0 and press_ns < hidden_ns[last]:
        # The step on screen may have been shown before, too: look before its first interval.
        last = int(np.searchsorted(steps, steps[last], side="left")) - 1
    if last >= 0:
        shares[last] = 1.0
    return _with_one_outside(shares, seen_anything=False)


def _with_one_outside(shares: NDArray[np.float64], *, seen_anything: bool) -> Credit:
    """Complete a rule's credit: a press that hits no step fell into a gap, or came before the first step."""
    outside = 0.0 if shares.any() else 1.0
    return Credit(
        shares,
        before_first=0.0 if seen_anything else outside,
        in_gaps=outside if seen_anything else 0.0,
    )
