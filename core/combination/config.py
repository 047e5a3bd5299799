"""Settings of combination: schemes and the weights they give to an episode (Eqs. 2 and 3), and trust (Eqs. 4, 5).

Nothing here needs compiled code, so a protocol can be read without it; the decision itself is in
`core.combination.schemes`, trust in `core.combination.trust`.
"""

import math
from dataclasses import dataclass
from typing import Literal

import msgspec

from core.combination.trust_config import (
    AskingConfig,
    BootstrapConfig,
    Equation4,
    Equation5,
    FixedWeight,
    MatchKind,
    RankCorrelation,
    SideBySide,
    Signed,
    Tried,
    TrustRule,
)
from core.feedback.config import CreditConfig
from core.learners.human_config import HumanModelConfig, RidgeModel

__all__ = [
    "ADVISE",
    "ANNEALED_SCHEMES",
    "ENVIRONMENT_WEIGHTS",
    "EXPONENTIAL",
    "FORM_NAMES",
    "LINEAR",
    "LINEAR_RAW",
    "SCHEMES",
    "TEACHING_SCHEMES",
    "ActionBiasing",
    "Advise",
    "AgentConfig",
    "Annealed",
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
]

Scale = Literal["standardised", "raw"]
Per = Literal["watched-game", "episode"]
"""What a weight that falls is counted by; k of an episode is the number of watched games, or of episodes, before it."""

LINEAR = 0
"""Form: argmax w_r R + w_h H, both standardised over the actions of the decision (Eq. 3)."""
EXPONENTIAL = 1
"""Form: argmax w_r R (1 + H^w_h), H mapped to [0, 1] and R shifted to >= 0 (section 3.1)."""
LINEAR_RAW = 2
"""Form: argmax w_r R + w_h H of the values as they come (Eq. 3 to the letter)."""
ADVISE = 3
"""Form: argmax pi_R pi_H, softmax of R times the probability that the human calls the action right (Advise)."""

FORM_NAMES: dict[int, str] = {
    LINEAR: "linear",
    EXPONENTIAL: "exponential",
    LINEAR_RAW: "linear, raw values",
    ADVISE: "Advise",
}
"""Names of the forms, for reports."""


@dataclass(frozen=True, slots=True)
class EpisodeWeights:
    """How environment and human are combined during one episode."""

    form: int
    """LINEAR, EXPONENTIAL, LINEAR_RAW or ADVISE."""
    w_r: float
    """Weight of the environment's values, >= 0."""
    w_h: float
    """Weight of the human's values; negative where the human is believed to mean the opposite."""
    share: float = 0.0
    """Probability, per decision, of taking the human model's best action instead, in [0, 1]."""
    shaping: float = 0.0
    """What is added to the environment's reward of a step per unit of its H (reward shaping)."""
    augmentation: float = 0.0
    """The learner learns Q so that Q + this times H fits its returns (Q augmentation)."""

    def __post_init__(self) -> None:
        if self.form not in FORM_NAMES:
            raise ValueError(f"form is one of {FORM_NAMES}, got {self.form}")
        if not (math.isfinite(self.w_r) and self.w_r >= 0 and math.isfinite(self.w_h)):
            raise ValueError(f"w_r is finite and >= 0, w_h finite; got w_r={self.w_r}, w_h={self.w_h}")
        if not 0 <= self.share <= 1:
            raise ValueError(f"share is a probability, got {self.share}")
        if not (math.isfinite(self.shaping) and math.isfinite(self.augmentation)):
            raise ValueError(
                f"shaping and augmentation are finite, got {self.shaping} and {self.augmentation}"
            )


ENVIRONMENT_WEIGHTS = EpisodeWeights(LINEAR, 1.0, 0.0)
"""The environment alone: what an agent does before anybody has given feedback."""


