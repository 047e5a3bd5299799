"""The environment's side of an agent whose learner proposes a policy for a whole episode."""

from typing import ClassVar

import numpy as np

from core.combination.preference import best_action
from core.combination.sides import EpisodeEnd, EpisodeStart, HumanPreference, StartedPolicy
from core.combination.window import Values
from core.domain import Choices
from core.learners.contract import EnvironmentLearner
from core.learners.kinds import LearnerKind
from core.numerics.arrays import Floats


class PolicySearch:
    """A learner that proposes a policy for a whole episode: good ones can be played again."""

    kind: ClassVar[LearnerKind] = "search"

    def __init__(self, learner: EnvironmentLearner, values: Values) -> None:
        self._learner = learner
        self._values = values

    def start_policy(self, start: EpisodeStart) -> StartedPolicy:
        """Return a ranked policy where one may be drawn, else the learner's proposal."""
        if start.draw is not None:
            return StartedPolicy(*start.draw(), proposed=False)
        candidate = self._learner.propose()
        return StartedPolicy(candidate.policy_id, candidate.weights, proposed=True)

    def values(self, choices: Choices, theta: Floats) -> Floats:
        """Return the features times theta."""
        return self._values(choices.features, theta)

    def act(self, values: Floats, choices: Choices, preferred: int, human: HumanPreference) -> int:
        """Return the preferred action; the best one where there is none."""
        return preferred if preferred >= 0 else best_action(values, choices.ruled_out, len(values))

    def took(
        self,
        choices: Choices,
        action: int,
        reward: float,
        *,
        shaping: float,
        augmentation: float,
        watched_step: int = -1,
    ) -> None:
        """Do nothing: this learner learns from whole episodes only."""

    def end_episode(self, end: EpisodeEnd) -> None:
        """Tell the learner how its proposal did."""
        if end.proposed:
            self._learner.report(end.policy_id, end.performance)

    def no_policy(self) -> Floats:
        """Return zeros."""
        return np.zeros_like(self._learner.propose().weights)

    def state_digest(self) -> bytes:
        """Return the learner's state."""
        return self._learner.state_digest()

    def export(self) -> dict[str, list[float]]:
        """Return nothing: the ranked policies are what has been learned."""
        return {}
