"""Schemes of combination: their settings, and the weights they give to an episode (Eqs. 2 and 3).

Nothing here needs compiled code; the decision itself is in `core.combination.preference`.
"""

import math
from typing import Annotated, ClassVar, Literal, get_args

import msgspec

from core.combination.episode_weights import (
    ADVISE,
    ENVIRONMENT_WEIGHTS,
    EXPONENTIAL,
    LINEAR,
    LINEAR_RAW,
    EpisodeWeights,
)
from core.configuration.fields import number
from core.learners.kinds import LearnerKind

Scale = Literal["standardised", "raw"]
Per = Literal["watched-game", "episode"]
"""What a weight that falls is counted by; k of an episode is the number of watched games, or of episodes,
before it."""
ActsOn = Literal["choice", "reward", "values", "policy"]
"""What of a learner a scheme acts on: its choices only, as any learner has, or what it learns: the reward of
each step, the values of actions, or the policy itself (`check_learner` refuses a learner without)."""
OFFERS: dict[LearnerKind, frozenset[ActsOn]] = {
    "search": frozenset({"choice"}),
    "climbing": frozenset({"choice", "reward", "policy"}),
    "stepwise": frozenset({"choice", "reward", "values"}),
}
"""What each kind of learner has that a scheme can act on."""
NEEDED: dict[ActsOn, str] = {
    "choice": "any learner",
    "reward": "a learner that learns at every step: policy-gradient or sarsa",
    "values": "a learner of action values that learns at every step: sarsa",
    "policy": "a learner with a softmax policy: policy-gradient",
}
"""Which learner a scheme needs, by what it acts on, for messages."""


class AnnealedWeight(msgspec.Struct, frozen=True, forbid_unknown_fields=True):
    """What schemes share whose weight of the participant falls: beta_k = beta_0 decay^k (Knox & Stone 2010).

    What beta weighs, and in which units, each scheme says. `core.combination.schedule` counts k by `per`.

    Raises:
        ValueError: beta_0 is not finite and >= 0, or decay is not in (0, 1].
    """

    beta_0: Annotated[float, number(ge=0, le=1e9)] = 1.0
    """Weight of the first episode, >= 0."""
    decay: Annotated[float, number(gt=0, le=1)] = 0.98
    """Factor per watched game or per episode, in (0, 1] (TAMER's code documents 0.98 for AAMAS 2010)."""
    per: Per = "watched-game"
    """What the weight falls with: each watched game, or each episode, unseen ones included
    (`docs/decisions/annealing.md`)."""

    def __post_init__(self) -> None:
        if not (math.isfinite(self.beta_0) and self.beta_0 >= 0):
            raise ValueError(f"beta_0 is finite and >= 0, got {self.beta_0}")
        if not 0 < self.decay <= 1:
            raise ValueError(f"decay is a factor in (0, 1], got {self.decay}")

    def beta(self, episode: int) -> float:
        """Return beta_k of number `episode` >= 0 of the schedule; ValueError for a negative number."""
        if episode < 0:
            raise ValueError(f"episodes count from 0, got {episode}")
        return self.beta_0 * self.decay**episode


class Linear(msgspec.Struct, frozen=True, forbid_unknown_fields=True, tag="linear"):
    """a = argmax w_r R + w_h H with w_r = 1 and w_h from bootstrap learning (Eq. 3)."""

    acts_on: ClassVar[ActsOn] = "choice"

    scale: Scale = "standardised"
    """What R and H are divided by (`docs/decisions/scale-of-r-and-h.md`)."""

    def episode_weights(self, trust: float, episode: int) -> EpisodeWeights:
        """Return the weights for the w_h that bootstrap learning holds now."""
        return EpisodeWeights(_linear_form(self.scale), 1.0, trust)


class Exponential(msgspec.Struct, frozen=True, forbid_unknown_fields=True, tag="exponential"):
    """a = argmax w_r R (1 + H^w_h) with w_r = 1 and w_h from bootstrap learning (section 3.1)."""

    acts_on: ClassVar[ActsOn] = "choice"

    def episode_weights(self, trust: float, episode: int) -> EpisodeWeights:
        """Return the weights for the w_h that bootstrap learning holds now."""
        return EpisodeWeights(EXPONENTIAL, 1.0, trust)


class Annealed(AnnealedWeight, frozen=True, forbid_unknown_fields=True, tag="annealed"):
    """Eq. 3 with w_h = beta_0 decay^k, k counted by `per`: the paper's baseline (section 4; Knox & Stone
    2010).
    """

    acts_on: ClassVar[ActsOn] = "choice"

    beta_0: Annotated[float, number(ge=0, le=1e9, usual=(0, 1000))] = 1.0
    """w_h of the first episode. 1: as much say as the environment, both being standardised. (Our choice.)"""
    scale: Scale = "standardised"
    """As in `Linear`."""

    def episode_weights(self, trust: float, episode: int) -> EpisodeWeights:
        """Return the weights at number `episode` >= 0 of the schedule; `trust` plays no part."""
        return EpisodeWeights(_linear_form(self.scale), 1.0, self.beta(episode))


