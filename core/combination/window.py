"""Recent decisions, kept so that policies can be compared with the human policy of now."""

import math
from collections import deque
from collections.abc import Callable

import numpy as np
from numpy.typing import NDArray

from core.combination.agreement import Agreement
from core.combination.preference import mean_and_sd
from core.combination.tally import Tally, agreement_of, compare_choices, new_tally
from core.domain import Choices, Features
from core.learners.linear import action_values
from core.numerics.arrays import in_order
from core.numerics.compiled import kernel
from core.numerics.fixed_point import exact_weights

Values = Callable[[Features, NDArray[np.float64]], NDArray[np.float64]]
"""Values of actions: (feature rows (n, F), weights (F,)) -> (n,)."""

N_RANDOM_POLICIES = 20
"""Random policies behind an estimate of chance agreement."""


def exact_values(rows: Features, weights: NDArray[np.float64]) -> NDArray[np.float64]:
    """Return rows (n, F) times weights (F,) on the grid of `core.numerics.fixed_point`: as a compiled player
    has them.
    """
    return action_values(np.asarray(rows, np.float64), exact_weights(weights))


@kernel
def compare_decisions(
    env_values: NDArray[np.float64],
    human_values: NDArray[np.float64],
    ruled_out: NDArray[np.bool_],
    starts: NDArray[np.int64],
    tally: Tally,
) -> None:
    """Count agreement in decisions that lie one after the other.

    Args:
        env_values: values of all actions of all decisions, one decision after the other, shape (R,).
        human_values: likewise.
        ruled_out: likewise.
        starts: first row of each decision and, last, R, shape (D + 1,).
        tally: counts the decisions (`core.combination.tally`).
    """
    for decision in range(starts.shape[0] - 1):
        low, high = starts[decision], starts[decision + 1]
        compare_choices(env_values[low:high], human_values[low:high], ruled_out[low:high], high - low, tally)


@kernel
def mean_spread(
    values: NDArray[np.float64], ruled_out: NDArray[np.bool_], starts: NDArray[np.int64]
) -> float:
    """Return the root mean square, over decisions, of the sd of the values among the actions; as
    `compare_decisions`.
    """
    total = 0.0
    for decision in range(starts.shape[0] - 1):
        low, high = starts[decision], starts[decision + 1]
        spread = mean_and_sd(values[low:high], ruled_out[low:high], high - low)[1]
        total += spread * spread
    return math.sqrt(total / (starts.shape[0] - 1))


class DecisionWindow:
    """The last decisions, whichever side made them: a sample of states in which to compare policies."""

    def __init__(self, capacity: int, environment_values: Values, human_values: Values) -> None:
        self._decisions: deque[Choices] = deque(maxlen=capacity)
        self._environment_values = environment_values
        self._human_values = human_values
        self._stacked: tuple[NDArray[np.float64], Features, NDArray[np.bool_], NDArray[np.int64]] | None
        self._stacked = None

    def __len__(self) -> int:
        return len(self._decisions)

    def remember(self, choices: Choices) -> None:
        """Keep a decision; the oldest one goes when the window is full."""
        self._decisions.append(choices)
        self._stacked = None

    def compare(self, theta: NDArray[np.float64], human_weights: NDArray[np.float64]) -> Agreement:
        """Return the agreement of an environment policy with a human policy in all decisions kept (at least
        one).
        """
        rows, feedback_rows, ruled_out, starts = self._rows()
        tally = new_tally()
        compare_decisions(
            self._environment_values(rows, theta),
            self._human_values(feedback_rows, human_weights),
            ruled_out,
            starts,
            tally,
        )
        agreement = agreement_of(tally)
        assert agreement is not None, "a window with rows has decisions"
        return agreement

    def spread(self, human_weights: NDArray[np.float64]) -> float:
        """Return how far H lies apart among the actions of a decision kept (root mean square of its sd)."""
        _, feedback_rows, ruled_out, starts = self._rows()
        return float(mean_spread(self._human_values(feedback_rows, human_weights), ruled_out, starts))

    def chance(self, human_weights: NDArray[np.float64], *, rng: np.random.Generator) -> float:
        """Return the mean agreement rate of policies with standard normal weights: unrelated ones."""
        n_features = self._rows()[0].shape[1]
        rates = [
            self.compare(rng.standard_normal(size=(n_features,)), human_weights).rate
            for _ in range(N_RANDOM_POLICIES)
        ]
        return in_order(rates) / len(rates)

    def _rows(
        self,
    ) -> tuple[NDArray[np.float64], Features, NDArray[np.bool_], NDArray[np.int64]]:
        if not self._decisions:
            raise ValueError("no decision has been remembered yet")
        if self._stacked is None:
            sizes = [len(choices.ruled_out) for choices in self._decisions]
            self._stacked = (
                np.concatenate([choices.features for choices in self._decisions]),
                np.concatenate([choices.feedback_features for choices in self._decisions]),
                np.concatenate([choices.ruled_out for choices in self._decisions]),
                np.concatenate([[0], np.cumsum(sizes)]).astype(np.int64),
            )
        return self._stacked
