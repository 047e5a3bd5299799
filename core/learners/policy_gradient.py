"""Policy gradient with a softmax over linear values: GPOMDP and OLPOMDP, plain or natural.

pi(a | s) is proportional to exp(theta . phi(s, a)); the gradient of its mean reward is estimated as the sum
of (r_t - b) e_t with the eligibility trace e_t = beta e_{t-1} + grad log pi(a_t | s_t) (Baxter & Bartlett
2001), b being the running mean reward. The natural gradient premultiplies by the inverse Fisher matrix
(Kakade 2001).
"""

import math
import struct

import msgspec
import numpy as np
from numpy.typing import ArrayLike, NDArray

from core.domain import Choices
from core.learners.contract import Candidate
from core.learners.linear import action_values
from core.learners.policy_gradient_config import PolicyGradientConfig
from core.learners.policy_gradient_kernels import (
    STEPS,
    Memory,
    fill_score,
    invert_positive,
    learn_from_reward,
    remember_score,
)
from core.numerics.arrays import Floats

__all__ = ["PolicyGradient", "PolicyGradientConfig", "PolicyGradientLearner"]


class PolicyGradient:
    """The policy that climbs. The player of an episode hands `memory` to the kernels of each decision."""

    def __init__(self, config: PolicyGradientConfig, *, scales: ArrayLike) -> None:
        """Begin with the uniform policy.

        Args:
            config: settings.
            scales: what each feature is divided by, shape (F,), > 0: so that one step size fits all.
        """
        self.config = config
        self.scales = np.asarray(scales, dtype=np.float64)
        if self.scales.ndim != 1 or not (np.isfinite(self.scales) & (self.scales > 0)).all():
            raise ValueError(f"scales are > 0, one per feature, got {self.scales}")
        n = len(self.scales)
        self.episodes = 0
        """Episodes learned from."""
        self._mean_fisher = np.zeros((n, n))
        self.memory = Memory(
            weights=np.zeros(n),
            trace=np.zeros(n),
            gradient=np.zeros(n),
            fisher=np.zeros((n, n)),
            precondition=np.eye(n),
            numbers=np.zeros(2),
            rates=np.array(
                [
                    config.step_size,
                    config.trace_decay,
                    config.baseline_rate,
                    config.update == "step",
                    config.natural,
                ],
                dtype=np.float64,
            ),
        )

    @property
    def weights(self) -> NDArray[np.float64]:
        """A copy of theta in the features' own units, shape (F,)."""
        return np.asarray(self.memory.weights / self.scales)

    def at_rest(self) -> "PolicyGradient":
        """Return a copy that plays the policy of now and leaves this one as it is."""
        copy = PolicyGradient(msgspec.structs.replace(self.config, step_size=0.0), scales=self.scales)
        copy.memory.weights[:] = self.memory.weights
        return copy

    def begin_episode(self) -> None:
        """Forget the decisions of the episode before: no reward to come is due to them."""
        for array in (self.memory.trace, self.memory.gradient, self.memory.fisher):
            array[...] = 0.0
        self.memory.numbers[STEPS] = 0.0

    def end_episode(self) -> None:
        """Take in the episode: its Fisher matrix and, where the update waits for the end, its gradient."""
        memory = self.memory
        self.episodes += 1
        steps = float(memory.numbers[STEPS])
        if self.config.natural and steps > 0:
            rate = max(self.config.fisher_rate, 1.0 / self.episodes)
            self._mean_fisher += rate * (memory.fisher / steps - self._mean_fisher)
            ridge = self.config.fisher_ridge * np.eye(len(self.scales))
            invert_positive(self._mean_fisher + ridge, memory.precondition)
        if self.config.update == "episode":
            for i, row in enumerate(memory.precondition):
                direction = math.fsum(row * memory.gradient)
                memory.weights[i] += self.config.step_size * direction
        if not np.isfinite(memory.weights).all():
            raise FloatingPointError(
                f"the weights left the finite numbers in episode {self.episodes}: use a smaller step_size "
                f"than {self.config.step_size}"
            )

    def state_bytes(self) -> bytes:
        """Return all that decides about later episodes, for fingerprints."""
        memory = self.memory
        arrays = (memory.weights, memory.trace, memory.gradient, memory.fisher, memory.numbers)
        return struct.pack("<q", self.episodes) + b"".join(
            array.tobytes() for array in (*arrays, memory.precondition, self._mean_fisher)
        )


class PolicyGradientLearner:
    """The method as an agent's learner: a `core.learners.contract.Actor`.

    The policy proposed is the one at the start of the episode. A compiled player may play it by itself and
    learn through `gradient`; then `took` is not called.
    """

    def __init__(self, config: PolicyGradientConfig, *, scales: ArrayLike) -> None:
        self.gradient = PolicyGradient(config, scales=scales)
        self._proposed = Candidate(0, self._frozen_weights())

    def propose(self) -> Candidate:
        """Return the policy of the next episode; the same one again until its performance has been
        reported.
        """
        return self._proposed

    def report(self, policy_id: int, performance: float) -> None:
        """Take in the performance measure of the policy last proposed; the next one has learned since."""
        if policy_id != self._proposed.policy_id:
            raise ValueError(
                f"policy {self._proposed.policy_id} waits for its performance, got one for {policy_id}"
            )
        if not math.isfinite(performance):
            raise ValueError(f"policy {policy_id}: performance is finite, got {performance}")
        self._proposed = Candidate(policy_id + 1, self._frozen_weights())

    def state_digest(self) -> bytes:
        """Return bytes that differ whenever anything differs that decides about later proposals."""
        return struct.pack("<q", self._proposed.policy_id) + self.gradient.state_bytes()

    def begin_episode(self) -> None:
        """Prepare for an episode with the proposal."""
        self.gradient.begin_episode()

    def values(self, choices: Choices) -> Floats:
        """Return R of each action under the weights of now, shape (n,)."""
        return action_values(choices.features / self.gradient.scales, self.gradient.memory.weights)

    def score(
        self, choices: Choices, action: int, *, gains: Floats, probabilities: Floats, reference: int
    ) -> Floats:
        """Return the gradient of log pi(action) by the weights of the scaled features, shape (F,)."""
        rows = choices.features / self.gradient.scales
        out = np.empty(rows.shape[1])
        fill_score(rows, gains, probabilities, len(rows), action, reference, out)
        return out

    def took(self, score: Floats | None, reward: float) -> None:
        """Learn from a decision and the reward of its step."""
        remember_score(self.gradient.memory, np.zeros(len(self.gradient.scales)) if score is None else score)
        learn_from_reward(self.gradient.memory, reward)

    def push(self, direction: Floats) -> None:
        """Move the weights of the scaled features by `direction`, shape (F,)."""
        self.gradient.memory.weights[:] += direction

    def end_episode(self) -> None:
        """Learn from the end of the episode."""
        self.gradient.end_episode()

    def _frozen_weights(self) -> NDArray[np.float64]:
        weights = self.gradient.weights
        weights.flags.writeable = False
        return weights
