"""Credit of a press in compiled code: `core.feedback.credit` for play that does not stop at a press.

The shares agree with those of `credit` to rounding (the incomplete gamma function is our own here).
"""

import math
from typing import Final, NamedTuple, assert_never

from core.feedback.delays import (
    CurrentStep,
    Delay,
    GammaDelay,
    PerValueDelay,
    PreviousStep,
    UniformDelay,
)
from core.numerics.arrays import Floats, Ints
from core.numerics.clock import NS_PER_S
from core.numerics.compiled import kernel

GAMMA: Final = 0
UNIFORM: Final = 1
PREVIOUS: Final = 2
CURRENT: Final = 3
_TERMS = 10_000
"""More than any sum below needs to converge."""
_SMALLEST = 1e-300


class CreditRule(NamedTuple):
    """A credit rule as kernels see it."""

    kind: int
    """GAMMA, UNIFORM, PREVIOUS or CURRENT."""
    a: float
    """Gamma: shape. Uniform: shortest delay, seconds."""
    b: float
    """Gamma: scale, seconds. Uniform: longest delay, seconds."""
    offset_s: float
    log_gamma: float
    """Logarithm of the gamma function of the shape."""
    horizon_s: float
    """Delay at and beyond which a density counts as passed; 0 for the rules without a density."""


def credit_rule(delay: Delay) -> CreditRule:
    """Return the kernels' form of a density or rule.

    Raises:
        ValueError: each value of a press has a density of its own: compiled play knows one for all.
    """
    match delay:
        case GammaDelay(shape=shape, scale_s=scale_s, offset_s=offset_s):
            log_gamma = math.lgamma(shape)
            return CreditRule(
                GAMMA, float(shape), float(scale_s), float(offset_s), log_gamma, delay.horizon_s
            )
        case UniformDelay(low_s=low_s, high_s=high_s):
            return CreditRule(UNIFORM, float(low_s), float(high_s), 0.0, 0.0, float(delay.horizon_s))
        case PreviousStep():
            return CreditRule(PREVIOUS, 0.0, 0.0, 0.0, 0.0, 0.0)
        case CurrentStep():
            return CreditRule(CURRENT, 0.0, 0.0, 0.0, 0.0, 0.0)
        case PerValueDelay():
            raise ValueError(
                "compiled play of experiments has one density for all presses: play a session for a "
                "per-value delay"
            )
        case _:
            assert_never(delay)


@kernel
def gamma_mass(shape: float, log_gamma: float, x: float) -> float:
    """Return P(shape, x), the regularised lower incomplete gamma function, to about 1e-14.

    Args:
        shape: > 0.
        log_gamma: logarithm of the gamma function of `shape`.
        x: where.
    """
    if x <= 0.0:
        return 0.0
    front = math.exp(shape * math.log(x) - x - log_gamma)
    if x < shape + 1.0:  # power series
        term = 1.0 / shape
        total = term
        for k in range(1, _TERMS):
            term *= x / (shape + k)
            total += term
            if term < total * 1e-17:
                break
        return min(front * total, 1.0)
    # Continued fraction of the upper function, by Lentz's method.
    b = x + 1.0 - shape
    c, d = 1.0 / _SMALLEST, 1.0 / b
    fraction = d
    for k in range(1, _TERMS):
        step = -k * (k - shape)
        b += 2.0
        d = step * d + b
        d = 1.0 / (d if abs(d) > _SMALLEST else _SMALLEST)
        c = b + step / c
        c = c if abs(c) > _SMALLEST else _SMALLEST
        fraction *= c * d
        if abs(c * d - 1.0) < 1e-16:
            break
    return max(1.0 - front * fraction, 0.0)


@kernel
def mass_up_to(rule: CreditRule, delay_ns: int) -> float:
    """Return the mass of delays shorter than `delay_ns` >= 0; all of it from the horizon on."""
    delay_s = delay_ns / NS_PER_S
    if delay_s >= rule.horizon_s:
        return 1.0
    if rule.kind == GAMMA:
        return gamma_mass(rule.a, rule.log_gamma, (delay_s - rule.offset_s) / rule.b)
    return min(max((delay_s - rule.a) / (rule.b - rule.a), 0.0), 1.0)


@kernel
def share_out(
    rule: CreditRule, press_ns: int, shown_ns: Ints, hidden_ns: Ints, n_steps: int, shares: Floats
) -> tuple[int, float, float]:
    """Share out a press among the last steps of a session; each was on screen once.

    Args:
        rule: density or rule.
        press_ns: time of the press, when the last step had been shown already.
        shown_ns: when each step came on screen, in a ring: step s at place s % n, shape (n,), n >= 2. It has
            to reach back as far as the rule.
        hidden_ns: when each went off, likewise; far in the future for one that has not.
        n_steps: steps so far.
        shares: out, by the same places: share of each step from the first one returned.

    Returns:
        The first step that can have a share (`n_steps` if none can), and the shares before the first step
        and in gaps, as in `core.feedback.credit.Credit`.
    """
    if n_steps == 0:
        return 0, 1.0, 0.0
    if rule.kind >= PREVIOUS:
        return _share_out_by_rule(rule, press_ns, shown_ns, hidden_ns, n_steps, shares)
    n = len(shown_ns)
    oldest = max(0, n_steps - n)
    in_gaps, mass_after = 0.0, 0.0  # of what comes after the step at hand
    for step in range(n_steps - 1, oldest - 1, -1):
        place = step % n
        mass_to_hidden = mass_up_to(rule, press_ns - min(hidden_ns[place], press_ns))
        mass_to_shown = mass_up_to(rule, max(press_ns - shown_ns[place], 0))
        in_gaps += mass_to_hidden - mass_after
        shares[place] = max(mass_to_shown - mass_to_hidden, 0.0)
        mass_after = mass_to_shown
        if mass_to_shown >= 1.0:
            return step, 0.0, in_gaps
    return oldest, 1.0 - mass_after, in_gaps


@kernel
def _share_out_by_rule(
    rule: CreditRule, press_ns: int, shown_ns: Ints, hidden_ns: Ints, n_steps: int, shares: Floats
) -> tuple[int, float, float]:
    step = n_steps - 1
    on_screen = press_ns < hidden_ns[step % len(shown_ns)]
    if rule.kind == CURRENT and not on_screen:
        return n_steps, 0.0, 1.0
    if rule.kind == PREVIOUS and on_screen:
        step -= 1
    if step < 0:
        return n_steps, 1.0, 0.0
    shares[step % len(shown_ns)] = 1.0
    if step + 1 < n_steps:
        shares[(step + 1) % len(shown_ns)] = 0.0
    return step, 0.0, 0.0
