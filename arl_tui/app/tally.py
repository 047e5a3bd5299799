"""What a session has come to so far: for the screens, and for the summary at its end."""

from collections.abc import Sequence
from dataclasses import dataclass, field

from core.events import EpisodeEnded, EpisodeStarted, KeyPressed, Output, StepTaken, UnseenPlayed


@dataclass
class Tally:
    """What the summary at the end tells the participant."""

    performances: list[float] = field(default_factory=list)
    """Of the watched episodes."""
    unseen: int = 0
    """Episodes played out of sight."""
    practised: list[float] = field(default_factory=list)
    """Mean performance of each block of them."""
    good: int = 0
    bad: int = 0
    taken_back: int = 0
    said: dict[tuple[int, float], int] = field(default_factory=dict)
    """How many presses of each participant had each value, those taken back left out."""
    trust: float = 0.0
    """What the rule of trust says of the participant, after the last episode."""
    weight: float | None = None
    """Weight of the participant's judgement in the last watched game; None before the first."""
    steps: int = 0
    """Watched steps."""

    def count(self, press: KeyPressed, change: int) -> None:
        """Count an accepted press, or with -1 one that is taken back."""
        value = press.value or 0.0
        self.good += change if value > 0 else 0
        self.bad += change if value < 0 else 0
        self.said[press.person, value] = self.said.get((press.person, value), 0) + change

    def note(self, output: Output) -> None:
        """Take in what the domain or the agent did."""
        match output:
            case EpisodeStarted():
                self.weight = weight_in_use(output)
            case StepTaken():
                self.steps += 1
            case EpisodeEnded():
                self.performances.append(output.performance)
                self.trust = output.trust
            case UnseenPlayed():
                self.unseen += len(output.policies)
                self.practised.append(sum(output.performances) / len(output.performances))
                self.trust = output.trust
            case _:
                pass


def weight_in_use(episode: EpisodeStarted) -> float:
    """Return the weight that the participant has in an episode: in control sharing, the chance of a
    handover.
    """
    return episode.handover if episode.handover > 0 else episode.weight


def beginning_and_end(performances: Sequence[float]) -> tuple[float, float]:
    """Return how the agent played at the beginning and at the end: means of a third of the games each.

    Args:
        performances: of watched games in their order, at least one.
    """
    third = max(1, len(performances) // 3)
    first, last = performances[:third], performances[-third:]
    return sum(first) / third, sum(last) / third
