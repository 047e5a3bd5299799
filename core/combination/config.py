"""Settings of the combination schemes and the weights they give to an episode (Eqs. 2 and 3).

Nothing here needs compiled code, so a protocol can be read without it; the decision itself is in
`core.combination.schemes`.
"""

import math
from dataclasses import dataclass
from typing import Literal

import msgspec

Scale = Literal["standardised", "raw"]

LINEAR = 0
"""Form: argmax w_r R + w_h H, both standardised over the actions of the decision (Eq. 3)."""
EXPONENTIAL = 1
"""Form: argmax w_r R (1 + H^w_h), H mapped to [0, 1] and R shifted to >= 0 (section 3.1)."""
LINEAR_RAW = 2
"""Form: argmax w_r R + w_h H of the values as they come (Eq. 3 to the letter)."""


@dataclass(frozen=True, slots=True)
class EpisodeWeights:
    """How environment and human are combined during one episode."""

    form: int
    """LINEAR, EXPONENTIAL or LINEAR_RAW."""
    w_r: float
    """Weight of the environment's values, >= 0."""
    w_h: float
    """Weight of the human's values; negative where the human is believed to mean the opposite."""
    share: float = 0.0
    """Probability, per decision, of taking the human model's best action instead, in [0, 1]."""

    def __post_init__(self) -> None:
        if self.form not in (LINEAR, EXPONENTIAL, LINEAR_RAW):
            raise ValueError(f"form is {LINEAR}, {EXPONENTIAL} or {LINEAR_RAW}, got {self.form}")
        if not (math.isfinite(self.w_r) and self.w_r >= 0 and math.isfinite(self.w_h)):
            raise ValueError(f"w_r is finite and >= 0, w_h finite; got w_r={self.w_r}, w_h={self.w_h}")
        if not 0 <= self.share <= 1:
            raise ValueError(f"share is a probability, got {self.share}")


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


Scheme = (
    Linear | Exponential | Annealed | Constant | EnvironmentOnly | HumanOnly | ActionBiasing | ControlSharing
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
}
"""Every scheme by its tag: the one registry."""


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