class Linear(msgspec.Struct, frozen=True, tag="linear"):
    """a = argmax w_r R + w_h H with w_r = 1 and w_h from bootstrap learning (Eq. 3)."""

    scale: Scale = "standardised"
    """What R and H are divided by (`docs/decisions/scale-of-r-and-h.md`)."""

    def weights(self, trust: float, episode: int) -> EpisodeWeights:
        """Return the weights for the w_h that bootstrap learning holds now."""
        return EpisodeWeights(_linear_form(self.scale), 1.0, trust)


class Exponential(msgspec.Struct, frozen=True, tag="exponential"):
    """a = argmax w_r R (1 + H^w_h) with w_r = 1 and w_h from bootstrap learning (section 3.1)."""

    def weights(self, trust: float, episode: int) -> EpisodeWeights:
        """Return the weights for the w_h that bootstrap learning holds now."""
        return EpisodeWeights(EXPONENTIAL, 1.0, trust)


class Annealed(msgspec.Struct, frozen=True, tag="annealed"):
    """Eq. 3 with w_h = beta_0 decay^k, k counted by `per`: the paper's baseline (section 4; Knox & Stone 2010)."""

    beta_0: float = 1.0
    """w_h of the first episode. 1: as much say as the environment, both being standardised. (Our choice.)"""
    decay: float = 0.98
    """Factor per watched game or per episode, in (0, 1] (TAMER's code documents 0.98 for AAMAS 2010)."""
    per: Per = "watched-game"
    """What the weight falls with: each watched game, or each episode, unseen ones included (`docs/decisions/annealing.md`)."""
    scale: Scale = "standardised"
    """As in `Linear`."""

    def __post_init__(self) -> None:
        _check_annealing(self.beta_0, self.decay)

    def weights(self, trust: float, episode: int) -> EpisodeWeights:
        """Return the weights at number `episode` >= 0 of the schedule; `trust` plays no part."""
        return EpisodeWeights(_linear_form(self.scale), 1.0, _annealed(self.beta_0, self.decay, episode))


class Constant(msgspec.Struct, frozen=True, tag="constant"):
    """Eq. 3 with a weight that never changes: what bootstrap learning has to beat with a bad participant."""

    w_h: float = 1.0
    """As much say as the environment, both being standardised. (Our choice.)"""
    scale: Scale = "standardised"
    """As in `Linear`."""

    def weights(self, trust: float, episode: int) -> EpisodeWeights:
        """Return the constant weights; `trust` and `episode` play no part."""
        return EpisodeWeights(_linear_form(self.scale), 1.0, self.w_h)


class EnvironmentOnly(msgspec.Struct, frozen=True, tag="environment-only"):
    """The underlying learner without a human: a = argmax R (section 4, "default")."""

    def weights(self, trust: float, episode: int) -> EpisodeWeights:
        """Return w_r = 1, w_h = 0."""
        return ENVIRONMENT_WEIGHTS


class HumanOnly(msgspec.Struct, frozen=True, tag="human-only"):
    """The human model without an environment: a = argmax H, as TAMER (Knox & Stone 2009; section 4)."""

    def weights(self, trust: float, episode: int) -> EpisodeWeights:
        """Return w_r = 0, w_h = 1."""
        return EpisodeWeights(LINEAR, 0.0, 1.0)


class ActionBiasing(msgspec.Struct, frozen=True, tag="action-biasing"):
    """a = argmax Q + beta H at choice only, beta annealed (Knox & Stone 2010, technique 6).

    The scales of Q and H are the values' own, as in the source, so `beta_0` belongs to one task and one
    learner; where the scale of Q is arbitrary (policies of the cross-entropy method) ask for "standardised".
    """

    beta_0: float = 10.0
    """Weight of the first episode (default of TAMER's code)."""
    decay: float = 0.98
    """Factor per watched game or per episode, in (0, 1] (TAMER's code documents 0.98 for AAMAS 2010)."""
    per: Per = "watched-game"
    """What the weight falls with: each watched game, or each episode, unseen ones included (`docs/decisions/annealing.md`)."""
    scale: Scale = "raw"
    """As in `Linear`; the source adds raw values."""

    def __post_init__(self) -> None:
        _check_annealing(self.beta_0, self.decay)

    def weights(self, trust: float, episode: int) -> EpisodeWeights:
        """Return the weights at number `episode` >= 0 of the schedule; `trust` plays no part."""
        return EpisodeWeights(_linear_form(self.scale), 1.0, _annealed(self.beta_0, self.decay, episode))


