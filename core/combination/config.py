"""Settings of combination: schemes and the weights they give to an episode (Eqs. 2 and 3), and trust (Eqs. 4, 5).

Nothing here needs compiled code, so a protocol can be read without it; the decision itself is in
`core.combination.schemes`, trust in `core.combination.trust`.
"""

import math
from dataclasses import dataclass
from typing import Literal

import msgspec

from core.feedback.config import CreditConfig
from core.learners.human_config import HumanModelConfig, RidgeModel

Scale = Literal["standardised", "raw"]

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
    """Eq. 3 with w_h = beta_0 decay^k in episode k: the paper's baseline (section 4; Knox & Stone 2010)."""

    beta_0: float = 1.0
    """w_h of the first episode. 1: as much say as the environment, both being standardised. (Our choice.)"""
    decay: float = 0.98
    """Factor per episode (parameters that TAMER's code documents for AAMAS 2010)."""
    scale: Scale = "standardised"
    """As in `Linear`."""

    def __post_init__(self) -> None:
        _check_annealing(self.beta_0, self.decay)

    def weights(self, trust: float, episode: int) -> EpisodeWeights:
        """Return the weights of episode `episode` >= 0; `trust` plays no part."""
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
    """Factor per episode (parameters that TAMER's code documents for AAMAS 2010)."""
    scale: Scale = "raw"
    """As in `Linear`; the source adds raw values."""

    def __post_init__(self) -> None:
        _check_annealing(self.beta_0, self.decay)

    def weights(self, trust: float, episode: int) -> EpisodeWeights:
        """Return the weights of episode `episode` >= 0; `trust` plays no part."""
        return EpisodeWeights(_linear_form(self.scale), 1.0, _annealed(self.beta_0, self.decay, episode))


class ControlSharing(msgspec.Struct, frozen=True, tag="control-sharing"):
    """With probability min(1, beta) take argmax H, else argmax R (Knox & Stone 2010, technique 7)."""

    beta_0: float = 1.0
    """Probability in the first episode, clipped to 1 (as in the Frogger study of Griffith et al. 2013)."""
    decay: float = 0.98
    """Factor per episode (parameters that TAMER's code documents for AAMAS 2010)."""

    def __post_init__(self) -> None:
        _check_annealing(self.beta_0, self.decay)

    def weights(self, trust: float, episode: int) -> EpisodeWeights:
        """Return the weights of episode `episode` >= 0; `trust` plays no part."""
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
    """Factor per episode (parameters that TAMER's code documents for AAMAS 2010)."""

    def __post_init__(self) -> None:
        _check_annealing(self.beta_0, self.decay)

    def weights(self, trust: float, episode: int) -> EpisodeWeights:
        """Return the weights of episode `episode` >= 0; `trust` plays no part."""
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

TEACHING_SCHEMES = (RewardShaping, QAugmentation, Coach)
"""Schemes that act on what the environment's learner learns: they need one that learns at every step."""


MatchKind = Literal["rate", "chance-corrected", "signed"]
"""Degree of match: fraction of equal choices; the same above chance; best minus worst (`docs/decisions`)."""


class Equation4(msgspec.Struct, frozen=True, tag="equation-4"):
    """w_h is the performance-weighted mean match of the top policies (Eq. 4)."""

    match: MatchKind = "rate"
    """m_i: the paper counts equal choices; a rate keeps w_h in [0, 1]."""
    measured: Literal["as-played", "window"] = "as-played"
    """m_i from the last episode in which policy i was played, or anew from recent decisions."""
    chance: float | None = None
    """Agreement of unrelated policies, in [0, 1), where `match` is chance-corrected; None: estimated from
    recent decisions by random policies."""

    def __post_init__(self) -> None:
        if self.chance is not None and not 0 <= self.chance < 1:
            raise ValueError(f"chance is an agreement rate in [0, 1), got {self.chance}")


