"""The environment's side of an agent whose learner is an actor: its softmax is drawn from together with the
participant's say.

Where presses are to teach the actor itself (COACH, MacGlashan et al. 2017), this side keeps the trace that
each watched step left: theta <- theta + alpha f e.
"""

from collections import deque
from typing import ClassVar

import numpy as np

from core.combination.config import Coach
from core.combination.policy_search import PolicySearch
from core.combination.preference import fill_logits
from core.combination.sides import EpisodeEnd, EpisodeStart, HumanPreference, StartedPolicy
from core.combination.window import Values
from core.domain import Choices
from core.events import CreditGiven
from core.learners.contract import Actor
from core.learners.kinds import LearnerKind
from core.numerics.arrays import Floats
from core.numerics.counters import uniform_at
from core.numerics.softmax import drawn, softmax

KEPT_TRACES = 256
"""Watched steps whose traces are kept: a press is never credited to one so long ago."""


class Climbing(PolicySearch):
    """A learner whose proposal is a softmax policy that learns while it is played; good ones can be played
    again.
    """

    kind: ClassVar[LearnerKind] = "climbing"

    def __init__(self, learner: Actor, values: Values) -> None:
        super().__init__(learner, values)
        self._actor = learner
        self._climbs = False
        # Of the decision at hand: (gains, probabilities, reference), None where the policy did not decide.
        self._softmax: tuple[Floats, Floats, int] | None = None

    def start_policy(self, start: EpisodeStart) -> StartedPolicy:
        """Return a ranked policy where one may be drawn, else the learner's proposal, which then learns."""
        self._climbs = start.draw is None
        self._softmax = None
        if self._climbs:
            self._actor.begin_episode()
        return super().start_policy(start)

    def values(self, choices: Choices, theta: Floats) -> Floats:
        """Return the learner's values of now; of a ranked policy the features times theta."""
        return self._actor.values(choices) if self._climbs else super().values(choices, theta)

    def act(self, values: Floats, choices: Choices, preferred: int, human: HumanPreference) -> int:
        """Draw from the softmax of f(R, H); a ranked policy, and a participant who decides alone, take the
        best action.
        """
        n = len(values)
        self._softmax = None
        weights = human.episode_weights
        if human.handed_over or not self._climbs or weights.w_r == 0.0:
            return super().act(values, choices, preferred, human)
        logits, gains, probabilities = np.empty(n), np.empty(n), np.empty(n)
        reference = fill_logits(
            values,
            human.human_values,
            choices.ruled_out,
            n,
            weights.form,
            weights.w_r,
            weights.w_h,
            logits,
            gains,
        )
        softmax(logits, choices.ruled_out, n, probabilities)
        self._softmax = (gains, probabilities, reference)
        return int(drawn(probabilities, n, uniform_at(human.chance_seed, human.step)))

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
        """Let the learner learn, whichever side chose the action."""
        if self._climbs:
            self._actor.took(self._score(choices, action), reward + shaping)

    def end_episode(self, end: EpisodeEnd) -> None:
        """Let the learner learn from the end, and tell it how its proposal did."""
        if end.proposed:
            self._actor.end_episode()
        super().end_episode(end)

    def export(self) -> dict[str, list[float]]:
        """Return the policy as it is now."""
        return {"actor": self._actor.propose().weights.tolist()}

    def _score(self, choices: Choices, action: int) -> Floats | None:
        """Return grad log pi of the decision at hand; None where the policy did not decide."""
        if self._softmax is None:
            return None
        gains, probabilities, reference = self._softmax
        return self._actor.score(
            choices, action, gains=gains, probabilities=probabilities, reference=reference
        )


class Coached(Climbing):
    """The same, and presses move the policy themselves (COACH): each watched step leaves its trace of grad
    log pi.
    """

    def __init__(self, learner: Actor, values: Values, coach: Coach) -> None:
        super().__init__(learner, values)
        self._coach = coach
        self._trace = np.zeros(0)
        # After each watched step, by the number that presses know it by.
        self._traces: deque[tuple[int, Floats]] = deque(maxlen=KEPT_TRACES)

    def start_policy(self, start: EpisodeStart) -> StartedPolicy:
        """Begin an episode with a trace of its own."""
        self._trace = np.zeros(0)
        return super().start_policy(start)

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
        """Keep the trace of the step, and let the learner learn from its reward where that is asked for."""
        if not self._climbs:
            return
        score = self._score(choices, action)
        self._remember(score, choices.features.shape[1], watched_step)
        if self._coach.environment_too:
            self._actor.took(score, reward + shaping)

    def learn_from_credit(self, credit: CreditGiven, value: float) -> None:
        """Move the policy toward what was praised, away from what was blamed, by each step's share."""
        shares = dict(zip(credit.steps, credit.shares, strict=True))
        for step, trace in self._traces:
            if step in shares:
                self._actor.push(self._coach.step_size * value * shares[step] * trace)

    def state_digest(self) -> bytes:
        """Return the learner's state and the traces that presses can still reach."""
        return super().state_digest() + b"".join(trace.tobytes() for _, trace in self._traces)

    def _remember(self, score: Floats | None, n_features: int, watched_step: int) -> None:
        """Add this step to the trace of grad log pi, and keep the trace after a watched one."""
        before = self._trace if len(self._trace) else np.zeros(n_features)
        self._trace = self._coach.trace_decay * before + (np.zeros(n_features) if score is None else score)
        if watched_step >= 0:
            self._traces.append((watched_step, self._trace))