class ControlSharing(msgspec.Struct, frozen=True, tag="control-sharing"):
    """With probability min(1, beta) take argmax H, else argmax R (Knox & Stone 2010, technique 7)."""

    beta_0: float = 1.0
    """Probability in the first episode, clipped to 1 (as in the Frogger study of Griffith et al. 2013)."""
    decay: float = 0.98
    """Factor per watched game or per episode, in (0, 1] (TAMER's code documents 0.98 for AAMAS 2010)."""
    per: Per = "watched-game"
    """What the weight falls with: each watched game, or each episode, unseen ones included (`docs/decisions/annealing.md`)."""

    def __post_init__(self) -> None:
        _check_annealing(self.beta_0, self.decay)

    def weights(self, trust: float, episode: int) -> EpisodeWeights:
        """Return the weights at number `episode` >= 0 of the schedule; `trust` plays no part."""
        return EpisodeWeights(LINEAR, 1.0, 0.0, min(1.0, _annealed(self.beta_0, self.decay, episode)))


class Advise(msgspec.Struct, frozen=True, tag="advise"):
    """a = argmax pi_R(a) pi_H(a): policy shaping by the Advise rule (Griffith et al. 2013).

    pi_R is the softmax of R; pi_H = C^d / (C^d + (1 - C)^d), d being how much more often the action has been called right
    than wrong, and C how consistent the human is. Where states do not come back nobody counts: d is H, standardised over the
    actions of the decision as R is (`docs/decisions/more-schemes.md`).
    """

    consistency: float = 0.9
    """C, in (0, 1): chance that a press is right. 0.5 means nothing, less the opposite. (Paper, section 4: 1 in 10 wrong.)"""
    temperature: float = 1.0
    """Of the softmax, > 0, in standard deviations of R. (Our choice.)"""

    def __post_init__(self) -> None:
        if not 0 < self.consistency < 1:
            raise ValueError(f"consistency is a chance in (0, 1), got {self.consistency}")
        if not (math.isfinite(self.temperature) and self.temperature > 0):
            raise ValueError(f"temperature is > 0, got {self.temperature}")

    def weights(self, trust: float, episode: int) -> EpisodeWeights:
        """Return 1 / temperature and the log odds of C; `trust` and `episode` play no part."""
        odds = math.log(self.consistency / (1.0 - self.consistency))
        return EpisodeWeights(ADVISE, 1.0 / self.temperature, odds)


class RewardShaping(msgspec.Struct, frozen=True, tag="reward-shaping"):
    """The learner hears r + beta H(s, a), beta annealed, and chooses by R alone (Knox & Stone 2010, technique 1)."""

    beta_0: float = 1.0
    """Reward per unit of H in the first episode: a press is worth a line, or a cycle. (Our choice.)"""
    decay: float = 0.98
    """Factor per watched game or per episode, in (0, 1] (TAMER's code documents 0.98 for AAMAS 2010)."""
    per: Per = "watched-game"
    """What the weight falls with: each watched game, or each episode, unseen ones included (`docs/decisions/annealing.md`)."""

    def __post_init__(self) -> None:
        _check_annealing(self.beta_0, self.decay)

    def weights(self, trust: float, episode: int) -> EpisodeWeights:
        """Return the weights at number `episode` >= 0 of the schedule; `trust` plays no part."""
        return EpisodeWeights(LINEAR, 1.0, 0.0, shaping=_annealed(self.beta_0, self.decay, episode))


