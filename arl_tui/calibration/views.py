"""What a trial looks like: a box for stimuli, or the board of a game. The trial decides when, the view shows."""

from collections.abc import Sequence
from typing import Protocol

from textual.widget import Widget

from arl_tui.calibration.clips import MARK, Clip
from arl_tui.calibration.clips import TICK_MS as CYCLE_MS
from arl_tui.calibration.scenes import TICK_MS, Scene
from arl_tui.calibration.stimulus import StimulusBox
from arl_tui.palette import Palette
from arl_tui.widgets.board import TetrisBoard
from arl_tui.widgets.pitch import PitchWidget
from core.keepaway.picture import between
from core.keys import NS_PER_MS
from studies.reaction_time.protocol import TrialPlan

PICTURES_PER_CYCLE = 3
"""How often the pitch is drawn while a cycle of the game passes: 30 times a second."""


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

    def study(self, item: str) -> None:
        """Show something to remember."""
        ...

    def wait(self, plan: TrialPlan, tick: int) -> None:
        """Show what is seen `tick` ticks after the trial's start, before its stimulus."""
        ...

    def present(self, plan: TrialPlan) -> None:
        """Show the stimulus with the next paint."""
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

    def study(self, item: str) -> None:
        """Show an item in the middle."""
        self.box.show(item)

    def wait(self, plan: TrialPlan, tick: int) -> None:
        """Show the fixation mark."""
        self.box.fixate()

    def present(self, plan: TrialPlan) -> None:
        """Show the stimulus."""
        self.box.show(plan.stimulus, plan.index)

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
    """The real board: a piece hovers, then drops."""

    tick_ns: int | None = TICK_MS * NS_PER_MS

    def __init__(self, scenes: Sequence[Scene], palette: Palette) -> None:
        wall = scenes[0].wall
        self.board = TetrisBoard(wall.rows, wall.columns, palette=palette)
        self._scenes = scenes
        self._palette = palette

    @property
    def widget(self) -> Widget:
        """The board."""
        return self.board

    def renewed(self) -> "GameView":
        """Return the same game on a new board."""
        return GameView(self._scenes, self._palette)

    def study(self, item: str) -> None:
        """Do nothing: there is nothing to remember in a game."""

    def wait(self, plan: TrialPlan, tick: int) -> None:
        """Show the hovering piece."""
        self.board.show(self._scenes[plan.index].hovering(tick))

    def present(self, plan: TrialPlan) -> None:
        """Drop the piece."""
        self.board.show(self._scenes[plan.index].event(), plan.index)

    def rest(self) -> None:
        """Leave the board as it is."""

    def take_drawn(self) -> int:
        """Return what the board has drawn."""
        drawn, self.board.drawn_frame = self.board.drawn_frame, -1
        return drawn

    def note(self, plan: TrialPlan) -> str:
        """Return where the piece went."""
        return self._scenes[plan.index].note


class PitchView:
    """The real pitch: a possession is played, smooth between cycles, then one picture is marked.

    The play reaches the last cycle before the event just when the foreperiod ends: it does not stop before the event,
    which would announce it, and nothing of the event slides in. The event is one whole picture of a cycle.
    """

    tick_ns: int | None = CYCLE_MS * NS_PER_MS // PICTURES_PER_CYCLE

    def __init__(self, clips: Sequence[Clip], palette: Palette) -> None:
        first = clips[0].event
        self.pitch = PitchWidget(first.length_m, first.width_m, palette=palette)
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
        return PitchView(self._clips, self._palette)

    def study(self, item: str) -> None:
        """Do nothing: there is nothing to remember in a game."""

    def wait(self, plan: TrialPlan, tick: int) -> None:
        """Show the play before the event."""
        clip, foreperiod_ms = self._clips[plan.index], 1000.0 * plan.foreperiod_s
        early_ms = foreperiod_ms - int(foreperiod_ms / CYCLE_MS) * CYCLE_MS
        cycle, share = divmod(max(0.0, tick / PICTURES_PER_CYCLE - early_ms / CYCLE_MS), 1.0)
        self.pitch.note = ""
        self.pitch.show(between(clip.at(int(cycle)), clip.at(int(cycle) + 1), share))

    def present(self, plan: TrialPlan) -> None:
        """Show the event, with a mark: something changes on the screen whatever the event looks like."""
        self.pitch.show(self._clips[plan.index].event, plan.index)
        self.pitch.note = MARK

    def rest(self) -> None:
        """Leave the pitch as it is."""

    def take_drawn(self) -> int:
        """Return what the pitch has drawn."""
        drawn, self.pitch.drawn_frame = self.pitch.drawn_frame, -1
        return drawn

    def note(self, plan: TrialPlan) -> str:
        """Return what happened."""
        return self._clips[plan.index].note
