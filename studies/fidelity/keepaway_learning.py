"""Learning curves of keepers that learn by Sarsa over simulated hours, from several seeds."""

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy import stats

from core.keepaway.autoplay import Autoplay, keepaway_tiles
from core.keepaway.pitch import KeepawayConfig
from core.learners.sarsa import Sarsa, SarsaConfig, new_sarsa

Floats = NDArray[np.float64]
SECONDS_PER_HOUR = 3600.0


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
    while played_s < run.hours * SECONDS_PER_HOUR:
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


def table_of(curves: list[LearningCurve], size: int) -> Floats:
    """Return the block means of all runs, shape (runs, blocks), for the blocks of `size` episodes that all of them have."""
    means = [curve.block_means(size) for curve in curves]
    n_blocks = min(len(m) for m in means)
    return np.array([m[:n_blocks] for m in means])


def prediction_band(table: Floats, coverage: float = 0.95) -> tuple[Floats, Floats]:
    """Return between which bounds a whole further curve lies, with at least this probability, if it is one of these.

    Student's prediction interval of each block, with the chance of missing shared out among the blocks (Bonferroni).

    Args:
        table: block means, shape (runs, blocks), two runs or more.
        coverage: of all blocks at once, in (0, 1).

    Returns:
        Lower and upper bounds, shape (blocks,) each.
    """
    n_runs, n_blocks = table.shape
    if not (n_runs >= 2 and 0 < coverage < 1):
        raise ValueError(f"need two runs or more and a coverage in (0, 1), got {n_runs} and {coverage}")
    quantile = float(stats.t.ppf(1 - (1 - coverage) / (2 * n_blocks), n_runs - 1))
    half = quantile * table.std(axis=0, ddof=1) * np.sqrt(1 + 1 / n_runs)
    mean = table.mean(axis=0)
    return mean - half, mean + half


def chance_of(curve: Floats, table: Floats) -> float:
    """Return the p-value of "this curve is one of those": the share of curves that stand out as far, itself included.

    How far a curve stands out is its largest distance from the others' mean in any block, in their standard deviations.

    Args:
        curve: block means, shape (blocks,).
        table: block means of the runs it is compared with, shape (runs, blocks), three runs or more.
    """
    everybody = np.vstack([table, curve])
    distances = []
    for number, one in enumerate(everybody):
        others = np.delete(everybody, number, axis=0)
        distances.append(np.abs((one - others.mean(axis=0)) / others.std(axis=0, ddof=1)).max())
    return float(np.mean(np.array(distances) >= distances[-1]))
