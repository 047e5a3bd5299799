"""How one press is shared out among the steps on screen before it, under the recorded rule and any other."""

from dataclasses import dataclass
from typing import Final

import numpy as np
from numpy.typing import NDArray

from core.feedback.credit import (
    CurrentStep,
    Delay,
    GammaDelay,
    PreviousStep,
    UniformDelay,
    credit,
    describe,
)
from core.feedback.delays import PressRule, rule_for
from core.numerics.clock import NS_PER_S
from studies.session_view.session import Press, SessionView

PAPER: Final = GammaDelay()
"""gamma(2.5, 0.3 s), Fig. 4."""
UNIFORM: Final = UniformDelay()
"""TAMER's window."""
LEAST_S: Final = 2.0
MOST_S: Final = 12.0
"""How long a stretch before a press is drawn, at least and at most."""


@dataclass(frozen=True, slots=True)
class OnStrip:
    """One stretch of time in which a step was on screen."""

    step: int
    begin_s: float
    """Seconds before the press, >= `end_s`."""
    end_s: float
    """0 where it was still on screen."""
    share: float
    """Credit share of the step, over all its stretches, in [0, 1]."""


@dataclass(frozen=True, slots=True, eq=False)
class CreditStrip:
    """What is drawn of one press."""

    rule: str
    """In words."""
    stretches: tuple[OnStrip, ...]
    """Oldest first."""
    shares: dict[int, float]
    """Credit share by number of the step."""
    outside: float
    """What fell on no step: before the first one, into pauses and gaps, or too late."""
    span_s: float
    """Seconds before the press that are drawn."""
    delay: PressRule
    """Of this press: of a rule with a density per value, that of its value."""
    merged_into: int | None = None
    """The press that opened the burst of which this one is part."""

    def density(self, n: int) -> NDArray[np.float64]:
        """Return the delay density in `n` cells from `span_s` before the press to the press, as shares of its
        top.

        Zeros for a rule without a density.
        """
        if isinstance(self.delay, PreviousStep | CurrentStep):
            return np.zeros(n)
        edges = np.linspace(self.span_s, 0.0, n + 1)
        mass = self.delay.cdf(edges[:-1]) - self.delay.cdf(edges[1:])
        return np.asarray(mass / max(float(mass.max()), 1e-300))


def strip_of(session: SessionView, press: Press, rule: Delay, *, recorded: bool = False) -> CreditStrip:
    """Return how a press is credited under a rule.

    Args:
        session: of the press.
        press: any press that means good, bad or neither.
        rule: by which it is credited.
        recorded: take the shares that the session itself gave, where it gave any; `rule` is then the rule of
            the session and says which density is drawn.
    """
    words, delay = describe(rule), rule_for(rule, press.value)
    reach_s = MOST_S if isinstance(delay, PreviousStep | CurrentStep) else max(MOST_S, delay.horizon_s)
    shown, hidden, steps = session.on_screen(press.time_ns - round(reach_s * NS_PER_S), press.time_ns + 1)
    given = session.credit_of(press.number) if recorded else None
    merged = None
    if given is not None:
        shares = dict(zip(given.steps, given.shares, strict=True))
        outside, merged = given.before_first + given.in_gaps + given.too_late, given.merged_into
    else:
        shares, outside = _shares(session, press, delay, (shown, hidden, steps))
    stretches = tuple(
        OnStrip(
            int(step),
            (press.time_ns - int(begin)) / NS_PER_S,
            max(0.0, (press.time_ns - min(int(end), press.time_ns)) / NS_PER_S),
            shares.get(int(step), 0.0),
        )
        for begin, end, step in zip(shown, hidden, steps, strict=True)
        if begin <= press.time_ns
    )
    return CreditStrip(words, stretches, shares, outside, _span(stretches, delay), delay, merged)


def _shares(
    session: SessionView,
    press: Press,
    delay: PressRule,
    intervals: tuple[NDArray[np.int64], NDArray[np.int64], NDArray[np.int64]],
) -> tuple[dict[int, float], float]:
    shown, hidden, steps = intervals
    result = credit(press.time_ns, shown, hidden, delay, steps=steps)
    gap_ns = session.last_gap_before(press.time_ns)
    shares: dict[int, float] = {}
    outside = result.before_first + result.in_gaps
    for begin, step, share in zip(shown.tolist(), steps.tolist(), result.shares.tolist(), strict=True):
        if begin <= gap_ns:
            outside += share
        elif share > 0:
            shares[step] = shares.get(step, 0.0) + share
    return shares, outside


def _span(stretches: tuple[OnStrip, ...], delay: PressRule) -> float:
    """Return how much time is drawn: the density's mass but for a hundredth, and every step with credit."""
    needed = [stretch.begin_s for stretch in stretches if stretch.share >= 0.01]
    span = max([LEAST_S, *needed])
    if not isinstance(delay, PreviousStep | CurrentStep):
        tail = np.linspace(0.0, MOST_S, 241)
        span = max(span, float(tail[int(np.searchsorted(delay.cdf(tail), 0.99).clip(max=240))]))
    return min(span * 1.05, MOST_S)
