"""The human reward model over tile-coded states: H(s, o) of each option o, one model per learner or one for all.

It is gradient descent as of `core.learners.human_reward` (`SgdModel` without intercept) on the binary features of a
tile coding, of which only the active ones are touched: the same samples in the same order give the same bits.
"""

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from core.compiled import kernel
from core.learners.human_config import TileModel
from core.tile_coding import TileCoder, add_to_windows, window_sum

Floats = NDArray[np.float64]
Ints = NDArray[np.int64]


class TiledHuman(NamedTuple):
    """Human models of n learners with a options over t tiles; kernels change the arrays in place."""

    weights: Floats
    """Shape (n, a, t), or (1, a, t) where one model is shared by all."""
    samples: Ints
    """[samples learned from], shape (1,): while it is 0 nothing is known."""
    n_tilings: int
    step_size: float
    """Per active tile: a sample of weight 1 moves H by step_size * active tiles * error."""


def new_tiled_human(config: TileModel, coder: TileCoder, n_learners: int, n_options: int) -> TiledHuman:
    """Return models that have heard nothing.

    Args:
        config: step size, and whether one model is shared by all.
        coder: the tile coding of the states.
        n_learners: how many decide.
        n_options: options of each.
    """
    return TiledHuman(
        weights=np.zeros((1 if config.shared else n_learners, n_options, coder.n_tiles)),
        samples=np.zeros(1, np.int64),
        n_tilings=coder.n_tilings,
        step_size=float(config.step_size) / (len(coder.low) * coder.n_tilings),
    )


@kernel
def human_values(human: TiledHuman, k: int, windows: Ints, out: Floats) -> None:
    """Write H(s, o) of learner k for every option, in units of a press.

    Args:
        human: the models.
        k: which learner.
        windows: first active tile per variable, shape (v,) (`core.tile_coding.find_windows`).
        out: shape (a,).
    """
    weights = human.weights[min(k, human.weights.shape[0] - 1)]
    for option in range(len(out)):
        out[option] = window_sum(weights[option], windows, human.n_tilings)


@kernel
def learn_sample(
    human: TiledHuman, k: int, windows: Ints, option: int, label: float, sample_weight: float
) -> None:
    """Move H(s, option) of learner k towards a label: one step of the weighted squared error's gradient.

    Args:
        human: the models, in place.
        k: the learner whose step it was.
        windows: as in `human_values`.
        option: what it chose.
        label: > 0 good, < 0 bad.
        sample_weight: the step's share of the credit, in (0, 1].
    """
    weights = human.weights[min(k, human.weights.shape[0] - 1), option]
    # In index order and one by one, as a dense model sums: the same bits.
    prediction = 0.0
    for v in range(len(windows)):
        for tile in range(windows[v], windows[v] + human.n_tilings):
            prediction += weights[tile]
    move = human.step_size * sample_weight * (label - prediction)
    add_to_windows(weights, windows, human.n_tilings, move)
    human.samples[0] += 1
