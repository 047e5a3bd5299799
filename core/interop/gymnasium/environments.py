"""Environments by their names, with what this program can make of their observations and actions."""

import difflib
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
MOST_WEIGHTS = 2**27
"""Of a learner: tiles times actions, a gigabyte."""
MOST_ACTIONS = 10_000
"""Of an environment: every decision weighs each of them."""
Numbers = tuple[float, ...]
PAGE = "docs/how-to/own-environment.md"
"""What an environment needs."""


def make_env(name: str, **settings: Any) -> Any:
    """Return an environment by its id, or by `module:function`, without a time limit of Gymnasium's.

    Raises:
        GameError: there is none, or it cannot be made.
    """
    try:
        if is_function(name):
            made = named_function(name)(**settings)
        else:
            made = gymnasium.make(name, max_episode_steps=-1, disable_env_checker=True, **settings)
    except GameError:
        raise
    except (gymnasium.error.UnregisteredEnv, gymnasium.error.DeprecatedEnv) as error:
        raise GameError(_unknown(name, error)) from error
    except Exception as error:
        raise GameError(
            f"the environment {name!r} cannot be made: {type(error).__name__}: {error}. {_called(settings)}"
            if is_function(name)
            else f"the environment {name!r} cannot be made: {type(error).__name__}: {error}"
        ) from error
    if not isinstance(made, gymnasium.Env):
        raise GameError(
            f"{name} gave a {type(made).__name__}: expected is a gymnasium.Env. The function has to return "
            f"the environment ({PAGE})"
        )
    return made


def _unknown(name: str, error: Exception) -> str:
    """Return that Gymnasium has no such environment, and which one is nearest."""
    if "/" in name and isinstance(error, gymnasium.error.NamespaceNotFound):
        return (
            f"the environment {name!r} cannot be made: {error} Install it, and name the module that "
            f'registers it: "module:{name}"'
        )
    found = f"Gymnasium {gymnasium.__version__} has no environment {name!r}"
    base = name.rpartition("-v")[0]
    same = [other for other in gymnasium.registry if other.rpartition("-v")[0] == base]
    near = sorted(same, key=_version)[-1:] or difflib.get_close_matches(name, gymnasium.registry, n=1)
    if not near:
        return f"{found}. An environment of your own is named module:function ({PAGE})"
    return f'{found}: the nearest is {near[0]}. Say `arl play gymnasium:{near[0]}`, or env = "{near[0]}"'


def _version(name: str) -> int:
    version = name.rpartition("-v")[2]
    return int(version) if version.isdigit() else -1


def _called(settings: dict[str, Any]) -> str:
    given = ", ".join(f"{key}={value!r}" for key, value in settings.items())
    return f"It was called as a factory, with ({given}): it has to return an environment ({PAGE})"


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
            f"wrapper that offers some of them as Discrete(n), named as module:function ({PAGE})"
        )
    if space.n > MOST_ACTIONS:
        raise GameError(
            f"{name} has {int(space.n):,} actions; the most is {MOST_ACTIONS:,}. Needed is a wrapper that "
            f"offers some of them as Discrete(n), named as module:function ({PAGE})"
        )
    return int(space.start), int(space.n)


def check_size(n_tiles: int, n_actions: int, name: str) -> None:
    """Refuse more weights than fit into memory.

    Raises:
        GameError: they are more than `MOST_WEIGHTS`.
    """
    if n_tiles * n_actions > MOST_WEIGHTS:
        raise GameError(
            f"{name} needs {n_tiles:,} tiles for each of {n_actions:,} actions; the most in all is "
            f"{MOST_WEIGHTS:,}. Choose fewer tiles ([learner.encoder]), or name a function that makes few "
            f'numbers from 0 to 1 of its observation ([domain] phi = "module:function"; {PAGE})'
        )


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
            self._n = 0
            n = len(self.numbers(first_observation(env, config.env)))
            self.ranges = (Range(0.0, 1.0, 1.0 / config.tiles),) * n
            self.names = tuple(f"phi {i}" for i in range(n))
        self._n = len(self.ranges)

    def numbers(self, observation: Any) -> Numbers:
        """Return an observation as numbers.

        Raises:
            GameError: phi failed, or a number is not finite, or there are more or fewer than before.
        """
        if self._phi is not None:
            try:
                observation = self._phi(observation)
            except Exception as error:
                raise GameError(
                    f"phi failed: {type(error).__name__}: {error}, given {observation!r}"
                ) from error
        by = "phi" if self._phi is not None else self._name
        try:
            numbers = tuple(float(number) for number in np.ravel(observation))
        except (TypeError, ValueError) as error:
            raise GameError(f"{by} gave {observation!r}: numbers are expected") from error
        if not numbers or not all(map(math.isfinite, numbers)):
            raise GameError(f"{by} gave {numbers}: at least one number is expected, and finite ones")
        if self._n and len(numbers) != self._n:
            known = "at first" if self._phi is not None else "its observation space says"
            raise GameError(
                f"{by} gave {len(numbers)} numbers, {numbers}: {self._n} are expected, as {known}"
            )
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
                f'([domain] phi = "module:function"; {PAGE})'
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


def first_observation(env: Any, name: str) -> Any:
    """Return what is seen when an episode with seed 0 begins.

    Raises:
        GameError: the episode does not begin.
    """
    try:
        observation, _ = env.reset(seed=0)
    except Exception as error:
        raise GameError(
            f"{name} cannot be played: reset(seed=0) failed with {type(error).__name__}: {error}. Expected "
            f"is (observation, info)"
        ) from error
    return observation
