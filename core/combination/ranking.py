"""The top policies of an agent, best first, and what an episode says about its policy (section 3.1)."""

import math
import struct
from dataclasses import dataclass
from typing import TYPE_CHECKING

from core.combination.agreement import Agreement

if TYPE_CHECKING:
    # Not at run time: a protocol is read without arrays.
    import numpy as np

    from core.numerics.arrays import Floats


@dataclass(frozen=True, slots=True, eq=False)
class EpisodeReport:
    """What bootstrap learning has to know of an episode."""

    policy_id: int
    theta: "Floats"
    """Weights of the environment policy, shape (F,)."""
    performance: float
    """Performance measure of the episode, of either sign."""
    truncated: bool
    """The episode was stopped: its performance is that of a part."""
    agreement: Agreement | None
    """Of this policy with the human policy; None where there was no human policy."""
    consistency: float = 0.0
    """How many standard errors better than chance the human model foresees its presses."""


@dataclass(slots=True, eq=False)
class RankedPolicy:
    """One of the top N policies."""

    policy_id: int
    theta: "Floats"
    total_performance: float
    terminated_episodes: int
    agreement: Agreement | None

    @property
    def performance(self) -> float:
        """pm_i: performance per episode that came to its end.

        For durations and counts with a constant chance to end this is the maximum-likelihood mean when some
        episodes were truncated (`docs/decisions/performance-of-a-policy.md`).
        """
        return self.total_performance / max(1, self.terminated_episodes)

    def state_bytes(self) -> bytes:
        """Return all that decides about later choices, for fingerprints."""
        counts = self.agreement or Agreement(1, 0, 0)
        packed = struct.pack(
            "<qdq?qqq",
            self.policy_id,
            self.total_performance,
            self.terminated_episodes,
            self.agreement is not None,
            counts.decisions,
            counts.agreed,
            counts.agreed_worst,
        )
        return packed + self.theta.tobytes()


class Ranking:
    """Keeps the N best policies, best first; of equal ones the older first."""

    def __init__(self, size: int) -> None:
        self.policies: list[RankedPolicy] = []
        self._size = size

    def add(self, report: EpisodeReport) -> None:
        """Add an episode to its policy.

        Raises:
            ValueError: the performance is not finite.
        """
        if not math.isfinite(report.performance):
            raise ValueError(f"policy {report.policy_id}: performance is finite: {report.performance}")
        known = next((p for p in self.policies if p.policy_id == report.policy_id), None)
        if known is None:
            known = RankedPolicy(report.policy_id, report.theta, 0.0, 0, None)
            self.policies.append(known)
        known.total_performance += report.performance
        known.terminated_episodes += not report.truncated
        if report.agreement is not None:
            known.agreement = report.agreement
        self.policies.sort(key=lambda policy: (-policy.performance, policy.policy_id))
        del self.policies[self._size :]

    def state_bytes(self) -> bytes:
        """Return all that decides about later choices, for fingerprints."""
        return b"".join(policy.state_bytes() for policy in self.policies)


def draw_policy(
    ranked: list[RankedPolicy], probabilities: list[float], *, rng: "np.random.Generator"
) -> RankedPolicy:
    """Return one of the ranked policies (there must be one), drawn with these probabilities."""
    point = float(rng.random())
    cumulative = 0.0
    for policy, probability in zip(ranked, probabilities, strict=True):
        cumulative += probability
        if point < cumulative:
            return policy
    # Rounding left the sum a little below 1: a policy that can be drawn at all.
    return max(zip(ranked, probabilities, strict=True), key=lambda pair: pair[1] > 0)[0]
