"""States of an environment by its seed and the actions since: one environment goes on where it stands.

A session goes on from where the environment stands, which costs one step of it. A simulated participant
asks what another action would have led to. A copy of the environment answers, or the episode is played again:
whichever is faster, and the latter where the environment cannot be copied.
"""

import copy
import math
from dataclasses import dataclass, field
from typing import Any

from core.numerics.clock import MonotonicClock
from core.plugins import GameError

Outcome = tuple[Any, float, bool]
"""Observation, reward, and whether the episode is over."""
LARGEST_SEED = 2**31
LARGEST_REWARD = 1e100
"""Sums of rewards, and their squares, stay finite below it."""


@dataclass(slots=True, eq=False)
class Node:
    """A state by how it came about. What followed is remembered: a second question costs nothing."""

    seed: int
    before: "Node | None" = None
    action: int = -1
    depth: int = 0
    """Steps since the episode began."""
    known: dict[int, tuple["Node", Outcome]] = field(default_factory=dict)
    """What each action that was taken here led to."""

    def actions(self) -> list[int]:
        """Return the actions since the episode began, in order."""
        node, found = self, []
        while node.before is not None:
            found.append(node.action)
            node = node.before
        return found[::-1]


class States:
    """All states of one environment."""

    def __init__(self, env: Any, name: str) -> None:
        """Take the environment; nothing else may step it.

        It is copied once, to see whether it can be.

        Args:
            env: the environment.
            name: as in the protocol, for messages.
        """
        self._env = env
        self._name = name
        self._stands: Node | None = None
        clock = MonotonicClock()
        began_ns = clock.now_ns()
        try:
            self._side: Any = copy.deepcopy(env)
        except Exception:  # noqa: BLE001 - whatever a foreign environment raises
            self._side = None
        self._copy_ns = clock.now_ns() - began_ns
        self._step_ns = 0
        """The longest step so far: for the choice between a copy and playing again."""
        self._side_stands: Node | None = None
        self._clock = clock

    @property
    def copied(self) -> bool:
        """Whether the environment can be copied."""
        return self._side is not None

    def begin(self, episode_seed: int) -> tuple[Node, Any]:
        """Return the first state of an episode (seed >= 0), and what is seen in it.

        Raises:
            GameError: the environment fails.
        """
        node = Node(episode_seed)
        self._stands = None
        observation = self._reset(self._env, node)
        self._stands = node
        return node, observation

    def step(self, state: Node, action: int) -> Outcome:
        """Return what an action leads to; `after` is the state itself. `state` stays as it was.

        Raises:
            GameError: the environment fails, or its reward is no finite number.
        """
        if action not in state.known:
            if self._stands is state:
                self._stands = None  # until the step has been made
                self._go_on(self._env, state, action)
                self._stands = state.known[action][0]
            elif self.copied:
                self._aside(state, action)
            else:
                self._stands = None
                self._reset(self._env, state)
                self._go_on(self._env, state, action)
                self._stands = state.known[action][0]
        return state.known[action][1]

    def after(self, state: Node, action: int) -> Node:
        """Return the state that an action has led to, once `step` has been asked."""
        return state.known[action][0]

    def _aside(self, state: Node, action: int) -> None:
        """Answer with the second environment, so that the first one stands where it stood."""
        if self._side_stands is not state:
            self._side_stands = None
            self._reset(self._side, state)
            self._side_stands = state
        if self._copy_ns < state.depth * self._step_ns:
            self._go_on(copy.deepcopy(self._side), state, action)
        else:
            self._side_stands = None
            self._go_on(self._side, state, action)
            self._side_stands = state.known[action][0]

    def _reset(self, env: Any, state: Node) -> Any:
        """Play an episode up to a state; return what is seen at its beginning."""
        try:
            observation, _ = env.reset(seed=state.seed % LARGEST_SEED)
            observation = copy.deepcopy(observation)
            for taken in state.actions():
                env.step(taken)
        except Exception as error:
            raise GameError(self._failed(state, "reset(seed=...)", "(observation, info)", error)) from error
        return observation

    def _go_on(self, env: Any, state: Node, action: int) -> None:
        began_ns = self._clock.now_ns()
        try:
            observation, reward, terminated, truncated, _ = env.step(action)
            self._step_ns = max(self._step_ns, self._clock.now_ns() - began_ns)
            # A copy: some environments write the next observation into the same array.
            outcome = copy.deepcopy(observation), float(reward), bool(terminated or truncated)
        except Exception as error:
            expected = "(observation, reward, terminated, truncated, info)"
            raise GameError(self._failed(state, f"step({action})", expected, error)) from error
        if not math.isfinite(outcome[1]) or abs(outcome[1]) > LARGEST_REWARD:
            raise GameError(
                f"{self._name} gave the reward {outcome[1]} for action {action} at step {state.depth} of the "
                f"episode with seed {state.seed % LARGEST_SEED}: a number from -{LARGEST_REWARD:g} to "
                f"{LARGEST_REWARD:g} is expected. Correct the environment, or wrap it in one that does"
            )
        state.known[action] = Node(state.seed, state, action, state.depth + 1), outcome

    def _failed(self, state: Node, call: str, expected: str, error: Exception) -> str:
        return (
            f"{self._name} cannot be played: {call} at step {state.depth} of the episode with seed "
            f"{state.seed % LARGEST_SEED} failed with {type(error).__name__}: {error}. Expected is {expected}"
        )
