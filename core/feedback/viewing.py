"""How long everything is on screen, and how noticeable it is: what simulated participants see of a
session.
"""

from dataclasses import dataclass
from typing import Any, Protocol


@dataclass(frozen=True, slots=True)
class Watched:
    """How a participant sees one step."""

    duration_ns: int
    """How long it is on screen, >= 0."""
    judged_after_ns: int
    """From when on it can be judged, since it came on screen: their delay begins here."""
    attention: float = 1.0
    """Chance that it is judged, as a fraction of `TrainerConfig.press_probability`, in [0, 1]."""


class Viewing(Protocol):
    """The pace of a session."""

    @property
    def pause_ns(self) -> int:
        """How long the final picture of an episode stays, >= 0."""
        ...

    def opening_ns(self, first: Any) -> int:
        """Return how long an episode is on screen before its first decision, whose state is `first`; >= 0."""
        ...

    def watched(self, state: Any, action: int, following: Any) -> Watched:
        """Return how the step is seen that led from `state` by `action` to the state `following`."""
        ...


@dataclass(frozen=True, slots=True)
class SteadyViewing:
    """Every step takes the same time, and is judged at the same moment of it."""

    step_ns: int
    pause_ns: int
    judged_after_ns: int | None = None
    """From when on a step can be judged, since it came on screen; None: when its time is over."""

    def __post_init__(self) -> None:
        if self.step_ns <= 0 or self.pause_ns < 0:
            raise ValueError(f"need step_ns > 0 and pause_ns >= 0, got {self.step_ns} and {self.pause_ns}")

    def opening_ns(self, first: Any) -> int:
        """Return 0: the first step begins at once."""
        return 0

    def watched(self, state: Any, action: int, following: Any) -> Watched:
        """Return the same for all steps."""
        return Watched(self.step_ns, self.step_ns if self.judged_after_ns is None else self.judged_after_ns)
