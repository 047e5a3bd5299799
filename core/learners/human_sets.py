"""Human models over tiles of several learners, for compiled play: `core.learners.human_tiles` without its
classes.

The same samples in the same order give the same bits as there.
"""

import math
from typing import NamedTuple

import numpy as np

from core.learners.human_config import TileModel
from core.learners.human_tiles import move_tiles
from core.numerics.arrays import Floats, Ints
from core.numerics.compiled import inner_kernel
from core.numerics.tile_coding import TileCoder, window_sum


class HumanSet(NamedTuple):
    """Human models of n learners with a options over t tiles; kernels change the arrays in place."""

    weights: Floats
    """Shape (n, a, t), or (1, a, t) where one model is shared by all."""
    samples: Ints
    """[samples learned from], shape (1,): while it is 0 nothing is known."""
    foreseen: Floats
    """How well presses were foreseen (`core.learners.consistency`): sum of weights, means of label and
    prediction, sum of squares of predictions, drift, variation; shape (6,)."""
    n_tilings: int
    step_size: float
    """Fraction of its error that a sample of weight 1 takes out."""


def new_human_set(config: TileModel, coder: TileCoder, n_learners: int, n_options: int) -> HumanSet:
    """Return models without a sample.

    Args:
        config: step size, and whether one model is shared by all.
        coder: the tile coding of the states.
        n_learners: how many decide.
        n_options: options of each.
    """
    return HumanSet(
        weights=np.zeros((1 if config.shared else n_learners, n_options, coder.n_tiles)),
        samples=np.zeros(1, np.int64),
        foreseen=np.zeros(6),
        n_tilings=coder.n_tilings,
        step_size=float(config.step_size),
    )


@inner_kernel
def human_values(human: HumanSet, k: int, windows: Ints, out: Floats) -> None:
    """Write H(s, o) of learner k for every option, in units of a press.

    Args:
        human: the models.
        k: which learner.
        windows: first active tile per variable, shape (v,) (`core.numerics.tile_coding.find_windows`).
        out: shape (a,).
    """
    weights = human.weights[min(k, human.weights.shape[0] - 1)]
    for option in range(len(out)):
        out[option] = window_sum(weights[option], windows, human.n_tilings)


@inner_kernel
def learn_sample(
    human: HumanSet, k: int, windows: Ints, option: int, label: float, sample_weight: float
) -> None:
    """Let learner k learn that a step of its own got a share of a press.

    Args:
        human: the models, in place.
        k: the learner whose step it was.
        windows: as in `human_values`.
        option: what it chose.
        label: > 0 good, < 0 bad.
        sample_weight: the step's share of the credit, in (0, 1].
    """
    weights = human.weights[min(k, human.weights.shape[0] - 1), option]
    _note(human.foreseen, window_sum(weights, windows, human.n_tilings), label, sample_weight)
    move_tiles(windows, label, sample_weight, human.step_size, weights, human.n_tilings)
    human.samples[0] += 1


@inner_kernel
def _note(state: Floats, prediction: float, label: float, weight: float) -> None:
    """Take in a prediction made before the press was known (`core.learners.consistency.Consistency.note`)."""
    deviation = prediction - state[2]
    if state[3] > 0.0:
        spread = math.sqrt(state[3] / state[0])
        gain = weight * min(max(deviation / spread, -1.0), 1.0) * (label - state[1])
        state[4] += gain
        state[5] += gain * gain
    state[0] += weight
    state[2] += weight / state[0] * deviation
    state[3] += weight * deviation * (prediction - state[2])
    state[1] += weight / state[0] * (label - state[1])


def consistency(human: HumanSet) -> float:
    """Return how many standard errors better than chance the models foresaw the presses."""
    drift, variation = human.foreseen[4:]
    return float(drift / math.sqrt(variation)) if variation > 0 else 0.0
