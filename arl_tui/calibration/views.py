"""Trials without a game: stimuli in a box."""

from textual.widget import Widget

from arl_tui.calibration.stimulus import StimulusBox
from studies.reaction_time.protocol import TrialPlan


class BoxView:
    """Stimuli in a box, after a fixation mark."""

    tick_ns: int | None = None

    def __init__(self) -> None:
        self.box = StimulusBox()

    @property
    def widget(self) -> Widget:
        """The box."""
        return self.box

    def renewed(self) -> "BoxView":
        """Return a new box."""
        return BoxView()

    def early_ns(self, plan: TrialPlan) -> int:
        """Return 0."""
        return 0

    def study(self, item: str) -> None:
        """Show an item in the middle."""
        self.box.show(item)

    def wait(self, plan: TrialPlan, tick: int) -> None:
        """Show the fixation mark."""
        self.box.fixate()

    def present(self, plan: TrialPlan) -> None:
        """Show the stimulus."""
        self.box.show(plan.stimulus, plan.index)

    def follow(self, plan: TrialPlan, tick: int) -> None:
        """Leave the stimulus."""

    def rest(self) -> None:
        """Show nothing."""
        self.box.clear()

    def take_drawn(self) -> int:
        """Return what the box has drawn."""
        drawn, self.box.drawn = self.box.drawn, -1
        return drawn

    def note(self, plan: TrialPlan) -> str:
        """Return nothing: the plan tells all."""
        return ""
