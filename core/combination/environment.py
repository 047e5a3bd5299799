"""The environment's side of an agent: one interface over learners that search and learners that learn at
every step.

`core.combination.agent` asks this side for values and actions and never knows which kind it has.
"""

from typing import ClassVar, NamedTuple, Protocol

import numpy as np

from core.combination.climbing import Climbing, Coached
from core.combination.config import Coach, Scheme, check_learner
from core.combination.policy_search import PolicySearch
from core.combination.sides import EpisodeEnd, EpisodeStart, HumanPreference, StartedPolicy
from core.combination.window import Values
from core.domain import Choices
from core.events import CreditGiven
from core.learners.contract import Actor, EnvironmentLearner, StepwiseLearner
from core.learners.kinds import LearnerKind
from core.numerics.arrays import Floats


class EnvironmentSide(Protocol):
    """What an agent asks of its environment learner."""

    kind: ClassVar[LearnerKind]
    """Of its learner: says what a scheme can act on."""

    def start_policy(self, start: EpisodeStart) -> StartedPolicy:
        """Return the policy of this episode."""
        ...

    def values(self, choices: Choices, theta: Floats) -> Floats:
        """Return R of each action under the policy theta, shape (n,)."""
        ...

    def act(self, values: Floats, choices: Choices, preferred: int, human: HumanPreference) -> int:
        """Return the action to take; `preferred` is that of both sides together, -1 where this one decides
        alone.
        """
        ...

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
        """Take in a step, its reward, and what feedback adds to it, or to the value of what was done.

        `watched_step` is the step's number among the watched ones of the session; -1 where nobody watches.
        """
        ...

    def end_episode(self, end: EpisodeEnd) -> None:
        """Take in how an episode ended."""
        ...

    def no_policy(self) -> Floats:
        """Return a theta under which the environment has no say."""
        ...

    def state_digest(self) -> bytes:
        """Return all that has been learned, for fingerprints."""
        ...

    def export(self) -> dict[str, list[float]]:
        """Return what has been learned beside the ranked policies, by name."""
        ...


class TaughtByPresses(Protocol):
    """A side that presses teach directly, not through a human model."""

    def learn_from_credit(self, credit: CreditGiven, value: float) -> None:
        """Learn from how a press of this value was shared out among the steps."""
        ...


class Sides(NamedTuple):
    """An environment's side, and the same one again where presses teach it directly."""

    environment: EnvironmentSide
    taught_by_presses: TaughtByPresses | None


class StepByStep:
    """A learner that changes at every step: each episode is a policy of its own, and none comes back."""

    kind: ClassVar[LearnerKind] = "stepwise"

    def __init__(self, learner: StepwiseLearner) -> None:
        self._learner = learner

    def start_policy(self, start: EpisodeStart) -> StartedPolicy:
        """Begin with what has been learned so far; the episode's number is that of the policy, theta is
        empty.
        """
        self._learner.begin_episode(rng=start.rng)
        return StartedPolicy(start.episode, np.empty(0), proposed=True)

    def values(self, choices: Choices, theta: Floats) -> Floats:
        """Return the learner's values of now."""
        return self._learner.values(choices)

    def act(self, values: Floats, choices: Choices, preferred: int, human: HumanPreference) -> int:
        """Return the preferred action unless the learner explores."""
        return self._learner.act(values, preferred)

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
        """Let the learner learn."""
        self._learner.took(choices, action, reward, shaping=shaping, augmentation=augmentation)

    def end_episode(self, end: EpisodeEnd) -> None:
        """Let the learner learn from the end."""
        self._learner.end_episode(end.time, terminated=end.terminated)

    def no_policy(self) -> Floats:
        """Return an empty theta: the learner goes by what it has learned, which is nothing without
        episodes.
        """
        return np.empty(0)

    def state_digest(self) -> bytes:
        """Return the learner's state."""
        return self._learner.state_digest()

    def export(self) -> dict[str, list[float]]:
        """Return the learner's weights."""
        return self._learner.export()


def environment_sides(learner: EnvironmentLearner | StepwiseLearner, values: Values, scheme: Scheme) -> Sides:
    """Return the interface of any kind of learner.

    Args:
        learner: of the environment.
        values: R of action rows and theta, for policies that are played again.
        scheme: how environment and participant are combined.

    Raises:
        ValueError: the scheme acts on what the learner learns, and this learner cannot be acted on so.
    """
    sides = _sides(learner, values, scheme)
    check_learner(scheme, sides.environment.kind, type(learner).__name__)
    return sides


def _sides(learner: EnvironmentLearner | StepwiseLearner, values: Values, scheme: Scheme) -> Sides:
    if isinstance(learner, StepwiseLearner):
        return Sides(StepByStep(learner), None)
    if isinstance(learner, Actor):
        if isinstance(scheme, Coach):
            coached = Coached(learner, values, scheme)
            return Sides(coached, coached)
        return Sides(Climbing(learner, values), None)
    return Sides(PolicySearch(learner, values), None)
