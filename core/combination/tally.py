"""Counting agreement: one kernel counts each decision, in compiled code or not.

A tally is an array of shape (3,): how many decisions there were with a human policy, at how many of them the
environment policy chose the human policy's best action, and at how many its worst.
"""

from collections.abc import Sequence
from typing import Final, Protocol

import numpy as np
from numpy.typing import NDArray

from core.combination.agreement import Agreement
from core.combination.preference import best_action, worst_action
from core.numerics.arrays import Bools, Floats
from core.numerics.compiled import inner_kernel

Tally = NDArray[np.int64]
COMPARED: Final = 0
AGREED: Final = 1
AGREED_WORST: Final = 2
N_COUNTS: Final = 3


def new_tally() -> Tally:
    """Return a tally of no decision."""
    return np.zeros(N_COUNTS, dtype=np.int64)


def agreement_of(tally: Tally) -> Agreement | None:
    """Return what a tally has counted; None where no decision was compared."""
    compared, agreed, agreed_worst = tally.tolist()
    return Agreement(compared, agreed, agreed_worst) if compared else None


@inner_kernel
def count_decision(tally: Tally, environment_action: int, human_action: int, human_worst_action: int) -> None:
    """Count one decision: what the environment policy chose, and the human policy's best and worst action."""
    tally[COMPARED] += 1
    tally[AGREED] += environment_action == human_action
    tally[AGREED_WORST] += environment_action == human_worst_action


@inner_kernel
def compare_choices(env_values: Floats, human_values: Floats, ruled_out: Bools, n: int, tally: Tally) -> int:
    """Count one decision by the values R and H of its n actions; return the human policy's best action."""
    human_best = best_action(human_values, ruled_out, n)
    human_worst = worst_action(human_values, ruled_out, n)
    count_decision(tally, best_action(env_values, ruled_out, n), human_best, human_worst)
    return human_best


class Compared(Protocol):
    """A decision, as far as agreement is concerned (`core.combination.sides.Decision`)."""

    @property
    def environment_action(self) -> int:
        """What the environment policy alone would have chosen."""
        ...

    @property
    def human_action(self) -> int:
        """The human policy's best action; -1 while there is none."""
        ...

    @property
    def human_worst_action(self) -> int:
        """The human policy's worst action; -1 while there is none."""
        ...

    @property
    def of_participants(self) -> Sequence[tuple[int, int]]:
        """Best and worst action of each participant's own model; -1 while it knows nothing."""
        ...


class EpisodeTally:
    """Counts the decisions of one episode that is played step by step."""

    def __init__(self) -> None:
        self.counts = new_tally()
        """Of the human policy that all participants have taught together."""
        self._each: dict[int, Tally] = {}

    @property
    def agreement(self) -> Agreement | None:
        """Agreement with the human policy; None where there was none at any decision."""
        return agreement_of(self.counts)

    @property
    def with_each(self) -> tuple[Agreement | None, ...]:
        """Agreement with each participant's own model."""
        return tuple(agreement_of(tally) for tally in self._each.values())

    def add(self, decision: Compared) -> None:
        """Count a decision."""
        environment = decision.environment_action
        if decision.human_action >= 0:
            count_decision(self.counts, environment, decision.human_action, decision.human_worst_action)
        for participant, (best, worst) in enumerate(decision.of_participants):
            tally = self._each.setdefault(participant, new_tally())
            if best >= 0:
                count_decision(tally, environment, best, worst)
