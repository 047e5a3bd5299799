"""What a rule of trust is: settings that say what the rule needs, and a state that follows the episodes.

`docs/extending.md` adds a rule step by step. No compiled code is imported here, so a protocol can be read
without it.
"""

import math
import struct
from abc import ABC, abstractmethod
from collections import deque
from collections.abc import Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, Protocol

from core.combination.agreement import Agreement
from core.combination.ranking import EpisodeReport, RankedPolicy

if TYPE_CHECKING:
    # Not at run time: a protocol is read without arrays.
    import numpy as np

    from core.numerics.arrays import Floats


@dataclass(frozen=True, slots=True)
class Needs:
    """What a rule needs beside performance and agreement. A player that cannot give it refuses the rule."""

    window: bool = False
    """Compares policies anew in recent decisions: these must be kept, and a policy must stay as it was
    played."""
    consistency: bool = False
    """Asks how well presses are foreseen (`EpisodeReport.consistency`), which is then part of the
    fingerprint."""
    side_by_side: tuple[float, ...] = ()
    """w_h of each of several learners that learn side by side, the one without the participant first; empty:
    one learner."""


class Window(Protocol):
    """Recent decisions (`core.combination.window.DecisionWindow`)."""

    def __len__(self) -> int:
        """Return how many are kept."""
        ...

    def compare(self, theta: "Floats", human_weights: "Floats") -> Agreement:
        """Return the agreement of an environment policy with a human policy in all decisions kept, at least
        one.
        """
        ...

    def chance(self, human_weights: "Floats", *, rng: "np.random.Generator") -> float:
        """Return the agreement rate of unrelated policies with a human policy, in [0, 1]."""
        ...


@dataclass(frozen=True, slots=True, eq=False)
class Evidence:
    """What there is to go by beside the episode itself."""

    ranked: Sequence[RankedPolicy]
    """The top policies, best first; the episode's own is among them if it is good enough."""
    human_weights: "Floats | None"
    """The human policy of now, shape (G,); None while there is none."""
    window: Window | None = None
    """Recent decisions; None where the player keeps none and the rule needs none."""


class Trust(ABC):
    """A rule's state in one session, for one participant. A rule revises `w_h`, and says what it goes by."""

    w_h: float = 0.0
    """Weight of the participant: 0, if not fixed, until the human policy has been compared with some
    policy."""

    @abstractmethod
    def revise(self, report: EpisodeReport, evidence: Evidence) -> None:
        """Follow an episode, which has been ranked."""

    def match(self, agreement: Agreement) -> float:
        """Return the rule's degree of match m_i of a policy; the fraction of equal choices unless it says
        otherwise.
        """
        return agreement.rate

    def matches(self, evidence: Evidence) -> list[float | None]:
        """Return m_i of each ranked policy; None for one never compared."""
        return [
            None if policy.agreement is None else self.match(policy.agreement) for policy in evidence.ranked
        ]

    def state_bytes(self) -> bytes:
        """Return all that decides about later weights, for fingerprints; `weight_bytes` and what the rule has
        beside it.
        """
        return weight_bytes(self.w_h)


class Rule(Protocol):
    """The settings of a rule of trust: a frozen struct with a tag of its own."""

    @property
    def needs(self) -> Needs:
        """What the rule needs, with these settings."""
        ...

    def begin(self, *, root_seed: int) -> Trust:
        """Return the rule's state before the first episode; its random choices follow from the session's root
        seed.
        """
        ...


def weight_bytes(w_h: float, performance_before: float = 0.0, compared: bool = False) -> bytes:
    """Return the first 17 bytes of a rule's fingerprint; the last two numbers are those of Equation 5.

    They stand in the fingerprints of all rules since the first recordings.
    """
    return struct.pack("<dd?", w_h, performance_before, compared)


class RecentEpisodes:
    """The last compared episodes: performance of each, and one number more (agreement, or w_h)."""

    def __init__(self, size: int) -> None:
        self._kept: deque[tuple[float, float]] = deque(maxlen=size)

    def __len__(self) -> int:
        return len(self._kept)

    @property
    def performances(self) -> list[float]:
        """pm_i, oldest first."""
        return [performance for performance, _ in self._kept]

    @property
    def numbers(self) -> list[float]:
        """The other number of each, oldest first."""
        return [number for _, number in self._kept]

    def add(self, performance: float, number: float) -> None:
        """Keep an episode; the oldest one goes where there are too many."""
        self._kept.append((performance, number))

    def state_bytes(self) -> bytes:
        """Return everything kept, for fingerprints."""
        return b"".join(struct.pack("<dd", *pair) for pair in self._kept)


def check_memory(
    minimum: int, kept: int, *, least: int, names: tuple[str, str] = ("minimum_episodes", "episodes")
) -> None:
    """Refuse a minimum that says nothing, or that what is kept can never reach."""
    if not least <= minimum <= kept:
        raise ValueError(f"need {least} <= {names[0]} <= {names[1]}, got {minimum} and {kept}")


def check_weight(weight: float) -> None:
    """Refuse a weight that is not > 0."""
    if not (math.isfinite(weight) and weight > 0):
        raise ValueError(f"need weight > 0, got {weight}")


def check_gain(gain: float, standard_errors: float) -> None:
    """Refuse a gain that is not > 0, and a negative number of standard errors."""
    if not (math.isfinite(gain) and gain > 0 and standard_errors >= 0):
        raise ValueError(f"need gain > 0 and standard_errors >= 0: {gain}, {standard_errors}")
