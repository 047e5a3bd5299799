"""States of an environment: copies of it, or its seed and the actions since, where it cannot be copied."""

import copy
from dataclasses import dataclass
from typing import Any

Outcome = tuple[Any, float, bool]
"""Observation, reward, and whether the episode is over."""
LARGEST_SEED = 2**31


class Copies:
    """Each state is a copy of the environment; only copies are stepped."""

    def __init__(self, env: Any) -> None:
        self._env = env

    def begin(self, episode_seed: int) -> tuple[Any, Any]:
        """Return the first state of an episode, and what is seen in it."""
        env = copy.deepcopy(self._env)
        observation, _ = env.reset(seed=episode_seed % LARGEST_SEED)
        return env, observation

    def step(self, state: Any, action: int) -> tuple[Any, Outcome]:
        """Return where an action leads; `state` stays as it was."""
        env = copy.deepcopy(state)
        return env, _step(env, action)


@dataclass(frozen=True, slots=True, eq=False)
class Node:
    """A state by how it came about."""

    seed: int
    before: "Node | None"
    action: int

    def actions(self) -> list[int]:
        """Return the actions since the episode began, in order."""
        node, found = self, []
        while node.before is not None:
            found.append(node.action)
            node = node.before
        return found[::-1]


class Replays:
    """A state is a seed and actions; the one environment is played again where it stands elsewhere.

    Going on from where it stands costs one step, as a session does; anything else costs the episode so far.
    """

    def __init__(self, env: Any) -> None:
        self._env = env
        self._stands: Node | None = None

    def begin(self, episode_seed: int) -> tuple[Any, Any]:
        """Return the first state of an episode, and what is seen in it."""
        node = Node(episode_seed, None, -1)
        observation, _ = self._env.reset(seed=episode_seed % LARGEST_SEED)
        self._stands = node
        return node, observation

    def step(self, state: Node, action: int) -> tuple[Any, Outcome]:
        """Return where an action leads; `state` stays as it was."""
        if self._stands is not state:
            self._env.reset(seed=state.seed % LARGEST_SEED)
            for taken in state.actions():
                self._env.step(taken)
        self._stands = None  # until the step has been made
        outcome = _step(self._env, action)
        self._stands = Node(state.seed, state, action)
        return self._stands, outcome


def _step(env: Any, action: int) -> Outcome:
    observation, reward, terminated, truncated, _ = env.step(action)
    return observation, float(reward), bool(terminated or truncated)
