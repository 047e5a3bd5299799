"""Settings of SMDP Sarsa(lambda) (`core.learners.sarsa`). No numerical library is imported."""

from typing import Annotated, ClassVar

import msgspec

from core.configuration.fields import number
from core.learners.kinds import LearnerKind


class SarsaConfig(msgspec.Struct, frozen=True, kw_only=True, forbid_unknown_fields=True, tag="sarsa"):
    """Sarsa(lambda); the defaults are those of the released keepaway players."""

    kind: ClassVar[LearnerKind] = "stepwise"

    step_size: Annotated[float, number(ge=0, le=1e6, usual=(0, 1))] = 0.125
    """alpha, divided by the number of active tiles in every update."""
    discount: Annotated[float, number("per cycle", gt=0, le=1)] = 1.0
    """gamma per cycle, in (0, 1]."""
    trace_decay: Annotated[float, number("per decision", ge=0, le=1)] = 0.0
    """lambda per decision, in [0, 1]."""
    exploration: Annotated[float, number(ge=0, le=1)] = 0.01
    """epsilon: fraction of decisions taken at random."""
    replacing_traces: bool = True
    """True: a visited tile's trace becomes 1, those of the other actions there 0. False: traces
    accumulate."""
    least_trace: Annotated[float, number(ge=0, le=1)] = 0.01
    """Traces below this are dropped."""
    initial_value: Annotated[float, number("cycles", ge=-1e9, le=1e9, usual=(-1e5, 1e5))] = 0.0
    """Action value before any learning, in cycles."""
    shared_weights: bool = False
    """All learners learn one weight vector."""

    def __post_init__(self) -> None:
        if not (self.step_size >= 0 and 0 < self.discount <= 1 and 0 <= self.trace_decay <= 1):
            raise ValueError(
                f"need step_size >= 0, discount in (0, 1] and trace_decay in [0, 1], got {self.step_size}, "
                f"{self.discount}, {self.trace_decay}"
            )
        if not 0 <= self.exploration <= 1:
            raise ValueError(f"exploration is a fraction of decisions in [0, 1], got {self.exploration}")
