"""From a session's steps to pictures of an environment: it is played again, and draws itself."""

from typing import Any

import numpy as np

from arl_tui.games.rendering import Place, TickView
from core.events import EpisodeStarted, StepTaken
from core.interop.gymnasium.action import EnvAction
from core.interop.gymnasium.picture import EnvPicture
from core.plugins import GameError

WIDEST, HIGHEST = 42, 40
"""Pixels of a picture: the smallest terminal of 80 x 24 cells has room for it, two rows of pixels in a
line."""


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
        self._env = _drawing(env)
        self._reward = 0.0
        self._steps = 0
        self._env.reset(seed=0)
        self.picture = self._look()

    def begin(self, episode: EpisodeStarted) -> tuple[TickView, ...]:
        """Return the first picture."""
        self._env.reset(seed=episode.episode_seed % 2**31)
        self._reward, self._steps = 0.0, 0
        self.picture = self._look()
        return (TickView(self.picture),)

    def act(self, step: StepTaken) -> tuple[TickView, ...]:
        """Return the picture after a step."""
        self._env.step(EnvAction.of(step).action)
        self._reward += step.reward
        self._steps += 1
        self.picture = self._look()
        return (TickView(self.picture),)

    def judged_after_ns(self, n_ticks: int) -> int:
        """Return 0: what a step led to is seen at once."""
        return 0

    def place_of(self, step: int) -> Place:
        """Return nothing: an environment does not say where an action is to be seen."""
        return ()

    def _look(self) -> EnvPicture:
        drawn = self._env.render()
        if isinstance(drawn, str):
            return EnvPicture(text=drawn, reward=self._reward, steps=self._steps)
        small = smaller(np.asarray(drawn))
        return EnvPicture(
            width=small.shape[1],
            height=small.shape[0],
            pixels=small.tobytes(),
            reward=self._reward,
            steps=self._steps,
        )


def smaller(picture: Any) -> Any:
    """Return a picture of at most `WIDEST` x `HIGHEST` pixels: means of blocks, shape (height, width, 3),
    bytes.
    """
    height, width = picture.shape[:2]
    scale = max(1.0, width / WIDEST, height / HIGHEST)
    rows = np.linspace(0, height, max(2, round(height / scale)) + 1).astype(int)
    columns = np.linspace(0, width, max(2, round(width / scale)) + 1).astype(int)
    sums = np.add.reduceat(np.add.reduceat(picture[..., :3].astype(float), rows[:-1]), columns[:-1], axis=1)
    sizes = np.diff(rows)[:, None, None] * np.diff(columns)[None, :, None]
    return (sums / sizes).astype(np.uint8)


def _drawing(env: str) -> Any:
    problems = []
    from core.interop.gymnasium.environments import make_env  # here, not above: compiled code comes with it

    for mode in ("rgb_array", "ansi"):
        try:
            made = make_env(env, render_mode=mode)
            made.reset(seed=0)
            if made.render() is not None:
                return made
            problems.append(f"{mode}: it draws nothing")
        except Exception as error:  # noqa: BLE001 - whatever a foreign environment raises
            problems.append(f"{mode}: {error}")
    raise GameError(f"{env} cannot be shown. {'; '.join(problems)}")
