"""Settings of a simulated participant in front of Keepaway. No numerical library is imported."""

from typing import Annotated, Literal

import msgspec

from core.configuration.fields import number
from core.feedback.config import TrainerConfig


class KeepawayPersonConfig(msgspec.Struct, frozen=True, kw_only=True, forbid_unknown_fields=True):
    """What kind of participant watches Keepaway.

    People judge events, not every 100 ms of holding: each pass may be judged when it is made, and holding now
    and then. An option is good if the participant would have chosen it.
    """

    trainer: TrainerConfig = TrainerConfig(press_probability=0.3, max_presses=2, mistake_rate=0.1)
    """Judgements, errors, delays. `press_probability` is the chance to judge a pass; at most two judgements
    per episode, about one in ten wrong (section 4). The chance of 0.3 is ours: with it the two presses of an
    episode do not always go to its first two passes. Delays run from the end of the option's first cycle,
    when it is seen to have been chosen."""
    holds_noticed_per_s: Annotated[float, number("per second", ge=0, le=1)] = 0.3
    """Chance, per second of holding, to look at the hold as one looks at a pass; it is then judged with
    `trainer.press_probability`. (Our choice: about as many judgements of holds as a third of all.)"""
    sees: Literal["keeper", "everything"] = "keeper"
    """What the participant goes by: what the keeper sees, or the exact state. With that, `trainer.knowledge`
    says what they would have chosen. Expert: the hand-coded policy's option; lay: the mate farthest from all
    takers when a taker is within 4 m, else hold."""

    def __post_init__(self) -> None:
        if not 0 <= self.holds_noticed_per_s <= 1:
            raise ValueError(f"holds_noticed_per_s is a chance in [0, 1], got {self.holds_noticed_per_s}")
        if self.trainer.knowledge == "myopic":
            raise ValueError("knowledge='myopic' is not known in Keepaway: an option has no immediate effect")
