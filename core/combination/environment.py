"""The environment's side of an agent: one interface over learners that search and learners that learn at every step.

`core.combination.agent` asks this side for values and actions and never knows which kind it has.
"""

from typing import Protocol

import numpy as np

from core.combination.climbing import Climbing
from core.combination.config import Coach, Scheme
from core.combination.schemes import best_action
from core.combination.sides import Drawn, Ending, Floats, Heard
from core.combination.window import Values
from core.domain import Choices
from core.episode import CreditGiven
from core.learners.contract import Actor, EnvironmentLearner, StepwiseLearner


class EnvironmentSide(Protocol):
    """What an agent asks of its environment learner."""

    def begin_episode(
        self, episode: int, draw: Drawn | None, *, rng: np.random.Generator
    ) -> tuple[int, Floats, bool]:
        """Return number and theta of the policy of this episode, and whether it is the learner's new proposal.

        Args:
            episode: number of the episode in the session.
            draw: how to play one of the ranked policies instead of a proposal; None where a proposal is asked for.
            rng: of the exploration within the episode.
        """
        ...

    def values(self, choices: Choices, theta: Floats) -> Floats:
        """Return R of each action under the policy theta, shape (n,)."""
        ...

    def act(self, values: Floats, choices: Choices, preferred: int, heard: Heard) -> int:
        """Return the action to take; `preferred` is that of both sides together, -1 where this one decides alone."""
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

    def press(self, credit: CreditGiven, value: float) -> None:
        """Hear how a press was shared out among the steps: for those whom presses teach directly."""
        ...

    def end_episode(self, policy_id: int, played: Ending, *, proposed: bool) -> None:
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


class PolicySearch:
    """A learner that proposes a policy for a whole episode: good ones can be played again."""

    def __init__(self, learner: EnvironmentLearner, values: Values) -> None:
        self._learner = learner
        self._values = values

    def begin_episode(
        self, episode: int, draw: Drawn | None, *, rng: np.random.Generator
    ) -> tuple[int, Floats, bool]:
        """Return a ranked policy where `draw` is given, else the learner's proposal."""
        if draw is not None:
            return *draw(), False
        candidate = self._learner.propose()
        return candidate.policy_id, candidate.weights, True

    def values(self, choices: Choices, theta: Floats) -> Floats:
        """Return the features times theta."""
        return self._values(choices.features, theta)

    def act(self, values: Floats, choices: Choices, preferred: int, heard: Heard) -> int:
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
        """Do nothing: this learner hears of whole episodes only."""

    def press(self, credit: CreditGiven, value: float) -> None:
        """Do nothing: presses reach this learner through the human model."""

    def end_episode(self, policy_id: int, played: Ending, *, proposed: bool) -> None:
        """Tell the learner how its proposal did."""
        if proposed:
            self._learner.report(policy_id, played.performance)

    def no_policy(self) -> Floats:
        """Return zeros."""
        return np.zeros_like(self._learner.propose().weights)

    def state_digest(self) -> bytes:
        """Return the learner's state."""
        return self._learner.state_digest()

    def export(self) -> dict[str, list[float]]:
        """Return nothing: the ranked policies are what has been learned."""
        return {}


class StepByStep:
    """A learner that changes at every step: each episode is a policy of its own, and none comes back."""

    def __init__(self, learner: StepwiseLearner) -> None:
        self._learner = learner

    def begin_episode(
        self, episode: int, draw: Drawn | None, *, rng: np.random.Generator
    ) -> tuple[int, Floats, bool]:
        """Begin with what has been learned so far; the episode's number is that of the policy, theta is empty."""
        self._learner.begin_episode(rng=rng)
        return episode, np.empty(0), True

    def values(self, choices: Choices, theta: Floats) -> Floats:
        """Return the learner's values of now."""
        return self._learner.values(choices)

    def act(self, values: Floats, choices: Choices, preferred: int, heard: Heard) -> int:
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

    def press(self, credit: CreditGiven, value: float) -> None:
        """Do nothing: presses reach this learner through the human model."""

    def end_episode(self, policy_id: int, played: Ending, *, proposed: bool) -> None:
        """Let the learner learn from the end."""
        self._learner.end_episode(played.time, terminated=played.ended == "termination")

    def no_policy(self) -> Floats:
        """Return an empty theta: the learner goes by what it has learned, which is nothing without episodes."""
        return np.empty(0)

    def state_digest(self) -> bytes:
        """Return the learner's state."""
        return self._learner.state_digest()

    def export(self) -> dict[str, list[float]]:
        """Return the learner's weights."""
        return self._learner.export()


def environment_side(
    learner: EnvironmentLearner | StepwiseLearner, values: Values, scheme: Scheme
) -> EnvironmentSide:
    """Return the interface of any kind of learner.

    Args:
        learner: of the environment.
        values: R of action rows and theta, for policies that are played again.
        scheme: how environment and human are combined.

    Raises:
        ValueError: the scheme acts on what the learner learns, and this learner cannot be acted on so.
    """
    name = scheme.__struct_config__.tag
    coach = scheme if isinstance(scheme, Coach) else None
    if isinstance(learner, StepwiseLearner):
        if coach is not None:
            raise ValueError(f"scheme {name} needs a learner with a softmax policy: policy gradient")
        return StepByStep(learner)
    if name == "q-augmentation":
        raise ValueError(f"scheme {name} needs a learner of action values that learns at every step: Sarsa")
    if isinstance(learner, Actor):
        return Climbing(learner, values, coach)
    if coach is not None or name == "reward-shaping":
        raise ValueError(
            f"scheme {name} acts on what the learner learns from each step; one that hears of whole episodes only, "
            "such as cross-entropy, has nothing to act on"
        )
    return PolicySearch(learner, values)
