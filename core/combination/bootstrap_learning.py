"""Bootstrap learning: the top policies, their match to the human policy, and how far each side is trusted.

Section 3.1 of the paper; every decision it leaves open has a page in `docs/decisions`.
"""

import math
import struct
from collections import deque
from dataclasses import dataclass
from typing import assert_never

import numpy as np
from numpy.typing import NDArray

from core.combination.config import (
    BootstrapConfig,
    Equation4,
    Equation5,
    FixedWeight,
    RankCorrelation,
    SideBySide,
    Signed,
    Tried,
)
from core.combination.trust import (
    Comparison,
    degree_of_match,
    human_weight,
    next_human_weight,
    rank_human_weight,
    rank_test,
    selection_probabilities,
    signed_human_weight,
)
from core.combination.window import DecisionWindow
from core.streams import stream


@dataclass(frozen=True, slots=True, eq=False)
class EpisodeReport:
    """What bootstrap learning has to know of an episode."""

    policy_id: int
    theta: NDArray[np.float64]
    """Weights of the environment policy, shape (F,)."""
    performance: float
    """Performance measure of the episode, >= 0."""
    truncated: bool
    """The episode was stopped, so its performance is a lower bound."""
    comparison: Comparison | None
    """Choices of this policy held against the human policy; None where there was no human policy."""
    consistency: float = 0.0
    """How many standard errors better than chance the human model foresees its presses."""


@dataclass(slots=True, eq=False)
class RankedPolicy:
    """One of the top N policies."""

    policy_id: int
    theta: NDArray[np.float64]
    total_performance: float
    terminated_episodes: int
    comparison: Comparison | None

    @property
    def performance(self) -> float:
        """pm_i: performance per episode that came to its end.

        For durations and counts with a constant chance to end this is the maximum-likelihood mean when some
        episodes were truncated (`docs/decisions/performance-of-a-policy.md`).
        """
        return self.total_performance / max(1, self.terminated_episodes)


