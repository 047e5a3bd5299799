"""Sarsa as an agent's learner: one step at a time, whichever side chooses (`core.learners.contract`)."""

from collections.abc import Callable

import numpy as np

from core.domain import Choices
from core.learners.encoding import active_tiles
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
from core.numerics.arrays import Floats, Ints
from core.numerics.streams import stream
from core.numerics.tile_coding import TileCoder, runs


class SarsaLearner:
    """n learners side by side, each learning from its own decisions, from reward and duration.

    What a decision looks like is `Choices.observation`, tiled by the learner; `Choices.actor` says whose
    decision it is and `Choices.time` when. The reward of an option is the sum of the rewards up to the same
    learner's next decision, each discounted by the time since the option began (semi-Markov: Sutton, Precup &
    Singh 1999).
    """

    def __init__(
        self,
        config: SarsaConfig,
        coder: TileCoder,
        *,
        n_learners: int,
        n_actions: int,
        reward_is_time: bool = False,
        tiled: Callable[[Floats], Floats] | None = None,
    ) -> None:
        """Begin without having learned.

        Args:
            config: of all learners.
            coder: of the observation, or of what `tiled` makes of it.
            n_learners: >= 1.
            n_actions: of each decision, >= 1.
            reward_is_time: the reward of the domain is its own time, unit for unit (Keepaway: each cycle). It
                is then counted in whole units, and the rewards that `took` gets are not needed.
            tiled: what is tiled, made of an observation (tiles over several variables together); the
                observation itself where None.
        """
        self._coder = coder
        self._tiled = tiled
        self.sarsa = new_sarsa(config, coder, n_learners, n_actions, reward_is_time=reward_is_time)
        """Weights, traces and last decisions; kernels change them in place."""
        self._rng = stream(0, "no episode yet")

    def _windows(self, choices: Choices) -> Ints:
        seen = choices.observation
        return active_tiles(self._coder, seen if self._tiled is None else self._tiled(seen))

    def begin_episode(self, *, rng: np.random.Generator) -> None:
        """Take the stream of the episode's exploration: two draws per decision."""
        forget_episode(self.sarsa)
        self._rng = rng

    def values(self, choices: Choices) -> Floats:
        """Return Q(s, a) of the one who decides, in reward still to come, shape (n,)."""
        out = np.empty(len(choices.ruled_out))
        action_values(self.sarsa, choices.actor, self._windows(choices), out)
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
        """Learn from the option that this decision ended; `reward` is part of the options that go on.

        Q augmentation learns the Q for which Q + beta H fits: gamma^t beta H(s', o') - beta H(s, o) is added
        to the reward of option o.
        """
        sarsa, k = self.sarsa, choices.actor
        if sarsa.last_time[k] != NOT_YET:
            passed = float(sarsa.discount) ** int(choices.time - sarsa.last_time[k])
            sarsa.extra[k] += passed * augmentation
        observe_action(sarsa, k, self._windows(choices), action, choices.time)
        sarsa.extra[k] = shaping - augmentation
        if not sarsa.reward_is_time:
            self._earn(reward, choices.time)

    def _earn(self, reward: float, time: int) -> None:
        """Add a reward to every option that goes on, discounted by the time since it began."""
        sarsa = self.sarsa
        for k in np.flatnonzero(sarsa.last_time != NOT_YET):
            sarsa.extra[k] += float(sarsa.discount) ** int(time - sarsa.last_time[k]) * reward

    def end_episode(self, time: int, *, terminated: bool) -> None:
        """Learn from each learner's last option; of an episode that was broken off nothing more is
        learned.
        """
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
        """Return the weights, one learner and action after the other, as runs of equal numbers, and their
        shape.
        """
        starts, values = runs(self.sarsa.weights.ravel())
        shape = [float(length) for length in self.sarsa.weights.shape]
        return {"sarsa-shape": shape, "sarsa-starts": starts.tolist(), "sarsa-values": values.tolist()}
