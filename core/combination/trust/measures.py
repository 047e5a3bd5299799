"""What rules of trust are made of: w_h and probabilities of policies (section 3.1, Eqs. 4 and 5), as pure
functions.

All sums are rounded once (`math.fsum`), so they do not depend on the order of policies or episodes.
"""

import math
from collections.abc import Sequence
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    # Not at run time: a protocol is read without arrays.
    from core.numerics.arrays import Floats


def as_weights(performance: Sequence[float]) -> Sequence[float]:
    """Return by how much each episode or policy counts in a performance-weighted mean, >= 0.

    Performances that are all >= 0 count as they are (Eqs. 4 and 5). Where any is negative (a sum of costs),
    each counts by how far it lies above the lowest of them: the paper does not say, and a negative weight
    would turn a match into its opposite. The lowest then counts nothing; where all are equal, all weights are
    0, and all count alike.
    """
    lowest = min(performance, default=0.0)
    return performance if lowest >= 0 else [pm - lowest for pm in performance]


def human_weight(performance: Sequence[float], match: Sequence[float]) -> float:
    """Return the performance-weighted mean degree of match, w_h (Eq. 4).

    Args:
        performance: pm_i of the compared top policies (`as_weights`).
        match: m_i of the same policies.

    Returns:
        w_h within the range of the m_i; their plain mean until some pm_i > 0 (0/0 in Eq. 4); 0 without any
        policy.
    """
    _check_performance(performance, match)
    if not match:
        return 0.0
    performance = as_weights(performance)
    total = math.fsum(performance)
    if total == 0:
        return math.fsum(match) / len(match)
    mean = math.fsum(pm * m for pm, m in zip(performance, match, strict=True)) / total
    # Rounding, of tiny performances above all, must not lead out of the range of the m_i.
    return min(max(mean, min(match)), max(match))


def next_human_weight(pm_before: float, w_before: float, pm_now: float, match_now: float) -> float:
    """Return w_h^k = (pm^{k-1} w_h^{k-1} + pm^k m^k) / (pm^{k-1} + pm^k) (Eq. 5).

    Args:
        pm_before: performance of the episode before.
        w_before: w_h after it.
        pm_now: performance of this episode.
        match_now: degree of match of this episode's policy.

    Returns:
        A value between `w_before` and `match_now`; their plain mean where both performances are 0, or one is
        negative: of two episodes the worse would then count nothing (`as_weights`), however little it is
            worse.
    """
    if min(pm_before, pm_now) < 0:
        return (w_before + match_now) / 2
    return human_weight([pm_before, pm_now], [w_before, match_now])


def signed_human_weight(
    performance: Sequence[float],
    agreement: Sequence[float],
    *,
    gain: float,
    standard_errors: float,
    margin: float = 0.0,
) -> float:
    """Return gain * sign(w) * max(0, |w| - standard_errors * se - margin), w being Eq. 4 over episodes.

    se = sd(a) sqrt(sum pm_i^2) / sum pm_i is the standard error of w for independent a_i. Episodes count
    alike until some performance is > 0.

    Args:
        performance: pm_i of recent episodes, at least 2 of them.
        agreement: signed match a_i of the same episodes, in [-1, 1].
        gain: > 0.
        standard_errors: >= 0.
        margin: agreement that a human model learned from noise may have, >= 0: se knows the chance of
            episodes only.

    Returns:
        w_h in [-gain, gain]; negative for a participant who means the opposite.
    """
    if len(agreement) < 2:
        raise ValueError(f"a standard error needs at least 2 episodes, got {len(agreement)}")
    w = human_weight(performance, agreement)
    mean = math.fsum(agreement) / len(agreement)
    sd = math.sqrt(math.fsum((a - mean) ** 2 for a in agreement) / (len(agreement) - 1))
    performance = as_weights(performance)
    total = math.fsum(performance)
    if total > 0:
        spread = math.sqrt(math.fsum(pm * pm for pm in performance)) / total
    else:
        spread = 1 / math.sqrt(len(agreement))
    return gain * math.copysign(max(0.0, abs(w) - standard_errors * sd * spread - margin), w)


