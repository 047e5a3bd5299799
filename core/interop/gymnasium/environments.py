"""Environments by their names, with what this program can make of their observations and actions."""

import math
import os
import sys
from collections.abc import Callable
from importlib import import_module
from typing import Any

import numpy as np

from core.interop.gymnasium.config import GymnasiumConfig
from core.numerics.tile_coding import Range
from core.plugins import GameError

try:
    import gymnasium
except ImportError as error:  # the extra is not installed
    raise GameError("Gymnasium is not installed: pip install 'arl-tui[gym]'") from error

MOST_NUMBERS = 64
"""Of an observation: more are an image, and tiles of single pixels say nothing."""
UNBOUNDED = 1e6
"""Bounds beyond are taken for none."""
Numbers = tuple[float, ...]


def make_env(name: str, **settings: Any) -> Any:
    """Return an environment by its id, or by `module:function`, without a time limit of Gymnasium's.

    Raises:
        GameError: there is none, or it cannot be made.
    """
    try:
        if is_function(name):
            return named_function(name)(**settings)
        return gymnasium.make(name, max_episode_steps=-1, disable_env_checker=True, **settings)
    except Exception as error:
        raise GameError(
            f"the environment {name!r} cannot be made: {type(error).__name__}: {error}"
        ) from error


def is_function(name: str) -> bool:
    """Return whether a name is `module:function`, not an id of Gymnasium."""
    return ":" in name and not name.rpartition("-v")[2].isdigit()


def named_function(name: str) -> Callable[..., Any]:
    """Return the function that `module:function` names; modules in the present folder are found as well.

    Raises:
        GameError: there is none.
    """
    module, _, function = name.partition(":")
    if os.getcwd() not in sys.path:
        sys.path.append(os.getcwd())
    try:
        found = getattr(import_module(module), function)
    except (ImportError, AttributeError, ValueError) as error:
        raise GameError(
            f"there is no function {name!r}: {error}. It is named module:function, and the module lies in "
            f"the present folder ({os.getcwd()}) or is installed"
        ) from error
    if not callable(found):
        raise GameError(f"{name} is a {type(found).__name__}, not a function")
    return found  # type: ignore[no-any-return]


def discrete_actions(env: Any, name: str) -> tuple[int, int]:
    """Return the first action's number and how many there are.

    Raises:
        GameError: the actions are not discrete.
    """
    space = env.action_space
    if not isinstance(space, gymnasium.spaces.Discrete):
        raise GameError(
            f"{name} has the actions {space}: only discrete ones can be learned here. Needed is a "
            f"wrapper that offers some of them as Discrete(n), named as module:function "
            f"(docs/how-to/own-environment.md)"
        )
    return int(space.start), int(space.n)


class Seen:
    """How observations become numbers: as they are, or by the user's phi."""

    def __init__(self, env: Any, config: GymnasiumConfig) -> None:
        """Look at what an environment gives.

        Raises:
            GameError: it gives what is neither numbers nor made into numbers.
        """
        self._name = config.env
        self._phi = named_function(config.phi) if config.phi else None
        self.whole = False
        """Whether the observation is one whole number: a state that is not like its neighbours."""
        if self._phi is None:
            self.ranges = self._ranges_of(env.observation_space, config)
            self.names = tuple(f"observation {i}" for i in range(len(self.ranges)))
        else:
            n = len(self.numbers(env.reset(seed=0)[0]))
            self.ranges = (Range(0.0, 1.0, 1.0 / config.tiles),) * n
            self.names = tuple(f"phi {i}" for i in range(n))

    def numbers(self, observation: Any) -> Numbers:
        """Return an observation as numbers.

        Raises:
            GameError: phi failed, or a number is not finite.
        """
        if self._phi is not None:
            try:
                observation = self._phi(observation)
            except Exception as error:
                raise GameError(
                    f"phi failed: {type(error).__name__}: {error}, given {observation!r}"
                ) from error
        numbers = tuple(float(number) for number in np.ravel(observation))
        if not numbers or not all(map(math.isfinite, numbers)):
            by = "phi" if self._phi is not None else self._name
            raise GameError(f"{by} gave {numbers}: at least one number is expected, and finite ones")
        return numbers

    def _ranges_of(self, space: Any, config: GymnasiumConfig) -> tuple[Range, ...]:
        """Return the range of each number of an observation, and how wide its tiles are."""
        if isinstance(space, gymnasium.spaces.Discrete):
            self.whole = True
            return (Range(float(space.start), float(space.start + space.n), 1.0),)
        if not isinstance(space, gymnasium.spaces.Box) or int(np.prod(space.shape)) > MOST_NUMBERS:
            raise GameError(
                f"{config.env} has the observations {space}: a box of at most {MOST_NUMBERS} numbers or a "
                f"discrete one is needed. Name a function that makes numbers from 0 to 1 of it "
                f'([domain] phi = "module:function"; docs/how-to/own-environment.md)'
            )
        most = config.largest
        low = np.where(np.abs(space.low) > UNBOUNDED, -most, space.low).astype(float).ravel()
        high = np.where(np.abs(space.high) > UNBOUNDED, most, space.high).astype(float).ravel()
        return tuple(
            Range(below, above, (above - below) / config.tiles)
            if above > below
            else Range(below, below + 1.0, 1.0)
            for below, above in zip(low.tolist(), high.tolist(), strict=True)
        )
