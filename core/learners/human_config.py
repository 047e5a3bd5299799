"""Settings of the human reward model. Nothing here needs compiled code: see `core.learners.human_reward`."""

import math
from typing import Annotated, Literal

import msgspec

from core.configuration.fields import number


class SgdModel(msgspec.Struct, frozen=True, forbid_unknown_fields=True, tag="sgd"):
    """Linear model by incremental gradient descent from zero, as in TAMER (Knox & Stone 2009)."""

    step_size: Annotated[float, number(gt=0, le=1e6, usual=(1e-12, 0.05))] = 0.000005 / 47
    """Step size, > 0: TAMER's for Tetris (its code divides 0.000005 by its 46 features and the bias)."""
    intercept: bool = True
    """Learn a bias beside the weights (TAMER does; it says nothing about which action is better)."""
    standardise: bool = False
    """Standardise inputs by mean and sd of the samples so far, this one included (TAMER: raw inputs). Weights
    live in standardised units and are exported by the statistics of the moment."""

    def __post_init__(self) -> None:
        if not (math.isfinite(self.step_size) and self.step_size > 0):
            raise ValueError(f"step_size is > 0, got {self.step_size}")


class RidgeModel(msgspec.Struct, frozen=True, forbid_unknown_fields=True, tag="ridge"):
    """Linear model by regularised least squares over all samples so far.

    It minimises sum_i weight_i (label_i - intercept - v . z_i)^2 + l2 |v|^2, z_i being the inputs of sample
    i, and does not depend on the order of the samples, but for rounding.
    """

    l2: Annotated[float, number(ge=1e-30, le=1e30, usual=(1e-6, 1e6))] = 1.0
    """Penalty, > 0: as strong as one unit of sample weight per standardised input. (Our choice.)"""
    intercept: Literal["free", "penalised", "none"] = "penalised"
    """Free: unpenalised, so inputs are centred, and praise alone (or blame alone) teaches nothing. Penalised:
    one more input that is always 1. None: H is 0 where nothing changes."""
    standardise: bool = True
    """Divide each input by its sd (centred) or its root mean square (not centred) over the samples so far."""

    def __post_init__(self) -> None:
        if not (math.isfinite(self.l2) and self.l2 > 0):
            raise ValueError(
                f"l2 is > 0, got {self.l2}: without it a few samples do not determine the weights"
            )


class TileModel(msgspec.Struct, frozen=True, forbid_unknown_fields=True, tag="tiles"):
    """Linear model over the active tiles of a tile-coded domain, by incremental gradient descent from zero.

    H(s, o) is the sum of the weights of the tiles that are active in s, for option o; a sample moves it by
    step_size * weight of its remaining error.
    """

    step_size: Annotated[float, number(gt=0, le=1)] = 0.125
    """Fraction of a sample's error that is taken out, in (0, 1]: divided by the number of active tiles in
    every update, as the Sarsa of the released keepaway players does with its own. (Our choice.)"""
    shared: bool = False
    """One model for all keepers; otherwise each keeper has its own, as it has its own values."""

    def __post_init__(self) -> None:
        if not 0 < self.step_size <= 1:
            raise ValueError(f"step_size is a fraction in (0, 1], got {self.step_size}")


FeatureModelConfig = SgdModel | RidgeModel
"""A human reward model over plain features."""
HumanModelConfig = SgdModel | RidgeModel | TileModel
"""Any human reward model; msgspec decodes it by its tag, the field "type"."""
