"""A question of the agent on the play screen: its options, their keys, and the time that is left."""

import math
from asyncio import TimerHandle
from collections.abc import Sequence
from typing import ClassVar

from textual.geometry import Region, Size
from textual.message_pump import MessagePump
from textual.strip import Strip
from textual.widgets import Static

from arl_tui.app.link import AskNow
from arl_tui.app.live_session import LiveSession
from arl_tui.app.once import after
from arl_tui.games.panel import DrawsOptions, Panel
from arl_tui.games.registry import screens_of
from arl_tui.language import later, tr
from arl_tui.screens.page import BAR_WIDTH, key_cap
from arl_tui.widgets.feedback_bar import FeedbackBar
from core.events import QuestionAnswered, QuestionPosed
from core.feedback.asking_config import AskingConfig
from core.session.protocol import Protocol

ANSWERS = later("answer the computer's questions; {none} none of these")
TITLE = later("A question for you")
COMING = later("A question comes: you may judge\nthe last {step} first.")
NONE_OF_THESE = later("none of these")
TIME_LEFT = later("{seconds} s left")
WHAT_TO_DO = later("Press {keys} or {last} to answer")
WAITS = later("The game waits for your answer.")
CHOSEN = later("Thank you: the computer learns from your answer.")
NOT_CHOSEN = later("No answer, and that is fine. The game goes on.")
"""What participants read, except for the options themselves (`GameScreens.option`)."""
TICK_S = 0.25
"""How often the time that is left is looked at, seconds."""


def about_questions(asking: AskingConfig) -> str:
    """Return what participants are told of questions before the first game; in markup."""
    keys = " ".join(key_cap(key) for key in asking.keys[: asking.options])
    return f"  {keys}  {tr(ANSWERS, none=key_cap(asking.none_key))}"


class QuestionBar(Static, inherit_bindings=False, can_focus=False):
    """Takes the place of the feedback bar while a question is open: nothing else moves."""

    DEFAULT_CSS: ClassVar[str] = f"""
    QuestionBar {{
        width: 1fr;
        height: {FeedbackBar.LINES_HIGH + 2};
        border: round $accent;
        border-title-color: $foreground;
        padding: 0 1;
        display: none;
    }}
    """
    ALLOW_SELECT: ClassVar[bool] = False

    def __init__(self) -> None:
        super().__init__(id="question")
        self.border_title = tr(TITLE)
        self._drawn = False

    def render_lines(self, crop: Region) -> list[Strip]:
        """Return the lines, and note that they have been drawn."""
        self._drawn = self._drawn or crop.size != Size(0, 0)
        return super().render_lines(crop)

    def take_drawn(self) -> bool:
        """Return whether the question has been drawn since the last call."""
        drawn, self._drawn = self._drawn, False
        return drawn


class Questioning:
    """Shows questions, and takes them off the screen when they are over."""

    def __init__(
        self,
        pump: MessagePump,
        live: LiveSession,
        panel: Panel,
        feedback: FeedbackBar,
        protocol: Protocol,
    ) -> None:
        """Prepare.

        Args:
            pump: whose task looks at the time.
            live: the session.
            panel: the game's picture.
            feedback: whose place a question takes.
            protocol: of the session: the game's words, keys and limit.
        """
        self.bar = QuestionBar()
        self._pump = pump
        self._live = live
        self._panel = panel
        self._feedback = feedback
        self._protocol = protocol
        self._screens = screens_of(protocol)
        self._asking = protocol.agent.asking
        self._posed: QuestionPosed | None = None
        self._ask_now: AskNow | None = None
        self._timer: TimerHandle | None = None
        self._hint = False
        self.answered_press = -1
        """Number of the press that gave the last answer."""

    @property
    def waiting(self) -> bool:
        """Whether a question is to be on screen as soon as nothing else lies over the game."""
        return self._ask_now is not None

    @property
    def on_screen(self) -> bool:
        """Whether a question covers the game."""
        return self._live.question is not None

    def announce(self, posed: QuestionPosed) -> None:
        """Take in what will be asked."""
        self._posed = posed

    def coming(self) -> str:
        """Return what stands beside the game before a question."""
        return tr(COMING, step=tr(self._screens.words.step))

    def ask(self, ask_now: AskNow) -> None:
        """Show the question at once, or when the page is gone that lies over the game."""
        self._ask_now = ask_now
        if not self._live.gate.covered:
            self.show()

    def show(self) -> None:
        """Draw the options; the game is covered from here on."""
        if self._posed is None or self._ask_now is None:
            return
        self._live.pose(self._posed)
        keys = self._asking.keys[: len(self._posed.options)]
        if isinstance(self._panel, DrawsOptions):
            self._panel.pose(self._ask_now.places, keys)
        self._hint = False
        self.bar.take_drawn()
        self._feedback.display, self.bar.display = False, True
        self._write(self._asking.limit_s)
        self._tick()

    def hint(self) -> None:
        """Say which keys answer: another one has been pressed."""
        self._hint = True
        self._tick()

    def take_down(self) -> None:
        """Make room for a page; the question comes back after it, with all its time."""
        if self.on_screen:
            self._live.take_question_down()
            self._clear()

    def over(self, answered: QuestionAnswered | None = None) -> str:
        """Forget the question; return what the participant is told."""
        self._posed = self._ask_now = None
        self._clear()
        if answered is None:
            return ""
        self.answered_press = answered.press
        return tr(CHOSEN if answered.chosen >= 0 else NOT_CHOSEN)

    def _clear(self) -> None:
        if self._timer is not None:
            self._timer.cancel()
            self._timer = None
        self.bar.display, self._feedback.display = False, True
        if isinstance(self._panel, DrawsOptions):
            self._panel.unpose()

    def _tick(self) -> None:
        if self._timer is not None:
            self._timer.cancel()
            self._timer = None
        left_s = self._live.look_at_question()  # ends the question where its time is up
        if left_s is not None:
            self._write(left_s)
            self._timer = after(self._pump, TICK_S, self._tick)

    def _write(self, left_s: float) -> None:
        assert self._posed is not None, "a question is on screen"
        keys = self._asking.keys[: len(self._posed.options)]
        lines = [f"[b]{tr(self._screens.words.question)}[/]", ""]
        lines += [
            f" {key_cap(key)}  {self._screens.option(detail, self._protocol)}"
            for key, detail in zip(keys, self._posed.details, strict=True)
        ]
        lines += [f" {key_cap(self._asking.none_key)}  {tr(NONE_OF_THESE)}", ""]
        lines += [self._time(left_s), self._call(keys)]
        self.bar.update("\n".join(lines))

    def _time(self, left_s: float) -> str:
        full = max(0, min(BAR_WIDTH, math.ceil(BAR_WIDTH * left_s / self._asking.limit_s)))
        seconds = tr(TIME_LEFT, seconds=max(0, math.ceil(left_s)))
        return f"{'━' * full}[dim]{'─' * (BAR_WIDTH - full)}[/] {seconds}"

    def _call(self, keys: Sequence[str]) -> str:
        if not self._hint:
            return tr(WAITS)
        return f"[b]{tr(WHAT_TO_DO, keys=', '.join(keys), last=self._asking.none_key)}[/]"