class Constant(msgspec.Struct, frozen=True, forbid_unknown_fields=True, tag="constant"):
    """Eq. 3 with a weight that never changes: what bootstrap learning has to beat with a bad participant."""

    acts_on: ClassVar[ActsOn] = "choice"

    w_h: Annotated[float, number(ge=-1e9, le=1e9, usual=(-1000, 1000))] = 1.0
    """As much say as the environment, both being standardised. (Our choice.)"""
    scale: Scale = "standardised"
    """As in `Linear`."""

    def episode_weights(self, trust: float, episode: int) -> EpisodeWeights:
        """Return the constant weights; `trust` and `episode` play no part."""
        return EpisodeWeights(_linear_form(self.scale), 1.0, self.w_h)


class EnvironmentOnly(msgspec.Struct, frozen=True, forbid_unknown_fields=True, tag="environment-only"):
    """The underlying learner without a participant: a = argmax R (section 4, "default")."""

    acts_on: ClassVar[ActsOn] = "choice"

    def episode_weights(self, trust: float, episode: int) -> EpisodeWeights:
        """Return w_r = 1, w_h = 0."""
        return ENVIRONMENT_WEIGHTS


class HumanOnly(msgspec.Struct, frozen=True, forbid_unknown_fields=True, tag="human-only"):
    """The human model without an environment: a = argmax H, as TAMER (Knox & Stone 2009; section 4)."""

    acts_on: ClassVar[ActsOn] = "choice"

    def episode_weights(self, trust: float, episode: int) -> EpisodeWeights:
        """Return w_r = 0, w_h = 1."""
        return EpisodeWeights(LINEAR, 0.0, 1.0)


class ActionBiasing(AnnealedWeight, frozen=True, forbid_unknown_fields=True, tag="action-biasing"):
    """a = argmax Q + beta H at choice only, beta annealed (Knox & Stone 2010, technique 6).

    The scales of Q and H are the values' own, as in the source, so `beta_0` belongs to one task and one
    learner; where the scale of Q is arbitrary (policies of the cross-entropy method) ask for "standardised".
    """

    acts_on: ClassVar[ActsOn] = "choice"

    beta_0: Annotated[float, number(ge=0, le=1e9, usual=(0, 1e6))] = 10.0
    """Weight of the first episode (default of TAMER's code)."""
    scale: Scale = "raw"
    """As in `Linear`; the source adds raw values."""

    def episode_weights(self, trust: float, episode: int) -> EpisodeWeights:
        """Return the weights at number `episode` >= 0 of the schedule; `trust` plays no part."""
        return EpisodeWeights(_linear_form(self.scale), 1.0, self.beta(episode))


class ControlSharing(AnnealedWeight, frozen=True, forbid_unknown_fields=True, tag="control-sharing"):
    """With probability min(1, beta) take argmax H, else argmax R (Knox & Stone 2010, technique 7)."""

    acts_on: ClassVar[ActsOn] = "choice"

    beta_0: Annotated[float, number(ge=0, le=1e9, usual=(0, 1000))] = 1.0
    """Probability in the first episode, clipped to 1 (as in the Frogger study of Griffith et al. 2013)."""

    def episode_weights(self, trust: float, episode: int) -> EpisodeWeights:
        """Return the weights at number `episode` >= 0 of the schedule; `trust` plays no part."""
        return EpisodeWeights(LINEAR, 1.0, 0.0, min(1.0, self.beta(episode)))


class Advise(msgspec.Struct, frozen=True, forbid_unknown_fields=True, tag="advise"):
    """a = argmax pi_R(a) pi_H(a): policy shaping by the Advise rule (Griffith et al. 2013).

    pi_R is the softmax of R; pi_H = C^d / (C^d + (1 - C)^d), d being how much more often the action has been
    called right than wrong, and C how consistent the participant is. Where states do not come back nobody
    counts: d is H, standardised over the actions of the decision as R is (`docs/decisions/more-schemes.md`).
    """

    acts_on: ClassVar[ActsOn] = "choice"

    consistency: Annotated[float, number(gt=0, lt=1)] = 0.9
    """C, in (0, 1): chance that a press is right. 0.5 means nothing, less the opposite. (Paper, section 4: 1
    in 10 wrong.)"""
    temperature: Annotated[float, number("standard deviations of R", gt=0, le=1e9, usual=(0.001, 1000))] = 1.0
    """Of the softmax, > 0, in standard deviations of R. (Our choice.)"""

    def __post_init__(self) -> None:
        if not 0 < self.consistency < 1:
            raise ValueError(f"consistency is a chance in (0, 1), got {self.consistency}")
        if not (math.isfinite(self.temperature) and self.temperature > 0):
            raise ValueError(f"temperature is > 0, got {self.temperature}")

    def episode_weights(self, trust: float, episode: int) -> EpisodeWeights:
        """Return 1 / temperature and the log odds of C; `trust` and `episode` play no part."""
        odds = math.log(self.consistency / (1.0 - self.consistency))
        return EpisodeWeights(ADVISE, 1.0 / self.temperature, odds)


