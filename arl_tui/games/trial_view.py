"""What a trial of a reaction-time task looks like: the trial decides when, the view shows."""

from typing import Protocol

from textual.widget import Widget

from studies.reaction_time.protocol import TrialPlan


class TrialView(Protocol):
    """Shows trials."""

    tick_ns: int | None
    """What is seen before the stimulus changes after each such time; None: it stands still."""

    @property
    def widget(self) -> Widget:
        """The widget that is laid out."""
        ...

    def renewed(self) -> "TrialView":
        """Return a view like this one with a widget of its own: a widget goes with its screen."""
        ...

    def early_ns(self, plan: TrialPlan) -> int:
        """Return how long after the trial's start the first tick begins; before, it is tick -1."""
        ...

    def study(self, item: str) -> None:
        """Show something to remember."""
        ...

    def wait(self, plan: TrialPlan, tick: int) -> None:
        """Show what is seen `tick` ticks after the trial's start, before its stimulus."""
        ...

    def present(self, plan: TrialPlan) -> None:
        """Show the stimulus with the next paint."""
        ...

    def follow(self, plan: TrialPlan, tick: int) -> None:
        """Show what is seen `tick` ticks after the stimulus, while the response is awaited."""
        ...

    def rest(self) -> None:
        """Show what is seen between trials."""
        ...

    def take_drawn(self) -> int:
        """Return the trial whose stimulus has been drawn since the last call; -1 where none has."""
        ...

    def note(self, plan: TrialPlan) -> str:
        """Return what the plan does not tell of what was shown, for the record."""
        ...