class QAugmentation(msgspec.Struct, frozen=True, tag="q-augmentation"):
    """Q + beta H takes Q's place in learning and in choice, beta constant (Knox & Stone 2010, technique 4).

    The temporal difference of Q + beta H is that of Q with beta (gamma H(s', a') - H(s, a)) added to the reward.
    """

    beta: float = 1.0
    """Weight of H, in units of the return. (Our choice.)"""

    def __post_init__(self) -> None:
        if not math.isfinite(self.beta):
            raise ValueError(f"beta is finite, got {self.beta}")

    def weights(self, trust: float, episode: int) -> EpisodeWeights:
        """Return the constant weights; `trust` and `episode` play no part."""
        return EpisodeWeights(LINEAR_RAW, 1.0, self.beta, augmentation=self.beta)


class Coach(msgspec.Struct, frozen=True, tag="coach"):
    """A press is the advantage of what was done: it moves an actor's policy itself (COACH, MacGlashan et al. 2017).

    theta <- theta + alpha f e, e being the trace of grad log pi up to the step that the press is about. No human model
    takes part in choices; the learner must be an actor (policy gradient).
    """

    step_size: float = 0.05
    """alpha of the presses, > 0. (Our choice; the source's 0.05 belongs to a robot's features.)"""
    trace_decay: float = 0.95
    """lambda of the trace, in [0, 1] (the source, for plain presses)."""
    environment_too: bool = True
    """The environment's reward goes on teaching; False: the source, where the human is the only teacher."""

    def __post_init__(self) -> None:
        if not (math.isfinite(self.step_size) and self.step_size > 0 and 0 <= self.trace_decay <= 1):
            raise ValueError(
                f"need step_size > 0 and trace_decay in [0, 1]: {self.step_size}, {self.trace_decay}"
            )

    def weights(self, trust: float, episode: int) -> EpisodeWeights:
        """Return w_r = 1, w_h = 0."""
        return ENVIRONMENT_WEIGHTS


Scheme = (
    Linear
    | Exponential
    | Annealed
    | Constant
    | EnvironmentOnly
    | HumanOnly
    | ActionBiasing
    | ControlSharing
    | RewardShaping
    | QAugmentation
    | Advise
    | Coach
)
"""Any scheme; msgspec decodes it by its tag, the field "type"."""

SCHEMES: dict[str, type[Scheme]] = {
    "linear": Linear,
    "exponential": Exponential,
    "annealed": Annealed,
    "constant": Constant,
    "environment-only": EnvironmentOnly,
    "human-only": HumanOnly,
    "action-biasing": ActionBiasing,
    "control-sharing": ControlSharing,
    "reward-shaping": RewardShaping,
    "q-augmentation": QAugmentation,
    "advise": Advise,
    "coach": Coach,
}
"""Every scheme by its tag: the one registry."""

ANNEALED_SCHEMES = (Annealed, ActionBiasing, ControlSharing, RewardShaping)
"""Schemes whose weight falls: `core.combination.schedule` says what with."""

TEACHING_SCHEMES = (RewardShaping, QAugmentation, Coach)
"""Schemes that act on what the environment's learner learns: they need one that learns at every step."""


def _linear_form(scale: Scale) -> int:
    return LINEAR if scale == "standardised" else LINEAR_RAW


def _check_annealing(beta_0: float, decay: float) -> None:
    if not (math.isfinite(beta_0) and beta_0 >= 0):
        raise ValueError(f"beta_0 is finite and >= 0, got {beta_0}")
    if not 0 < decay <= 1:
        raise ValueError(f"decay is a factor in (0, 1], got {decay}")


def _annealed(beta_0: float, decay: float, episode: int) -> float:
    """beta_k = beta_0 decay^k (Knox & Stone 2010)."""
    if episode < 0:
        raise ValueError(f"episodes count from 0, got {episode}")
    return beta_0 * decay**episode


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