class Equation5(msgspec.Struct, frozen=True, tag="equation-5"):
    """w_h moves from episode to episode, weighted by performance (Eq. 5)."""

    match: Literal["rate", "signed"] = "rate"
    """m^k of the episode's policy, as in `Equation4`."""
    cumulative: bool = False
    """Weigh the past by the performance of all compared episodes so far; as printed, by the last one's."""


class Signed(msgspec.Struct, frozen=True, tag="signed"):
    """Eq. 4 over recent episodes with the signed match, less its standard errors (ours; `docs/decisions`).

    w = sum pm_i a_i / sum pm_i, se = sd(a) sqrt(sum pm_i^2) / sum pm_i, w_h = gain sign(w) max(0, |w| - c se).
    """

    episodes: int = 200
    """How many recent compared episodes count."""
    gain: float = 2.0
    """Factor that brings a good participant near the environment's weight."""
    standard_errors: float = 2.0
    """c: what is not this many standard errors from 0 is taken for 0."""
    minimum_episodes: int = 10
    """With fewer episodes w_h = 0: their standard deviation says nothing."""
    consistent_above: float | None = None
    """w_h = 0 unless the presses so far follow the human model better than chance by so many standard errors
    (`core.learners.consistency`); None: not looked at."""

    def __post_init__(self) -> None:
        if self.consistent_above is not None and not self.consistent_above >= 0:
            raise ValueError(f"consistent_above is >= 0 standard errors or None, got {self.consistent_above}")
        if not 2 <= self.minimum_episodes <= self.episodes:
            raise ValueError(
                f"need 2 <= minimum_episodes <= episodes, got {self.minimum_episodes} and {self.episodes}"
            )
        if not (math.isfinite(self.gain) and self.gain > 0 and self.standard_errors >= 0):
            raise ValueError(f"need gain > 0 and standard_errors >= 0: {self.gain}, {self.standard_errors}")


class RankCorrelation(msgspec.Struct, frozen=True, tag="rank-correlation"):
    """Trust somebody if policies that agree with them do better (ours; `docs/decisions/signed-match.md`).

    r = Spearman's correlation between performance and agreement over recent episodes, less its standard error
    1 / sqrt(n - 1); w_h = gain r.
    """

    episodes: int = 200
    """How many recent compared episodes count."""
    gain: float = 1.5
    """Factor that brings a good participant near the environment's weight."""
    standard_errors: float = 1.0
    """What is not this many standard errors from 0 is taken for 0."""
    signed: bool = False
    """A negative correlation gives a negative weight; otherwise 0."""
    minimum_episodes: int = 10
    """With fewer episodes w_h = 0."""

    def __post_init__(self) -> None:
        if not 3 <= self.minimum_episodes <= self.episodes:
            raise ValueError(
                f"need 3 <= minimum_episodes <= episodes, got {self.minimum_episodes} and {self.episodes}"
            )
        if not (math.isfinite(self.gain) and self.gain > 0 and self.standard_errors >= 0):
            raise ValueError(f"need gain > 0 and standard_errors >= 0: {self.gain}, {self.standard_errors}")


class Tried(msgspec.Struct, frozen=True, tag="tried"):
    """The human's word is tried out, and performance says what to make of it (ours; `docs/decisions/tried-trust.md`).

    w_h = attitude * weight. The attitude is 1 (believe), 0, or -1 (believe the opposite), whichever went with the better
    episodes. Others are tried in a share of the episodes, but only while there is something to try: while the presses
    can be foreseen from what they are about (`core.learners.consistency`), as random ones cannot.
    """

    weight: float = 1.0
    """|w_h| of somebody who is believed: as much say as the environment, both being standardised."""
    consistent_above: float = 2.0
    """Standard errors by which presses must be foreseen better than chance for an attitude to be tried."""
    trial_share: float = 0.3
    """Share of episodes in which 1 or -1 is tried while the attitude is 0."""
    control_share: float = 0.05
    """Share of episodes played without the human while it is 1 or -1."""
    better_by: float = 3.0
    """Standard errors of the rank test (Mann & Whitney) by which another attitude must do better to be taken over."""
    minimum_episodes: int = 5
    """Episodes under an attitude before it is compared."""
    episodes: int = 200
    """How many recent compared episodes count."""

    def __post_init__(self) -> None:
        if not (0 <= self.trial_share <= 1 and 0 <= self.control_share <= 1):
            raise ValueError(f"shares are in [0, 1], got {self.trial_share} and {self.control_share}")
        if not (math.isfinite(self.weight) and self.weight > 0):
            raise ValueError(f"need weight > 0, got {self.weight}")
        if not min(self.better_by, self.consistent_above) >= 0:
            raise ValueError(
                f"need better_by >= 0 and consistent_above >= 0: {self.better_by}, {self.consistent_above}"
            )
        if not 2 <= self.minimum_episodes <= self.episodes:
            raise ValueError(
                f"need 2 <= minimum_episodes <= episodes, got {self.minimum_episodes} and {self.episodes}"
            )