class RewardShaping(AnnealedWeight, frozen=True, forbid_unknown_fields=True, tag="reward-shaping"):
    """The learner learns from r + beta H(s, a), beta annealed, and chooses by R alone (Knox & Stone 2010,
    technique 1).
    """

    acts_on: ClassVar[ActsOn] = "reward"

    beta_0: Annotated[float, number(ge=0, le=1e9, usual=(0, 1e6))] = 1.0
    """Reward per unit of H in the first episode: a press is worth a line, or a cycle. (Our choice.)"""

    def episode_weights(self, trust: float, episode: int) -> EpisodeWeights:
        """Return the weights at number `episode` >= 0 of the schedule; `trust` plays no part."""
        return EpisodeWeights(LINEAR, 1.0, 0.0, shaping=self.beta(episode))


class QAugmentation(msgspec.Struct, frozen=True, forbid_unknown_fields=True, tag="q-augmentation"):
    """Q + beta H takes Q's place in learning and in choice, beta constant (Knox & Stone 2010, technique 4).

    The temporal difference of Q + beta H is that of Q with beta (gamma H(s', a') - H(s, a)) added to the
    reward.
    """

    acts_on: ClassVar[ActsOn] = "values"

    beta: Annotated[float, number(ge=-1e9, le=1e9, usual=(-1e6, 1e6))] = 1.0
    """Weight of H, in units of the return. (Our choice.)"""

    def __post_init__(self) -> None:
        if not math.isfinite(self.beta):
            raise ValueError(f"beta is finite, got {self.beta}")

    def episode_weights(self, trust: float, episode: int) -> EpisodeWeights:
        """Return the constant weights; `trust` and `episode` play no part."""
        return EpisodeWeights(LINEAR_RAW, 1.0, self.beta, augmentation=self.beta)


class Coach(msgspec.Struct, frozen=True, forbid_unknown_fields=True, tag="coach"):
    """A press is the advantage of what was done: it moves an actor's policy itself (COACH, MacGlashan et al.
    2017).

    theta <- theta + alpha f e, e being the trace of grad log pi up to the step that the press is about. No
    human model takes part in choices; the learner must be an actor (policy gradient).
    """

    acts_on: ClassVar[ActsOn] = "policy"

    step_size: Annotated[float, number(gt=0, le=1e6, usual=(1e-9, 10))] = 0.05
    """alpha of the presses, > 0. (Our choice; the source's 0.05 belongs to a robot's features.)"""
    trace_decay: Annotated[float, number(ge=0, le=1)] = 0.95
    """lambda of the trace, in [0, 1] (the source, for plain presses)."""
    environment_too: bool = True
    """The environment's reward goes on teaching; False: the source, where the participant is the only
    teacher."""

    def __post_init__(self) -> None:
        if not (math.isfinite(self.step_size) and self.step_size > 0 and 0 <= self.trace_decay <= 1):
            raise ValueError(
                f"need step_size > 0 and trace_decay in [0, 1]: {self.step_size}, {self.trace_decay}"
            )

    def episode_weights(self, trust: float, episode: int) -> EpisodeWeights:
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

SCHEMES: dict[str, type[Scheme]] = {str(kind.__struct_config__.tag): kind for kind in get_args(Scheme)}
"""Every scheme by its tag."""


def check_learner(scheme: Scheme, kind: LearnerKind, name: str) -> None:
    """Refuse a learner that a scheme cannot act on.

    Args:
        scheme: how environment and participant are combined.
        kind: of the environment's learner.
        name: of the learner, for the message.

    Raises:
        ValueError: the scheme acts on what the learner learns, and this one cannot be acted on so.
    """
    if scheme.acts_on not in OFFERS[kind]:
        raise ValueError(
            f"scheme {scheme.__struct_config__.tag} needs {NEEDED[scheme.acts_on]}; got {name}: choose "
            "another scheme ([agent.scheme] type) or another learner ([learner] type)"
        )


def waits_for_feedback(scheme: Scheme) -> bool:
    """Return whether the environment is played alone until the human model knows something: not in
    `HumanOnly`.
    """
    return not isinstance(scheme, HumanOnly)


def _linear_form(scale: Scale) -> int:
    return LINEAR if scale == "standardised" else LINEAR_RAW
