"""An environment, features and a factory as a user would write them, for tests."""

from typing import Any, ClassVar

import gymnasium
import numpy as np
from gymnasium import spaces


class Beacon(gymnasium.Env):
    """Go left or right on a line of 9 places until the lamp is reached; observed is a dictionary."""

    observation_space = spaces.Dict({"place": spaces.Discrete(9), "lamp": spaces.Discrete(9)})
    action_space = spaces.Discrete(2, start=5)
    metadata: ClassVar = {"render_modes": ["ansi"]}

    def __init__(self, render_mode: str | None = None) -> None:
        self.render_mode = render_mode

    def reset(self, *, seed: int | None = None, options: Any = None) -> Any:
        super().reset(seed=seed)
        self.place, self.lamp = (int(n) for n in self.np_random.permutation(9)[:2])
        return self._seen(), {}

    def step(self, action: int) -> Any:
        self.place = min(max(self.place + (1 if action == 6 else -1), 0), 8)
        return self._seen(), -1.0, self.place == self.lamp, False, {}

    def render(self) -> str:
        return "".join("x" if n == self.place else "*" if n == self.lamp else "." for n in range(9))

    def _seen(self) -> dict[str, int]:
        return {"place": self.place, "lamp": self.lamp}


class Window:
    """Something that cannot be copied."""

    def __deepcopy__(self, memo: Any) -> Any:
        raise TypeError("windows cannot be copied")


class Uncopied(Beacon):
    def __init__(self, render_mode: str | None = None) -> None:
        super().__init__(render_mode)
        self.window = Window()


def make(render_mode: str | None = None) -> gymnasium.Env:
    return Beacon(render_mode)


def phi(observation: dict[str, int]) -> list[float]:
    return [observation["place"] / 8, observation["lamp"] / 8]


def psi(numbers: tuple[float, ...], action: int) -> Any:
    towards = np.sign(numbers[1] - numbers[0])
    return [towards if action == 1 else -towards, 1.0]


def failing(observation: Any) -> Any:
    raise KeyError("no such part")


def infinite(observation: Any) -> Any:
    return [float("inf")]
