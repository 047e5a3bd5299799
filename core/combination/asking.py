"""Asking: the agent poses a choice of two or three candidate actions where its top policies disagree most.

The paper's introduction names feedback as "a selection from multiple options posed by the agent"; when to ask
and what an answer is worth are ours (`docs/decisions/asking.md`): query by committee, the committee being the
top policies. A learner that changes at every step has no committee: it asks where the values of its two best
actions are closest.

An answer is learned from like presses: the chosen option is one sample of label 1, the others together one of
label -1 (`samples_of`). Live, simulated and replayed sessions all learn by these functions.
"""

import math
from collections import deque
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from core.combination.config import AskingConfig
from core.domain import Choices, Features
from core.feedback.samples import FeedbackSample


@dataclass(frozen=True, slots=True, eq=False)
class Question:
    """Which of these actions would you take?"""

    options: tuple[int, ...]
    """Actions, most votes first."""
    features: Features
    """psi(s, a) of each option, shape (n, G)."""
    disagreement: float
    """How unsure the agent is. Of a committee: the chance that two policies drawn from it choose different
    actions, in [0, 1). Of a learner that changes at every step: 1 / (1 + d), d >= 0 being how far the best
    action's value is above the second's, in (0, 1]."""


def votes(actions: Sequence[int], probabilities: Sequence[float]) -> dict[int, float]:
    """Return the fraction of the committee behind each action.

    Args:
        actions: what each policy would do.
        probabilities: weight of each policy, summing to 1.
    """
    support: dict[int, float] = {}
    for action, probability in zip(actions, probabilities, strict=True):
        if probability > 0:  # a policy that is never played has no vote
            support[action] = support.get(action, 0.0) + probability
    return support


def disagreement_of(support: dict[int, float]) -> float:
    """Return the chance that two policies drawn with replacement choose different actions: 1 - sum of
    squares.
    """
    return 1.0 - math.fsum(part * part for part in support.values())


class Asker:
    """Decides when to ask: at the decisions whose disagreement is among the highest of those seen of late."""

    def __init__(self, config: AskingConfig) -> None:
        self.config = config
        self._seen: deque[float] = deque(maxlen=config.memory)
        self._asked = 0
        self._since_asked = config.memory

    def reset(self) -> None:
        """Note that a watched episode begins: its budget of questions is new."""
        self._asked = 0

    def question(
        self, choices: Choices, actions: Sequence[int], probabilities: Sequence[float]
    ) -> Question | None:
        """Return a question of a committee about this decision, or None.

        Args:
            choices: the decision.
            actions: what each policy of the committee would do.
            probabilities: weight of each policy, summing to 1.
        """
        support = votes(actions, probabilities)
        ranked = sorted(support, key=lambda action: (-support[action], action))
        return self._ask_if_rare(
            choices,
            ranked,
            disagreement_of(support),
            utmost=len(support) == sum(p > 0 for p in probabilities),
        )

    def question_by_values(self, choices: Choices, values: NDArray[np.float64]) -> Question | None:
        """Return a question of a learner that has no committee about this decision, or None.

        Args:
            choices: the decision.
            values: of each action, shape (n,).
        """
        allowed = np.flatnonzero(~choices.ruled_out).tolist()
        ranked = sorted(allowed, key=lambda action: (-values[action], action))
        lead = float(values[ranked[0]] - values[ranked[1]]) if len(ranked) > 1 else math.inf
        return self._ask_if_rare(choices, ranked, 1.0 / (1.0 + lead), utmost=lead == 0.0)

    def _ask_if_rare(
        self, choices: Choices, ranked: Sequence[int], disagreement: float, *, utmost: bool
    ) -> Question | None:
        """Return a question where few of the decisions before were as unsure as this one."""
        before = sorted(self._seen)
        self._seen.append(disagreement)
        self._since_asked += 1
        if self._asked >= self.config.per_episode or len(before) < self.config.minimum_decisions:
            return None
        # At most `share` of the decisions before may have had more.
        border = before[math.ceil((1.0 - self.config.share) * len(before)) - 1]
        # An agent that begins is often as unsure as it can be (`utmost`: no two policies agree, or the best
        # values are equal), and then nothing is above the border: it asks there as rarely as elsewhere.
        begins = utmost and self._since_asked > 1.0 / self.config.share
        if len(ranked) < 2 or not (disagreement > border or begins):
            return None
        self._asked += 1
        self._since_asked = 0
        options = tuple(ranked[: self.config.options])
        return Question(options, choices.feedback_features[list(options)], disagreement)


def samples_of(question: Question, chosen: int, *, number: int) -> list[FeedbackSample]:
    """Return what an answer says: the chosen option is good, the others together as bad.

    Args:
        question: what was asked.
        chosen: the action chosen, one of the options.
        number: of the question, from 0; the samples name it as step -1 - number, which no watched step has.

    Raises:
        ValueError: `chosen` is not an option.
    """
    if chosen not in question.options:
        raise ValueError(f"the answer {chosen} is not among the options {question.options}")
    weight = 1.0 / (len(question.options) - 1)
    return [
        FeedbackSample(
            features=row,
            label=1.0 if option == chosen else -1.0,
            weight=1.0 if option == chosen else weight,
            step=-1 - number,
            presses=(),
        )
        for option, row in zip(question.options, question.features, strict=True)
    ]
