"""What a trial looks like: a box for stimuli, or the board of a game. The trial decides when, the view shows."""

from collections.abc import Sequence
from typing import Protocol

from textual.widget import Widget

from arl_tui.calibration.clips import MARK, Clip
from arl_tui.calibration.scenes import TrialPosition
from arl_tui.calibration.stimulus import StimulusBox
from arl_tui.palette import Palette
from arl_tui.widgets.board import TetrisBoard
from arl_tui.widgets.pitch import PitchWidget
from core.feedback.keys import NS_PER_MS
from core.keepaway.picture import between
from studies.reaction_time.protocol import TrialPlan

PICTURES_PER_S = 30
"""How often the pitch is drawn, as in a session."""


class View(Protocol):
    """Shows trials."""

    tick_ns: int | None
    """What is seen before the stimulus changes after each such time; None: it stands still."""

    @property
    def widget(self) -> Widget:
        """The widget that is laid out."""
        ...

    def renewed(self) -> "View":
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


class GameView:
    """The real board: a piece enters, is moved and drops, picture by picture as in a session."""

    def __init__(
        self, positions: Sequence[TrialPosition], palette: Palette, tick_ms: int, time_out_s: float
    ) -> None:
        """Show the first trial's board.

        Args:
            positions: of all trials.
            palette: colours.
            tick_ms: how long a picture is shown.
            time_out_s: of the task: in a catch trial no piece drops before it.
        """
        first = positions[0].waiting
        self.board = TetrisBoard(first.rows, first.columns, palette=palette)
        self.tick_ns: int | None = tick_ms * NS_PER_MS
        self._given = (positions, palette, tick_ms, time_out_s)
        self._positions = positions
        self._tick_ms = tick_ms
        self._time_out_s = time_out_s
        self._dropped = -1
        """The trial whose piece is falling; -1 where none is."""

    @property
    def widget(self) -> Widget:
        """The board."""
        return self.board

    def renewed(self) -> "GameView":
        """Return the same game on a new board."""
        return GameView(*self._given)

    def early_ns(self, plan: TrialPlan) -> int:
        """Return what is left of the foreperiod beside whole ticks: every move is shown for a whole one."""
        return round(plan.foreperiod_s * 1000 * NS_PER_MS) % (self._tick_ms * NS_PER_MS)

    def study(self, item: str) -> None:
        """Do nothing: there is nothing to remember in a game."""

    def wait(self, plan: TrialPlan, tick: int) -> None:
        """Show the board, then the piece that enters and is moved until the foreperiod is over."""
        self._dropped = -1
        waited_s = plan.foreperiod_s + (self._time_out_s if plan.catch else 0.0)
        ticks = int(1000 * waited_s / self._tick_ms + 1e-9) + (1 if plan.catch else 0)
        self.board.show(self._positions[plan.index].at(max(1, ticks - tick)))

    def present(self, plan: TrialPlan) -> None:
        """Begin the drop."""
        self._dropped = plan.index
        self.board.show(self._positions[plan.index].event[0], plan.index)

    def follow(self, plan: TrialPlan, tick: int) -> None:
        """Let the piece fall and settle."""
        event = self._positions[plan.index].event
        if tick > 0:
            self.board.show(event[min(tick, len(event) - 1)])

    def rest(self) -> None:
        """Show the settled board where a piece has dropped."""
        if self._dropped >= 0:
            self.board.show(self._positions[self._dropped].event[-1])
            self._dropped = -1

    def take_drawn(self) -> int:
        """Return what the board has drawn."""
        return self.board.take_drawn()

    def note(self, plan: TrialPlan) -> str:
        """Return where the piece went."""
        return self._positions[plan.index].note


class PitchView:
    """The real pitch: a possession is played, smooth between cycles, then one picture is marked.

    The play reaches the last cycle before the event just when the foreperiod ends: it does not stop before the event,
    which would announce it, and nothing of the event slides in. The event is one whole picture of a cycle.
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

    def renewed(self) -> "PitchView":
        """Return the same game on a new pitch."""
        return PitchView(self._clips, self._palette, self._cycle_ms)

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
        self.pitch.note = MARK

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
