"""From a session's steps to pictures of an environment: it is played again, and draws itself."""

from collections.abc import Callable
from io import StringIO
from typing import Any

import numpy as np

from arl_tui.games.rendering import Place, TickView
from core.events import EpisodeStarted, StepTaken
from core.interop.gymnasium.action import EnvAction
from core.interop.gymnasium.picture import NO_ACTION, EnvPicture, smaller
from core.plugins import GameError

WIDEST, HIGHEST = 126, 120
"""Pixels of a picture: what a large terminal has room for, two rows of pixels in a line. The panel makes it
smaller where there is less."""


class GymnasiumRenderer:
    """Draws an environment of which only seeds and actions are known."""

    def __init__(self, env: str, tick_ns: int) -> None:
        """Make the environment in the mode in which it draws itself.

        Args:
            env: as in the protocol.
            tick_ns: how long a step is shown.

        Raises:
            GameError: it draws neither pictures (rgb_array) nor text (ansi).
        """
        self.tick_ns = tick_ns
        self._name = env
        self._env = _drawing(env)
        self._action = NO_ACTION
        self._reward = 0.0
        self._steps = 0
        self.picture = self._look()

    def begin(self, episode: EpisodeStarted) -> tuple[TickView, ...]:
        """Return the first picture.

        Raises:
            GameError: the environment fails.
        """
        self._reward, self._steps, self._action = 0.0, 0, NO_ACTION
        self.picture = self._look_after(lambda: self._env.reset(seed=episode.episode_seed % 2**31))
        return (TickView(self.picture),)

    def act(self, step: StepTaken) -> tuple[TickView, ...]:
        """Return the picture after a step.

        Raises:
            GameError: the environment fails.
        """
        self._action = EnvAction.of(step).action
        self._reward += step.reward
        self._steps += 1
        self.picture = self._look_after(lambda: self._env.step(self._action))
        return (TickView(self.picture),)

    def judged_after_ns(self, n_ticks: int) -> int:
        """Return 0: what a step led to is seen at once."""
        return 0

    def place_of(self, step: int) -> Place:
        """Return nothing: an environment does not say where an action is to be seen."""
        return ()

    def _look_after(self, change: Callable[[], object]) -> EnvPicture:
        try:
            change()
            return self._look()
        except Exception as error:
            raise GameError(
                f"{self._name} cannot be shown: at step {self._steps} it failed with {type(error).__name__}: "
                f"{error}"
            ) from error

    def _look(self) -> EnvPicture:
        drawn = _drawn(self._env)
        if isinstance(drawn, str):
            return EnvPicture(text=drawn, reward=self._reward, steps=self._steps, action=self._action)
        small = smaller(drawn, WIDEST, HIGHEST)
        return EnvPicture(
            width=small.shape[1],
            height=small.shape[0],
            pixels=small.tobytes(),
            reward=self._reward,
            steps=self._steps,
            action=self._action,
        )


def _drawn(env: Any) -> Any:
    """Return an environment's text, or its picture of shape (height, width, 3 or more).

    Raises:
        ValueError: it draws neither.
    """
    drawn = env.render()
    if isinstance(drawn, str):
        return drawn
    if isinstance(drawn, StringIO):
        return drawn.getvalue()
    picture = np.asarray(drawn)
    if picture.ndim != 3 or picture.shape[2] < 3 or not np.issubdtype(picture.dtype, np.number):
        what = "nothing" if drawn is None else f"{type(drawn).__name__} of shape {picture.shape}"
        raise ValueError(f"render() gave {what}: text, or pixels of shape (height, width, 3), is expected")
    return picture


def _drawing(env: str) -> Any:
    problems = []
    from core.interop.gymnasium.environments import make_env  # here, not above: compiled code comes with it

    for mode in ("rgb_array", "ansi"):
        try:
            made = make_env(env, render_mode=mode)
            made.reset(seed=0)
            _drawn(made)
            return made
        except Exception as error:  # noqa: BLE001 - whatever a foreign environment raises
            problems.append(f'with render_mode="{mode}": {error}')
    raise GameError(
        f"{env} cannot be shown. {'; '.join(problems)}. Needed is a render() that gives pixels "
        f"(rgb_array) or text (ansi); without one it can be simulated and replayed "
        f"(docs/how-to/own-environment.md)"
    )
