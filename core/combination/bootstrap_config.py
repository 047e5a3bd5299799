"""Settings of bootstrap learning. No compiled code is imported."""

from typing import Annotated

import msgspec

from core.combination.trust import Equation4, TrustRule
from core.configuration.fields import number


class BootstrapConfig(msgspec.Struct, frozen=True, kw_only=True, forbid_unknown_fields=True):
    """Bootstrap learning (section 3.1)."""

    trust: TrustRule = Equation4()
    """How w_h follows from performance and match (the paper's first equation for it)."""
    top_policies: Annotated[int, number("policies", ge=1, le=100_000)] = 10
    """N, the number of policies kept. (The paper does not say; as many as the elite of one CE iteration.)"""
    symmetric: bool = True
    """A policy's selection probability rises with its match to the human policy, scaled by w_h: the agent
    "alternately assumes the policy based on each feedback mechanism to be ground truth"."""
    window_decisions: Annotated[int, number("decisions", ge=1, le=1_000_000)] = 200
    """Recent decisions kept for measuring matches anew. (Our choice.)"""

    def __post_init__(self) -> None:
        if self.top_policies < 1 or self.window_decisions < 1:
            raise ValueError(
                f"top_policies and window_decisions are >= 1: {self.top_policies}, {self.window_decisions}"
            )
