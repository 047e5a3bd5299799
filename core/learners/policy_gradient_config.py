"""Settings of policy gradient (`core.learners.policy_gradient`). No numerical library is imported."""

import math
from typing import Annotated, ClassVar, Literal

import msgspec

from core.configuration.fields import number
from core.learners.kinds import LearnerKind


class PolicyGradientConfig(
    msgspec.Struct, frozen=True, kw_only=True, forbid_unknown_fields=True, tag="policy-gradient"
):
    """A softmax policy that climbs the gradient of its reward (Baxter & Bartlett 2001; the libPG family)."""

    kind: ClassVar[LearnerKind] = "climbing"

    step_size: Annotated[float, number(ge=0, le=1e6, usual=(0, 10))] = 0.03
    """alpha, >= 0, for features scaled by their spread among the actions of a decision."""
    trace_decay: Annotated[float, number(ge=0, le=1)] = 0.9
    """beta of the eligibility trace per decision, in [0, 1]: less bias and more variance the nearer to 1."""
    baseline_rate: Annotated[float, number(ge=0, le=1)] = 0.01
    """Rate of the running mean reward that is taken off each reward, in [0, 1]; 0: no baseline."""
    update: Literal["step", "episode"] = "step"
    """When weights move: after every reward (OLPOMDP), or once after an episode (GPOMDP)."""
    natural: bool = False
    """Natural gradient: premultiplied by the inverse of the scores' mean outer product (Kakade 2001)."""
    fisher_rate: Annotated[float, number(gt=0, le=1)] = 0.01
    """Rate of that running mean per episode, in (0, 1] (the first episodes count alike). (Our choice.)"""
    fisher_ridge: Annotated[float, number(ge=1e-30, le=1e30, usual=(1e-9, 1e6))] = 0.001
    """What is added to its diagonal, > 0 (10^-3 in Kakade's Tetris)."""

    def __post_init__(self) -> None:
        if not (math.isfinite(self.step_size) and self.step_size >= 0):
            raise ValueError(f"step_size is finite and >= 0, got {self.step_size}")
        for name in ("trace_decay", "baseline_rate"):
            if not 0 <= getattr(self, name) <= 1:
                raise ValueError(f"{name} is in [0, 1], got {getattr(self, name)}")
        if not (0 < self.fisher_rate <= 1 and math.isfinite(self.fisher_ridge) and self.fisher_ridge > 0):
            raise ValueError(
                f"need fisher_rate in (0, 1] and fisher_ridge > 0: {self.fisher_rate}, {self.fisher_ridge}"
            )
