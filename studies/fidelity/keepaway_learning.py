"""Learning curves of keepers that learn by Sarsa over simulated hours, from several seeds, and how alike they
are.
"""

import numpy as np
from scipy import stats

from core.keepaway.training import LearningCurve
from core.numerics.arrays import Floats


def table_of(curves: list[LearningCurve], size: int) -> Floats:
    """Return the block means of all runs, shape (runs, blocks), for the blocks of `size` episodes that all of
    them have.
    """
    means = [curve.block_means(size) for curve in curves]
    n_blocks = min(len(m) for m in means)
    return np.array([m[:n_blocks] for m in means])


def prediction_band(table: Floats, coverage: float = 0.95) -> tuple[Floats, Floats]:
    """Return between which bounds a whole further curve lies, with at least this probability, if it is one of
    these.

    Student's prediction interval of each block, with the chance of missing shared out among the blocks
    (Bonferroni).

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
    """Return the p-value of "this curve is one of those": the fraction of curves that stand out as far,
    itself included.

    How far a curve stands out is its largest distance from the others' mean in any block, in their standard
    deviations.

    Args:
        curve: block means, shape (blocks,).
        table: block means of the runs it is compared with, shape (runs, blocks), three runs or more.
    """
    all_curves = np.vstack([table, curve])
    distances = []
    for number, one in enumerate(all_curves):
        others = np.delete(all_curves, number, axis=0)
        distances.append(np.abs((one - others.mean(axis=0)) / others.std(axis=0, ddof=1)).max())
    return float(np.mean(np.array(distances) >= distances[-1]))
