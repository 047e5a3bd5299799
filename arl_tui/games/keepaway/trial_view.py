"""Keepaway in the feedback-lag task: the real pitch."""

from collections.abc import Sequence

from textual.widget import Widget

from arl_tui.games.keepaway.judging import MARK, Clip
from arl_tui.language import tr
from arl_tui.palette import Palette
from arl_tui.widgets.pitch import PitchWidget
from core.keepaway.picture import between
from core.numerics.clock import NS_PER_MS
from studies.reaction_time.protocol import TrialPlan

PICTURES_PER_S = 30
"""How often the pitch is drawn, as in a session."""


class PitchTrialView:
    """The real pitch: a possession is played, smooth between cycles, then one picture is marked.

    The play reaches the last cycle before the event just when the foreperiod ends: it does not stop before
    the event, which would announce it, and nothing of the event slides in. The event is one whole picture of
    a cycle.
    """

    def __init__(self, clips: Sequence[Clip], palette: Palette, cycle_ms: float) -> None:
        """Show an empty pitch.

        Args:
            clips: of all trials.
            palette: colours.
            cycle_ms: how long a cycle is shown.
        """
        first = clips[0].event
        # Without words: what is going on, and how it ended, is what the participant is to say.
        self.pitch = PitchWidget(first.length_m, first.width_m, palette=palette, caption=False)
        self._cycle_ms = cycle_ms
        self._per_cycle = max(1, round(cycle_ms * PICTURES_PER_S / 1000))
        self.tick_ns: int | None = round(cycle_ms * NS_PER_MS / self._per_cycle)
        # As large as there is room for beside the words, in the smallest window.
        self.pitch.styles.width, self.pitch.styles.height = 34, 20
        self._clips = clips
        self._palette = palette

    @property
    def widget(self) -> Widget:
        """The pitch."""
        return self.pitch

    def renewed(self) -> "PitchTrialView":
        """Return the same game on a new pitch."""
        return PitchTrialView(self._clips, self._palette, self._cycle_ms)

    def early_ns(self, plan: TrialPlan) -> int:
        """Return 0: pictures are drawn often enough."""
        return 0

    def study(self, item: str) -> None:
        """Do nothing: there is nothing to remember in a game."""

    def wait(self, plan: TrialPlan, tick: int) -> None:
        """Show the play before the event."""
        clip, foreperiod_ms = self._clips[plan.index], 1000.0 * plan.foreperiod_s
        early_ms = foreperiod_ms % self._cycle_ms
        cycle, fraction = divmod(max(0.0, tick / self._per_cycle - early_ms / self._cycle_ms), 1.0)
        self.pitch.note = ""
        self.pitch.show(between(clip.at(int(cycle)), clip.at(int(cycle) + 1), fraction))

    def present(self, plan: TrialPlan) -> None:
        """Show the event, with a mark: something changes on the screen whatever the event looks like."""
        self.pitch.show(self._clips[plan.index].event, plan.index)
        self.pitch.note = tr(MARK)

    def follow(self, plan: TrialPlan, tick: int) -> None:
        """Leave the event."""

    def rest(self) -> None:
        """Leave the pitch as it is."""

    def take_drawn(self) -> int:
        """Return what the pitch has drawn."""
        drawn, self.pitch.drawn_frame = self.pitch.drawn_frame, -1
        return drawn

    def note(self, plan: TrialPlan) -> str:
        """Return what happened."""
        return self._clips[plan.index].note
