"""Settings of bootstrap learning and of asking. No compiled code is imported."""

from typing import Annotated

import msgspec

from core.combination.trust import Equation4, TrustRule
from core.combination.trust.contract import check_memory
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


class AskingConfig(msgspec.Struct, frozen=True, kw_only=True, forbid_unknown_fields=True):
    """When the agent poses a choice of candidate actions (`core.combination.asking`;
    `docs/decisions/asking.md`).
    """

    per_episode: Annotated[int, number("questions", ge=0, le=1_000_000)] = 0
    """Questions per watched episode at most. 0: the agent never asks, as in the paper's experiments."""
    options: Annotated[int, number("actions", ge=2, le=3)] = 3
    """Candidate actions of a question at most, 2 or 3."""
    share: Annotated[float, number(gt=0, lt=1)] = 0.05
    """It asks where its policies disagree more than in all but this fraction of recent decisions, in (0, 1).
    (Our choice.)"""
    memory: Annotated[int, number("decisions", ge=1, le=1_000_000)] = 200
    """How many recent decisions that fraction is of. (Our choice.)"""
    minimum_decisions: Annotated[int, number("decisions", ge=1, le=1_000_000)] = 20
    """It does not ask before it has seen this many. (Our choice.)"""

    def __post_init__(self) -> None:
        if self.per_episode < 0 or self.options not in (2, 3) or not 0 < self.share < 1:
            raise ValueError(
                "asking needs per_episode >= 0, 2 or 3 options and a share in (0, 1), got "
                f"{self.per_episode}, {self.options}, {self.share}"
            )
        check_memory(self.minimum_decisions, self.memory, least=1, names=("minimum_decisions", "memory"))