class BootstrapLearning:
    """Keeps the top N policies and w_h, the weight of the human."""

    def __init__(self, config: BootstrapConfig, window: DecisionWindow, *, root_seed: int) -> None:
        """Begin without policies and without trust.

        Args:
            config: settings.
            window: recent decisions; whoever fills it decides which.
            root_seed: of the session; its stream "chance" gives the random policies behind an estimate of
                chance agreement, the same ones each time.
        """
        self.config = config
        self._window = window
        self._root_seed = root_seed
        self._ranked: list[RankedPolicy] = []
        self._w_h = config.trust.w_h if isinstance(config.trust, FixedWeight) else 0.0
        self._compared_anything = False
        # Eq. 5: performance behind w_h so far. Others: (pm_i, a_i), or (pm_i, attitude), of recent episodes.
        self._performance_before = 0.0
        # Tried and SideBySide: the attitude that is believed in, and the one of the next episode; how many episodes were
        # compared, and how many of them without the human.
        self._believed = 0.0
        self._attitude = 0.0
        self._n_compared = 0
        self._n_own = 0
        trust = config.trust
        self._recent: deque[tuple[float, float]] = deque(
            maxlen=trust.episodes if isinstance(trust, Signed | RankCorrelation | Tried | SideBySide) else 1
        )

    @property
    def w_h(self) -> float:
        """Weight of the human: 0 (if not fixed) until the human policy has been compared with some policy."""
        return self._w_h

    @property
    def attitude(self) -> float:
        """Attitude of the next episode where the rule has some (`Tried`, `SideBySide`): 1 believes the human, -1 the opposite."""
        return self._attitude

    @property
    def ranked(self) -> list[RankedPolicy]:
        """The top policies, best first; of equal ones the older first."""
        return list(self._ranked)

    def record(self, report: EpisodeReport, human_weights: NDArray[np.float64] | None) -> None:
        """Take in an episode: ranks its policy and revises w_h.

        Args:
            report: the episode.
            human_weights: the human policy of now, shape (G,), or None while there is none.
        """
        if not (math.isfinite(report.performance) and report.performance >= 0):
            raise ValueError(
                f"policy {report.policy_id}: performance is finite and >= 0: {report.performance}"
            )
        self._rank(report)
        self._revise(report, human_weights)

    def matches(self, human_weights: NDArray[np.float64] | None) -> list[float | None]:
        """Return m_i of the ranked policies by the trust rule's own measure; None for one never compared."""
        trust = self.config.trust
        if isinstance(trust, Equation4):
            return self._matches_of_equation_4(trust, human_weights)
        kind = (
            "signed"
            if isinstance(trust, Signed | SideBySide)
            else trust.match
            if isinstance(trust, Equation5)
            else "rate"
        )
        return [
            None if policy.comparison is None else degree_of_match(policy.comparison, kind)
            for policy in self._ranked
        ]

    def probabilities(self, human_weights: NDArray[np.float64] | None) -> list[float]:
        """Return the probability of each ranked policy being played."""
        trusted = self._w_h if self.config.symmetric else 0.0
        matches = self.matches(human_weights) if trusted else [None] * len(self._ranked)
        return selection_probabilities([policy.performance for policy in self._ranked], matches, trusted)

    def draw(self, human_weights: NDArray[np.float64] | None, *, rng: np.random.Generator) -> RankedPolicy:
        """Return one of the ranked policies (there must be one), drawn by `probabilities`."""
        point = float(rng.random())
        cumulative = 0.0
        probabilities = self.probabilities(human_weights)
        for policy, probability in zip(self._ranked, probabilities, strict=True):
            cumulative += probability
            if point < cumulative:
                return policy
        # Rounding left the sum a little below 1: the last policy that can be drawn at all.
        return max(zip(self._ranked, probabilities, strict=True), key=lambda pair: pair[1] > 0)[0]

    def state_bytes(self) -> bytes:
        """Return all that decides about later choices, for fingerprints."""
        parts = [struct.pack("<dd?", self._w_h, self._performance_before, self._compared_anything)]
        if isinstance(self.config.trust, Tried):
            # Only there: sessions under the other rules keep the fingerprints that were recorded.
            parts.append(struct.pack("<ddq", self._believed, self._attitude, self._n_compared))
        if isinstance(self.config.trust, SideBySide):
            parts.append(struct.pack("<ddqq", self._believed, self._attitude, self._n_compared, self._n_own))
        parts += [struct.pack("<dd", *pair) for pair in self._recent]
        for policy in self._ranked:
            counts = policy.comparison or Comparison(1, 0, 0)
            parts.append(
                struct.pack(
                    "<qdq?qqq",
                    policy.policy_id,
                    policy.total_performance,
                    policy.terminated_episodes,
                    policy.comparison is not None,
                    counts.decisions,
                    counts.agreed,
                    counts.agreed_worst,
                )
            )
            parts.append(policy.theta.tobytes())
        return b"".join(parts)

    def _rank(self, report: EpisodeReport) -> None:
        """Add the episode to its policy, and keep the N best."""
        known = next((p for p in self._ranked if p.policy_id == report.policy_id), None)
        if known is None:
            known = RankedPolicy(report.policy_id, report.theta, 0.0, 0, None)
            self._ranked.append(known)
        known.total_performance += report.performance
        known.terminated_episodes += not report.truncated
        if report.comparison is not None:
            known.comparison = report.comparison
        self._ranked.sort(key=lambda policy: (-policy.performance, policy.policy_id))
        del self._ranked[self.config.top_policies :]

    def _revise(self, report: EpisodeReport, human_weights: NDArray[np.float64] | None) -> None:
        """Update w_h by the trust rule."""
        match self.config.trust:
            case FixedWeight():
                pass
            case Equation4():
                known = [
                    (policy.performance, m)
                    for policy, m in zip(self._ranked, self.matches(human_weights), strict=True)
                    if m is not None
                ]
                self._w_h = human_weight([pm for pm, _ in known], [m for _, m in known])
            case Equation5() as rule:
                self._revise_by_equation_5(rule, report)
            case Signed() as rule:
                self._revise_by_signed_match(rule, report)
            case RankCorrelation() as rule:
                self._revise_by_rank_correlation(rule, report)
            case Tried() as rule:
                self._revise_by_trial(rule, report)
            case SideBySide() as rule:
                self._revise_side_by_side(rule, report)
            case forgotten:
                assert_never(forgotten)

    def _matches_of_equation_4(
        self, rule: Equation4, human_weights: NDArray[np.float64] | None
    ) -> list[float | None]:
        anew = rule.measured == "window"
        estimate_chance = rule.match == "chance-corrected" and rule.chance is None
        if human_weights is None or ((anew or estimate_chance) and not len(self._window)):
            return [None] * len(self._ranked)
        chance = rule.chance or 0.0
        if estimate_chance:
            chance = min(self._window.chance(human_weights, rng=stream(self._root_seed, "chance")), 0.99)
        comparisons = [
            self._window.compare(policy.theta, human_weights) if anew else policy.comparison
            for policy in self._ranked
        ]
        return [None if c is None else degree_of_match(c, rule.match, chance) for c in comparisons]

    def _revise_by_equation_5(self, rule: Equation5, report: EpisodeReport) -> None:
        if report.comparison is not None:
            m_now = degree_of_match(report.comparison, rule.match)
            if self._compared_anything or not rule.cumulative:
                self._w_h = next_human_weight(self._performance_before, self._w_h, report.performance, m_now)
            else:
                self._w_h = m_now
            self._compared_anything = True
        if not rule.cumulative:
            self._performance_before = report.performance
        elif report.comparison is not None:
            self._performance_before += report.performance

    def _revise_by_signed_match(self, rule: Signed, report: EpisodeReport) -> None:
        if report.comparison is None:
            return
        self._recent.append((report.performance, report.comparison.signed))
        random = rule.consistent_above is not None and report.consistency <= rule.consistent_above
        if random or len(self._recent) < rule.minimum_episodes:
            self._w_h = 0.0
        else:
            self._w_h = signed_human_weight(
                [pm for pm, _ in self._recent],
                [a for _, a in self._recent],
                gain=rule.gain,
                standard_errors=rule.standard_errors,
                margin=rule.margin,
            )

    def _revise_by_rank_correlation(self, rule: RankCorrelation, report: EpisodeReport) -> None:
        if report.comparison is None:
            return
        self._recent.append((report.performance, report.comparison.rate))
        if len(self._recent) >= rule.minimum_episodes:
            self._w_h = rank_human_weight(
                [pm for pm, _ in self._recent],
                [m for _, m in self._recent],
                gain=rule.gain,
                standard_errors=rule.standard_errors,
                signed=rule.signed,
            )

    def _revise_by_trial(self, rule: Tried, report: EpisodeReport) -> None:
        if report.comparison is None:
            return
        self._recent.append((report.performance, self._attitude))
        self._n_compared += 1
        self._believed = self._attitude = self._best_attitude(rule)
        rng = stream(self._root_seed, "trial", self._n_compared)
        tries, which = rng.random(2).tolist()
        if self._believed != 0.0:
            if tries < rule.control_share:
                self._attitude = 0.0
        elif report.consistency > rule.consistent_above and tries < rule.trial_share:
            self._attitude = 1.0 if which < 0.5 else -1.0
        self._w_h = self._attitude * rule.weight

    def _revise_side_by_side(self, rule: SideBySide, report: EpisodeReport) -> None:
        if report.comparison is None:
            return
        self._n_compared += 1
        if self._attitude == 0.0:
            self._n_own += 1
            self._recent.append((report.performance, report.comparison.signed))
            if self._n_own >= rule.warm_up_episodes:
                w = signed_human_weight(
                    [pm for pm, _ in self._recent],
                    [a for _, a in self._recent],
                    gain=1.0,
                    standard_errors=rule.standard_errors,
                    margin=rule.margin,
                )
                self._believed = 0.0 if w == 0.0 else math.copysign(1.0, w)
        point = float(stream(self._root_seed, "side by side", self._n_compared).random())
        if self._believed == 0.0:
            self._attitude = (0.0, 1.0, -1.0)[int(3 * point)]
        elif point < rule.own_share:
            self._attitude = 0.0
        else:
            opposite = point < rule.own_share + rule.other_share
            self._attitude = -self._believed if opposite else self._believed
        self._w_h = self._attitude * rule.weight

    def _best_attitude(self, rule: Tried) -> float:
        """Return the attitude that does best: the believed one, unless another is better by enough."""
        played = {
            attitude: [pm for pm, used in self._recent if used == attitude] for attitude in (0.0, 1.0, -1.0)
        }
        present = played.pop(self._believed)
        best, lead = self._believed, rule.better_by
        for attitude, performances in played.items():
            if min(len(performances), len(present)) >= rule.minimum_episodes:
                score = rank_test(performances, present)
                if score > lead:
                    best, lead = attitude, score
        return best