def rank_human_weight(
    performance: Sequence[float],
    match: Sequence[float],
    *,
    gain: float,
    standard_errors: float,
    signed: bool,
) -> float:
    """Return gain times Spearman's correlation of performance and match, less its standard errors 1 / sqrt(n
    - 1).

    Args:
        performance: pm_i of recent episodes, at least 3 of them.
        match: m_i of the same episodes.
        gain: > 0.
        standard_errors: >= 0.
        signed: whether a negative correlation counts; as 0 otherwise.

    Returns:
        w_h in [-gain, gain]; 0 where all performances, or all matches, are equal.
    """
    _check_performance(performance, match)
    n = len(match)
    if n < 3:
        raise ValueError(f"a rank correlation needs at least 3 episodes, got {n}")
    first, second = _centred_ranks(performance), _centred_ranks(match)
    spread = math.sqrt(float(first @ first) * float(second @ second))
    if spread == 0:
        return 0.0
    r = float(first @ second) / spread
    kept = max(0.0, abs(r) - standard_errors / math.sqrt(n - 1))
    return gain * math.copysign(kept, r) if signed or r > 0 else 0.0


def rank_test(first: Sequence[float], second: Sequence[float]) -> float:
    """Return by how many standard errors `first` ranks above `second` (Mann & Whitney 1947, ties corrected).

    Ranks, because performances are close to exponential: one long episode must not decide.

    Args:
        first: performances, at least 1.
        second: performances, at least 1.

    Returns:
        > 0 where `first` is better; 0 where all are equal.
    """
    n, m = len(first), len(second)
    if min(n, m) < 1:
        raise ValueError(f"a comparison needs performances on both sides, got {n} and {m}")
    ranks = _centred_ranks([*first, *second])
    # Variance of a sum of n of these numbers drawn without replacement; their mean is 0.
    variance = n * m * float(ranks @ ranks) / ((n + m) * (n + m - 1))
    return float(ranks[:n].sum()) / math.sqrt(variance) if variance > 0 else 0.0


def _centred_ranks(values: Sequence[float]) -> "Floats":
    """Return twice the ranks less their mean, ties sharing theirs: whole numbers, so their products are
    exact.
    """
    import numpy as np  # not needed to read a protocol

    _, place, counts = np.unique(
        np.asarray(values, dtype=np.float64), return_inverse=True, return_counts=True
    )
    upto = np.cumsum(counts)
    return np.asarray((2.0 * upto - counts - len(values))[place], dtype=np.float64)


def pulls(match: Sequence[float | None], w_h: float) -> list[float]:
    """Return w_h m_i of each top policy: by how much a participant makes it likelier to be played (section
    3.1).

    Args:
        match: m_i, or None for a policy never compared: it gets the mean match of the others.
        w_h: human weight.
    """
    known = [m for m in match if m is not None]
    usual = math.fsum(known) / len(known) if known else 0.0
    return [w_h * (usual if m is None else m) for m in match]


def selection_probabilities(performance: Sequence[float], pull: Sequence[float]) -> list[float]:
    """Return the probability of each top policy being played (section 3.1), symmetric update included.

    p_i is proportional to pm_i max(0, 1 + sum of w_h m_i over the participants): to the performance where no
    participant is trusted (w_h = 0), and the higher, the more a policy matches a trusted one, or opposes a
    distrusted one.

    Args:
        performance: pm_i (`as_weights`), at least one policy.
        pull: of each policy, all participants together (`pulls`).

    Returns:
        Probabilities that sum to 1. Policies count alike until some pm_i > 0, or while all are equally
        negative.
    """
    _check_performance(performance, pull)
    if not performance:
        raise ValueError("there is no policy to select")
    performance = as_weights(performance)
    factors = [max(0.0, 1.0 + p) for p in pull]
    if not any(performance):
        performance = [1.0] * len(factors)
    scores = [pm * factor for pm, factor in zip(performance, factors, strict=True)]
    total = math.fsum(scores)
    if total == 0:
        # Everything good is distrusted entirely: performance alone decides.
        scores, total = list(performance), math.fsum(performance)
    return [score / total for score in scores]


def _check_performance(performance: Sequence[float], match: Sequence[float]) -> None:
    if len(performance) != len(match):
        raise ValueError(f"need one match per performance, got {len(match)} and {len(performance)}")
    if not all(map(math.isfinite, performance)):
        raise ValueError(f"performance is finite, got {list(performance)}")
