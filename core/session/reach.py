"""How many presses reach the step they were meant for: a session's pace against a participant's delay.

Model. Step i is on screen from a_i to b_i, and the next step follows at once (b_i = a_{i+1}). A participant
who judges step i makes up their mind from j_i = a_i + `judged_after_ns` on (Tetris: the piece has landed, j_i
= b_i; Keepaway: the first cycle of the option is over) and presses at j_i + d, where d has the distribution
function F. The credit rule gives step i this fraction of the press, on average over d:

* previous step: F(b_{i+1} - j_i) - F(b_i - j_i), the chance that step i + 1 is on screen at the press.
* step on screen: F(b_i - j_i).
* a density with distribution function G: E[G(j_i + d - a_i) - G(j_i + d - b_i)] (section 3.3, Fig. 4).

The fraction of a session is the mean over its steps, each weighted by how often it is judged
(`Watched.attention`). The last step of an episode counts as if another one followed. A press that is never
made is not counted.
"""

import math
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Protocol as Interface

import numpy as np
from numpy.typing import ArrayLike, NDArray

from core.feedback.delays import (
    CurrentStep,
    Delay,
    Density,
    GammaDelay,
    PerValueDelay,
    PressRule,
    PreviousStep,
)
from core.feedback.viewing import Watched
from core.numerics.clock import NS_PER_S
from core.session.protocol import ENOUGH_REACH, Protocol

DELAY_STEP_S = 0.002
"""Resolution of the average over delays."""


class DelayDistribution(Interface):
    """How long a participant takes from judging to pressing: a density (`GammaDelay`, ...) or measured
    delays.
    """

    def cdf(self, delay_s: ArrayLike) -> NDArray[np.float64]:
        """Return the probability of a delay of at most `delay_s` seconds, element by element."""
        ...

    @property
    def horizon_s(self) -> float:
        """Delay in seconds beyond which nothing that matters is left, > 0."""
        ...


@dataclass(frozen=True, slots=True)
class Reach:
    """How well a session's pace suits a participant."""

    fraction: float
    """Share of a press that reaches the step it was meant for, in [0, 1]."""
    step_s: float
    """Mean time on screen of a step, in seconds, weighted by how often it is judged."""
    delay: DelayDistribution | PerValueDelay
    """The participant's delay that was assumed."""

    @property
    def enough(self) -> bool:
        """Whether the fraction is at least `ENOUGH_REACH`."""
        return self.fraction >= ENOUGH_REACH


def reach_of(protocol: Protocol, delay: DelayDistribution | None = None) -> Reach:
    """Return the fraction of a press that reaches its step in sessions of a protocol.

    The steps are those of some episodes of the protocol's game (`core.registry.Game.steps_on_screen`), at the
    protocol's pace. The first call for Keepaway may compile kernels.

    Args:
        protocol: with the game, its pace and the credit rule.
        delay: of the participant; left out, the delay in force: the density by which the protocol gives
            credit, or the paper's gamma(2.5, 0.3) where it gives credit by a rule that is no density. Where
            each value has a density, the mean over the values. Of several people with delays of their own,
            the one whose presses reach least.
    """
    from core.registry import game_of  # here, not above: games bring compiled code

    steps = game_of(protocol).steps_on_screen(protocol)
    rules = dict.fromkeys(credit.delay for credit in protocol.credit_of_participants)
    found = [_reach(steps, rule, assumed_delay(rule) if delay is None else delay) for rule in rules]
    return min(found, key=lambda reach: reach.fraction)


def _reach(steps: Sequence[Watched], rule: Delay, delay: DelayDistribution | PerValueDelay) -> Reach:
    """Return the share under one credit rule; of a density per value, the mean over the values."""
    each: list[PressRule] = [rule] if not isinstance(rule, PerValueDelay) else list(rule.densities)
    if isinstance(rule, PerValueDelay) and rule.values:
        each.pop()  # the density of values that are not listed
    fractions = []
    for one in each:
        if isinstance(delay, PerValueDelay):
            assert isinstance(one, Density), "a delay per value is that of such a rule"
            fractions.append(fraction_reached(steps, one, one))
        else:
            fractions.append(fraction_reached(steps, one, delay))
    return Reach(float(np.mean(fractions)), mean_time_s(steps), delay)


def delay_in_force(protocol: Protocol) -> Density | PerValueDelay:
    """Return the participant's delay as a protocol assumes it: its credit density, or the paper's."""
    return assumed_delay(protocol.agent.credit.delay)


def assumed_delay(rule: Delay) -> Density | PerValueDelay:
    """Return the delay that a credit rule assumes: its density, or the paper's where it has none."""
    return GammaDelay() if isinstance(rule, PreviousStep | CurrentStep) else rule


def fraction_reached(steps: Sequence[Watched], rule: PressRule, delay: DelayDistribution) -> float:
    """Return the fraction of a press that reaches the step it was meant for, in [0, 1] (model: see the
    module).

    Args:
        steps: of episodes, in order; those with no time on screen are left out.
        rule: by which presses are credited.
        delay: from the moment in which a step is judged to the press.

    Raises:
        ValueError: fewer than two steps are on screen, or none of them is ever judged.
    """
    shown = _on_screen(steps)
    duration_s, judged_s, weights = shown[:, 0], shown[:, 1], shown[:, 2]
    left_s = duration_s - judged_s
    following_s = np.append(duration_s[1:], duration_s.mean())
    match rule:
        case CurrentStep():
            fractions = _probability(delay, left_s)
        case PreviousStep():
            fractions = _probability(delay, left_s + following_s) - _probability(delay, left_s)
        case _:
            fractions = _by_density(duration_s, judged_s, rule, delay)
    return float(np.average(fractions, weights=weights))


def mean_time_s(steps: Sequence[Watched]) -> float:
    """Return the mean time on screen of a step in seconds, weighted by how often it is judged."""
    shown = _on_screen(steps)
    return float(np.average(shown[:, 0], weights=shown[:, 2]))


def _on_screen(steps: Sequence[Watched]) -> NDArray[np.float64]:
    """Return duration and time of judging in seconds, and weight, of each step on screen, shape (n, 3)."""
    shown = np.array(
        [
            (step.duration_ns / NS_PER_S, step.judged_after_ns / NS_PER_S, step.attention)
            for step in steps
            if step.duration_ns > 0
        ]
    ).reshape(-1, 3)
    if len(shown) < 2 or not shown[:, 2].sum() > 0:
        raise ValueError(f"need two steps on screen, and one that is judged; got {len(shown)} on screen")
    return shown


def _probability(delay: DelayDistribution, delay_s: NDArray[np.float64]) -> NDArray[np.float64]:
    """Return the probability of a delay of at most `delay_s`, 0 for negative ones."""
    return np.where(delay_s < 0, 0.0, delay.cdf(np.maximum(delay_s, 0.0)))


def _by_density(
    duration_s: NDArray[np.float64], judged_s: NDArray[np.float64], density: Density, delay: DelayDistribution
) -> NDArray[np.float64]:
    """Return each step's fraction under a credit density, shape (n,); the delays are averaged in cells of 2
    ms.
    """
    edges_s = np.linspace(0.0, delay.horizon_s, math.ceil(delay.horizon_s / DELAY_STEP_S) + 1)
    masses = np.diff(delay.cdf(edges_s))
    delays_s = (edges_s[:-1] + edges_s[1:]) / 2
    since_shown_s = judged_s[:, None] + delays_s
    fractions = _probability(density, since_shown_s) - _probability(
        density, since_shown_s - duration_s[:, None]
    )
    return np.asarray(fractions @ masses / masses.sum(), dtype=np.float64)
