"""Keepers that learn by Sarsa for some simulated hours, without a screen."""

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from core.keepaway.autoplay import Autoplay, keepaway_tiles
from core.keepaway.pitch import KeepawayConfig
from core.learners.sarsa import Sarsa, SarsaConfig, new_sarsa
from core.numerics.arrays import Floats
from core.numerics.clock import S_PER_HOUR


@dataclass(frozen=True, slots=True)
class LearningRun:
    """One seed's training."""

    config: KeepawayConfig
    learner: SarsaConfig
    root_seed: int
    hours: float = 12.0
    """Simulated time to learn for."""
    block: int = 50
    """Episodes played at once; the run stops after the first block that reaches `hours`."""

    def __post_init__(self) -> None:
        if not (self.hours > 0 and self.block > 0):
            raise ValueError(f"need hours > 0 and block > 0, got {self.hours} and {self.block}")


@dataclass(frozen=True, slots=True, eq=False)
class LearningCurve:
    """What became of one run's episodes, in order."""

    duration_s: Floats
    """Shape (n,)."""
    out: NDArray[np.bool_]
    """Shape (n,)."""

    def __post_init__(self) -> None:
        if self.duration_s.shape != self.out.shape:
            raise ValueError(f"need one end per episode: {self.duration_s.shape}, {self.out.shape}")

    def block_means(self, size: int) -> Floats:
        """Return the mean duration of each complete block of `size` episodes, in seconds."""
        n_blocks = len(self.duration_s) // size
        blocks = self.duration_s[: n_blocks * size].reshape(n_blocks, size)
        return np.asarray(blocks.mean(axis=1), np.float64)


def train(run: LearningRun, on_block: Callable[[LearningCurve], None] = lambda _: None) -> Sarsa:
    """Train keepers from nothing for the run's simulated hours; the result depends on the run alone.

    Args:
        run: what is learned, and for how long.
        on_block: told of the episodes of each block as soon as they have been played.

    Returns:
        The learners, with all that they have learned.
    """
    game = Autoplay(run.config, run.root_seed, "keepaway learning")
    sarsa = new_sarsa(run.learner, keepaway_tiles(run.config), run.config.n_keepers, run.config.n_actions)
    played_s = 0.0
    while played_s < run.hours * S_PER_HOUR:
        episodes = game.learn(sarsa, run.block)
        on_block(LearningCurve(episodes.duration_s, episodes.out))
        played_s += float(episodes.duration_s.sum())
    return sarsa


def learn(run: LearningRun) -> LearningCurve:
    """Return the learning curve of `train`."""
    blocks: list[LearningCurve] = []
    train(run, blocks.append)
    return LearningCurve(
        np.concatenate([block.duration_s for block in blocks]),
        np.concatenate([block.out for block in blocks]),
    )
