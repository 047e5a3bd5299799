"""How environment and participant are combined during one episode: the form of f(R, H), and its weights (Eqs.
2 and 3).
"""

import math
from dataclasses import dataclass

LINEAR = 0
"""Form: argmax w_r R + w_h H, both standardised over the actions of the decision (Eq. 3)."""
EXPONENTIAL = 1
"""Form: argmax w_r R (1 + H^w_h), H mapped to [0, 1] and R shifted to >= 0 (section 3.1)."""
LINEAR_RAW = 2
"""Form: argmax w_r R + w_h H of the values as they come (Eq. 3 to the letter)."""
ADVISE = 3
"""Form: argmax pi_R pi_H, softmax of R times the probability that the participant calls the action right
(Advise)."""

FORM_NAMES: dict[int, str] = {
    LINEAR: "linear",
    EXPONENTIAL: "exponential",
    LINEAR_RAW: "linear, raw values",
    ADVISE: "Advise",
}
"""Names of the forms, for reports."""


@dataclass(frozen=True, slots=True)
class EpisodeWeights:
    """How environment and participant are combined during one episode."""

    form: int
    """LINEAR, EXPONENTIAL, LINEAR_RAW or ADVISE."""
    w_r: float
    """Weight of the environment's values, >= 0."""
    w_h: float
    """Weight of the participant's values; negative where the participant is believed to mean the opposite."""
    handover: float = 0.0
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
        if not 0 <= self.handover <= 1:
            raise ValueError(f"handover is a probability, got {self.handover}")
        if not (math.isfinite(self.shaping) and math.isfinite(self.augmentation)):
            raise ValueError(
                f"shaping and augmentation are finite, got {self.shaping} and {self.augmentation}"
            )


ENVIRONMENT_WEIGHTS = EpisodeWeights(LINEAR, 1.0, 0.0)
"""The environment alone: what an agent plays before there is any feedback."""
