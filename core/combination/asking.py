"""Asking: the agent poses a choice of two or three candidate actions where its top policies disagree most.

The paper's introduction names feedback as "a selection from multiple options posed by the agent"; when to ask
and what an answer is worth are ours (`docs/decisions/asking.md`): query by committee, the committee being the
top policies.
"""

import math
from collections import deque
from collections.abc import Sequence
from dataclasses import dataclass

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
    """Chance that two policies drawn from the committee choose different actions, in [0, 1)."""


def votes(actions: Sequence[int], probabilities: Sequence[float]) -> dict[int, float]:
    """Return the fraction of the committee behind each action.

    Args:
        actions: what each policy would do.
        probabilities: weight of each policy, summing to 1.
    """
    support: dict[int, float] = {}
    for action, probability in zip(actions, probabilities, strict=True):
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

    def reset(self) -> None:
        """Note that a watched episode begins: its budget of questions is new."""
        self._asked = 0

    def question(
        self, choices: Choices, actions: Sequence[int], probabilities: Sequence[float]
    ) -> Question | None:
        """Return a question about this decision, or None.

        Args:
            choices: the decision.
            actions: what each policy of the committee would do.
            probabilities: weight of each policy, summing to 1.
        """
        support = votes(actions, probabilities)
        disagreement = disagreement_of(support)
        before = sorted(self._seen)
        self._seen.append(disagreement)
        if self._asked >= self.config.per_episode or len(before) < self.config.minimum_decisions:
            return None
        # At most `share` of the decisions before may have had more.
        border = before[math.ceil((1.0 - self.config.share) * len(before)) - 1]
        if len(support) < 2 or disagreement <= border:
            return None
        self._asked += 1
        ranked = sorted(support, key=lambda action: (-support[action], action))
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
