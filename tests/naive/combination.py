"""What the combination kernels mean, in plain Python: slow, obvious, bit-equal."""

import math
from collections.abc import Sequence


def allowed_actions(ruled_out: Sequence[bool]) -> list[int]:
    return [action for action, out in enumerate(ruled_out) if not out]


def first_best(scores: dict[int, float]) -> int:
    """The action with the highest score; the lowest number wins ties; 0 without any action."""
    return min(scores, key=lambda action: (-scores[action], action), default=0)


def mean_and_sd(values: list[float]) -> tuple[float, float]:
    if not values or min(values) == max(values):
        return 0.0, 0.0
    total = 0.0
    for value in values:
        total += value
    mean = total / len(values)
    squares = 0.0
    for value in values:
        squares += (value - mean) * (value - mean)
    return mean, math.sqrt(squares / len(values))


def linear_choice(
    env: Sequence[float],
    human: Sequence[float],
    ruled_out: Sequence[bool],
    w_r: float,
    w_h: float,
    *,
    standardise: bool = True,
) -> int:
    """Eq. 3 over standardised values, or over raw ones."""
    actions = allowed_actions(ruled_out)
    if w_h == 0:
        return first_best({a: float(env[a]) for a in actions})
    if w_r == 0:
        return first_best({a: math.copysign(1, w_h) * float(human[a]) for a in actions})
    centre_r, gain_r, centre_h, gain_h = 0.0, w_r, 0.0, w_h
    if standardise:
        centre_r, sd_r = mean_and_sd([float(env[a]) for a in actions])
        centre_h, sd_h = mean_and_sd([float(human[a]) for a in actions])
        gain_r = w_r / sd_r if sd_r > 0 else 0.0
        gain_h = w_h / sd_h if sd_h > 0 else 0.0
    return first_best(
        {a: (float(env[a]) - centre_r) * gain_r + (float(human[a]) - centre_h) * gain_h for a in actions}
    )


def exponential_choice(
    env: Sequence[float], human: Sequence[float], ruled_out: Sequence[bool], w_r: float, w_h: float
) -> int:
    """The exponential scheme of section 3.1 with our conventions for negative H and R."""
    actions = allowed_actions(ruled_out)
    if not actions:
        return 0
    if w_h == 0:
        return first_best({a: float(env[a]) for a in actions})
    low_r = min(float(env[a]) for a in actions)
    low_h = min(float(human[a]) for a in actions)
    range_h = max(float(human[a]) for a in actions) - low_h
    scores = {}
    for a in actions:
        share = (float(human[a]) - low_h) / range_h if range_h > 0 else 0.0
        if w_h < 0:
            share = 1.0 - share
        scores[a] = w_r * (float(env[a]) - low_r) * (1.0 + share ** abs(w_h))
    return first_best(scores)


def advised_choice(
    env: Sequence[float],
    human: Sequence[float],
    ruled_out: Sequence[bool],
    w_r: float,
    w_h: float,
    *,
    taken: int,
) -> bool:
    """Whether `taken` is a best action of Advise, in logarithms: the same but for rounding."""
    actions = allowed_actions(ruled_out)
    if not actions or w_h == 0:
        return taken == first_best({a: float(env[a]) for a in actions})
    mean_r, sd_r = mean_and_sd([float(env[a]) for a in actions])
    mean_h, sd_h = mean_and_sd([float(human[a]) for a in actions])
    scores = {}
    for a in actions:
        r = (float(env[a]) - mean_r) / sd_r if sd_r > 0 else 0.0
        advice = w_h * (float(human[a]) - mean_h) / sd_h if sd_h > 0 else 0.0
        scores[a] = w_r * r + min(advice, 0.0) - math.log1p(math.exp(-abs(advice)))
    return taken in actions and scores[taken] >= max(scores.values()) - 1e-9
