"""Sarsa as an agent's learner: one step at a time, whoever chooses the action (`core.learners.contract`)."""

import numpy as np
from numpy.typing import NDArray

from core.domain import Choices
from core.learners.sarsa import (
    NOT_YET,
    SarsaConfig,
    action_values,
    best_or_tied,
    end_episode,
    forget_episode,
    new_sarsa,
    observe_action,
)
from core.numerics.streams import stream
from core.numerics.tile_coding import TileCoder, runs

Floats = NDArray[np.float64]


class SarsaLearner:
    """n learners side by side, each learning from its own decisions; rewards are the domain's own time that passed.

    The features of a decision are the first active tiles of the state, the same for each action; `Choices.actor` says
    whose decision it is and `Choices.time` when.
    """

    def __init__(self, config: SarsaConfig, coder: TileCoder, *, n_learners: int, n_actions: int) -> None:
        self.sarsa = new_sarsa(config, coder, n_learners, n_actions)
        """Weights, traces and last decisions; kernels change them in place."""
        self._rng = stream(0, "no episode yet")

    def begin_episode(self, *, rng: np.random.Generator) -> None:
        """Take the stream of the episode's exploration: two draws per decision."""
        forget_episode(self.sarsa)
        self._rng = rng

    def values(self, choices: Choices) -> Floats:
        """Return Q(s, a) of the one who decides, in cycles still to come, shape (n,)."""
        out = np.empty(len(choices.features))
        action_values(self.sarsa, choices.actor, _windows(choices), out)
        return out

    def act(self, values: Floats, preferred: int) -> int:
        """Return the preferred action, or the best one where there is none; with probability epsilon any."""
        explore, pick = self._rng.random(), self._rng.random()
        if explore < self.sarsa.exploration:
            return int(pick * len(values))
        return int(best_or_tied(values, pick)) if preferred < 0 else preferred

    def took(
        self,
        choices: Choices,
        action: int,
        reward: float,
        *,
        shaping: float = 0.0,
        augmentation: float = 0.0,
    ) -> None:
        """Learn from the option that this decision ended; the reward is the time since, `reward` is not needed.

        Q augmentation learns the Q for which Q + beta H fits: gamma^t beta H(s', o') - beta H(s, o) is added to the reward
        of option o.
        """
        sarsa, k = self.sarsa, choices.actor
        if sarsa.last_time[k] != NOT_YET:
            passed = float(sarsa.discount) ** int(choices.time - sarsa.last_time[k])
            sarsa.extra[k] += passed * augmentation
        observe_action(sarsa, k, _windows(choices), action, choices.time)
        sarsa.extra[k] = shaping - augmentation

    def end_episode(self, time: int, *, terminated: bool) -> None:
        """Learn from each learner's last option; of an episode that was broken off nothing more is learned."""
        if terminated:
            end_episode(self.sarsa, time)
        else:
            forget_episode(self.sarsa)

    def state_digest(self) -> bytes:
        """Return weights, traces and the decisions that are still open."""
        sarsa = self.sarsa
        still_open = np.flatnonzero(sarsa.last_time != NOT_YET)
        parts = (
            sarsa.weights,
            sarsa.traces,
            sarsa.last_time,
            sarsa.extra,
            sarsa.last_action[still_open],
            sarsa.windows[still_open],
        )
        return b"".join(np.ascontiguousarray(part).tobytes() for part in parts)

    def export(self) -> dict[str, list[float]]:
        """Return the weights, one learner and action after the other, as runs of equal numbers, and their shape."""
        starts, values = runs(self.sarsa.weights.ravel())
        shape = [float(length) for length in self.sarsa.weights.shape]
        return {"sarsa-shape": shape, "sarsa-starts": starts.tolist(), "sarsa-values": values.tolist()}


def _windows(choices: Choices) -> NDArray[np.int64]:
    windows: NDArray[np.int64] = choices.features[0].astype(np.int64)
    return windows