class FixedWeight(msgspec.Struct, frozen=True, tag="fixed"):
    """Trust that no evidence changes: takes bootstrap learning out, for comparisons."""

    w_h: float = 1.0
    """As much say as the environment, both being standardised. (Our choice.)"""

    def __post_init__(self) -> None:
        if not math.isfinite(self.w_h):
            raise ValueError(f"w_h is finite, got {self.w_h}")


TrustRule = Equation4 | Equation5 | Signed | RankCorrelation | Tried | FixedWeight
"""How w_h follows from performance and match; msgspec decodes it by its tag, the field "type"."""


class BootstrapConfig(msgspec.Struct, frozen=True, kw_only=True, forbid_unknown_fields=True):
    """Bootstrap learning (section 3.1)."""

    trust: TrustRule = Equation4()
    """How w_h follows from performance and match (the paper's first equation for it)."""
    top_policies: int = 10
    """N, the number of policies kept. (The paper does not say; as many as the elite of one CE iteration.)"""
    symmetric: bool = True
    """A policy's selection probability rises with its match to the human policy, scaled by w_h: the agent
    "alternately assumes the policy based on each feedback mechanism to be ground truth"."""
    window_decisions: int = 200
    """Recent decisions kept for measuring matches anew. (Our choice.)"""

    def __post_init__(self) -> None:
        if self.top_policies < 1 or self.window_decisions < 1:
            raise ValueError(
                f"top_policies and window_decisions are >= 1: {self.top_policies}, {self.window_decisions}"
            )


class AskingConfig(msgspec.Struct, frozen=True, kw_only=True, forbid_unknown_fields=True):
    """When the agent poses a choice of candidate actions (`core.combination.asking`; `docs/decisions/asking.md`)."""

    per_episode: int = 0
    """Questions per watched episode at most. 0: the agent never asks, as in the paper's experiments."""
    options: int = 3
    """Candidate actions of a question at most, 2 or 3."""
    share: float = 0.05
    """It asks where its policies disagree more than in all but this share of recent decisions, in (0, 1). (Our choice.)"""
    memory: int = 200
    """How many recent decisions that share is of. (Our choice.)"""
    minimum_decisions: int = 20
    """It does not ask before it has seen this many. (Our choice.)"""

    def __post_init__(self) -> None:
        if self.per_episode < 0 or self.options not in (2, 3) or not 0 < self.share < 1:
            raise ValueError(
                "asking needs per_episode >= 0, 2 or 3 options and a share in (0, 1), got "
                f"{self.per_episode}, {self.options}, {self.share}"
            )
        if not 1 <= self.minimum_decisions <= self.memory:
            raise ValueError(
                f"need 1 <= minimum_decisions <= memory, got {self.minimum_decisions} and {self.memory}"
            )


def _linear_form(scale: Scale) -> int:
    return LINEAR if scale == "standardised" else LINEAR_RAW


def _check_annealing(beta_0: float, decay: float) -> None:
    if not (math.isfinite(beta_0) and beta_0 >= 0):
        raise ValueError(f"beta_0 is finite and >= 0, got {beta_0}")
    if not 0 < decay <= 1:
        raise ValueError(f"decay is a factor per episode in (0, 1], got {decay}")


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
