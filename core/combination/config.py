"""An agent's settings, and every name that they are made of.

Nothing here needs compiled code, so a protocol can be read without it. The schemes are in
`core.combination.schemes`, the rules of trust in `core.combination.trust`.
"""

import msgspec

from core.combination.agreement import MatchKind
from core.combination.bootstrap_config import BootstrapConfig
from core.combination.episode_weights import (
    ADVISE,
    ENVIRONMENT_WEIGHTS,
    EXPONENTIAL,
    FORM_NAMES,
    LINEAR,
    LINEAR_RAW,
    EpisodeWeights,
)
from core.combination.schemes import (
    SCHEMES,
    ActionBiasing,
    ActsOn,
    Advise,
    Annealed,
    AnnealedWeight,
    Coach,
    Constant,
    ControlSharing,
    EnvironmentOnly,
    Exponential,
    HumanOnly,
    Linear,
    QAugmentation,
    RewardShaping,
    Scale,
    Scheme,
    check_learner,
    waits_for_feedback,
)
from core.combination.trust import (
    Equation4,
    Equation5,
    FixedWeight,
    RankCorrelation,
    SideBySide,
    Signed,
    Tried,
    TrustRule,
)
from core.feedback.asking_config import AskingConfig
from core.feedback.config import CreditConfig
from core.learners.human_config import HumanModelConfig, RidgeModel

__all__ = [
    "ADVISE",
    "ENVIRONMENT_WEIGHTS",
    "EXPONENTIAL",
    "FORM_NAMES",
    "LINEAR",
    "LINEAR_RAW",
    "SCHEMES",
    "ActionBiasing",
    "ActsOn",
    "Advise",
    "AgentConfig",
    "Annealed",
    "AnnealedWeight",
    "AskingConfig",
    "BootstrapConfig",
    "Coach",
    "Constant",
    "ControlSharing",
    "EnvironmentOnly",
    "EpisodeWeights",
    "Equation4",
    "Equation5",
    "Exponential",
    "FixedWeight",
    "HumanOnly",
    "Linear",
    "MatchKind",
    "QAugmentation",
    "RankCorrelation",
    "RewardShaping",
    "Scale",
    "Scheme",
    "SideBySide",
    "Signed",
    "Tried",
    "TrustRule",
    "check_learner",
    "waits_for_feedback",
]


class AgentConfig(msgspec.Struct, frozen=True, kw_only=True, forbid_unknown_fields=True):
    """Everything that decides how an agent combines its two sources."""

    scheme: Scheme = Linear()
    """f(R, H) of Eq. 2; linear, Eq. 3, is the paper's choice."""
    bootstrap: BootstrapConfig = BootstrapConfig()
    """Trust and the top policies."""
    credit: CreditConfig = CreditConfig()
    """How presses become samples."""
    human_model: HumanModelConfig = RidgeModel()
    """How samples become H. (The paper does not say; least squares make most of a few presses.)"""
    asking: AskingConfig = AskingConfig()
    """Whether and when the agent asks."""
