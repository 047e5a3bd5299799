"""The table of learning of Keepaway's page: five seeds, 160 runs and the reference's one run, by blocks of
episodes.
"""

from collections.abc import Sequence
from pathlib import Path

import numpy as np

from core.keepaway.autoplay import Autoplay
from core.keepaway.pitch import KeepawayConfig
from core.keepaway.training import LearningCurve, LearningRun, learn
from core.learners.sarsa_config import SarsaConfig
from core.numerics.arrays import Floats
from studies.fidelity.keepaway_fidelity import read_durations
from studies.fidelity.keepaway_learning import prediction_band, table_of
from studies.pools import processes

BLOCK = 500
"""Episodes whose durations are averaged."""
N_SEEDS, N_RUNS = 5, 160
"""Root seeds 0, 1, ...: runs whose see phases are drawn in each episode, and once per run."""
FEW = 5
"""Runs that reach the reference are counted where they are fewer than this; otherwise they are a fraction."""
HEAD = (
    "episodes",
    "five seeds, lowest - mean - highest",
    "band of a further one",
    "160 runs, median [2.5 %, 97.5 %]",
    "reference (one run)",
    "runs that reach it",
)
_NUMBERS = ("no", "one", "two", "three", "four", "five")


def drawn_each_episode(root_seed: int) -> LearningRun:
    """Return a run of 12 simulated hours as sessions and experiments play."""
    return LearningRun(KeepawayConfig(), SarsaConfig(), root_seed)


def drawn_once(root_seed: int) -> LearningRun:
    """Return a run of 12 simulated hours whose see phases stay, as the reference's players keep theirs."""
    phases = tuple(Autoplay(KeepawayConfig(), root_seed, "phases of a run").match.phase.tolist())
    return LearningRun(KeepawayConfig(see_phases=phases), SarsaConfig(), root_seed)


def learn_all(workers: int) -> tuple[list[LearningCurve], list[LearningCurve]]:
    """Play the five seeds and the 160 runs; the same for any number of workers.

    Args:
        workers: processes, >= 1. On one processor this takes most of an hour.
    """
    with processes(workers) as pool:
        seeds = pool.map(learn, map(drawn_each_episode, range(N_SEEDS)))
        runs = pool.map(learn, map(drawn_once, range(N_RUNS)))
        return list(seeds), list(runs)


def read_reference(data: Path) -> LearningCurve:
    """Return the learning curve of the reference from the folder of its files."""
    seconds = read_durations(data / "v15_360_learn_episodes.csv").seconds
    return LearningCurve(seconds, np.zeros(len(seconds), np.bool_))


def learning_rows(
    seeds: Sequence[LearningCurve], runs: Sequence[LearningCurve], reference: LearningCurve
) -> list[tuple[str, ...]]:
    """Return the rows under HEAD.

    A block that not all of the seeds have ends the table: it has no band, and says how many have it.
    """
    low, high = prediction_band(table_of(list(seeds), BLOCK))
    theirs = reference.block_means(BLOCK)
    of_seeds, of_runs = ([curve.block_means(BLOCK) for curve in curves] for curves in (seeds, runs))
    n_blocks = min(len(theirs), max(map(len, of_seeds)), len(low) + 1)
    rows: list[tuple[str, ...]] = []
    for block in range(n_blocks):
        ours, many = _having(of_seeds, block), _having(of_runs, block)
        whole = block < len(low)
        few = "" if len(ours) == len(seeds) else f" ({_NUMBERS[len(ours)]})"
        fewer = "" if len(many) == len(runs) else f" ({len(many)})"
        lowest, highest = np.percentile(many, [2.5, 97.5])
        rows.append(
            (
                f"{block * BLOCK + 1}-{(block + 1) * BLOCK}",
                f"{ours.min():.2f} - {ours.mean():.2f} - {ours.max():.2f}{few}",
                f"{low[block]:.1f} - {high[block]:.1f}" if whole else "",
                f"{np.median(many):.2f} [{lowest:.2f}, {highest:.2f}]{fewer}",
                f"{theirs[block]:.2f}",
                _reaching(many, theirs[block]) if whole else "",
            )
        )
    return rows


def _having(curves: Sequence[Floats], block: int) -> Floats:
    return np.array([curve[block] for curve in curves if len(curve) > block])


def _reaching(runs: Floats, value: float) -> str:
    n = int((runs >= value).sum())
    return f"{n} of {len(runs)}" if n < FEW else f"{n / len(runs):.2f}"
