"""The game on screen: its picture, feedback, figures, and the keys that steer the session."""

from collections.abc import Callable, Iterable
from typing import ClassVar, cast

from textual import events
from textual.app import ComposeResult
from textual.binding import Binding, BindingType
from textual.containers import Horizontal, Vertical
from textual.screen import Screen
from textual.widgets import Static

from arl_tui.app.gaps import length_s
from arl_tui.app.link import AskNow, Picture, Preparing, TakenFor
from arl_tui.app.live_session import Cover, LiveSession, Occurrence
from arl_tui.app.once import after
from arl_tui.app.outcome import SessionControls
from arl_tui.app.tally import weight_in_use
from arl_tui.games.panel import Progress
from arl_tui.games.registry import screens_of, words_of
from arl_tui.palette import Palette
from arl_tui.screens.count_down import CountDown
from arl_tui.screens.covers import HelpScreen, PauseScreen, SmallWindowScreen, StopScreen, fits_into
from arl_tui.screens.page import PageScreen, session_keys
from arl_tui.screens.question import Questioning
from arl_tui.widgets.feedback_bar import HOLD_S, FeedbackBar
from arl_tui.widgets.people_bar import PeopleBar
from core.events import (
    EpisodeEnded,
    EpisodeStarted,
    KeyPressed,
    Output,
    PressRetracted,
    QuestionAnswered,
    QuestionPosed,
    SessionEnded,
    StopAsked,
    TimeGap,
    WrongPressAsked,
)
from core.session.protocol import Protocol

COMMANDS: dict[str, tuple[str, str]] = {
    # action: (letter, keys that are there even if the letter is a feedback key)
    "pause": ("p", "space"),
    "guide": ("h", "f1"),
    "leave": ("q", "ctrl+q,ctrl+c"),
}


BAR_WIDTH = 20
"""Cells."""


def bar(fraction: float) -> str:
    """Return a bar for a fraction in [0, 1], and the fraction in per cent."""
    done = round(fraction * BAR_WIDTH)
    return f"{'━' * done}[dim]{'─' * (BAR_WIDTH - done)}[/] {fraction:.0%}"


class PlayScreen(Screen[None], inherit_bindings=False):
    """Draws what the session reports; decides nothing about it."""

    BINDING_GROUP_TITLE = "Session"
    BINDINGS: ClassVar[list[BindingType]] = [
        Binding(COMMANDS["pause"][1], "pause", "Pause", id="play.pause", tooltip="Let the game wait"),
        Binding(COMMANDS["guide"][1], "guide", "Help", id="play.help", tooltip="Show all keys"),
        Binding(COMMANDS["leave"][1], "leave", "Stop", id="play.stop", tooltip="Stop the session"),
    ]

    def __init__(self, protocol: Protocol, live: LiveSession, palette: Palette) -> None:
        """Draw a session that has not begun.

        Args:
            protocol: size of the board, keys, number of games.
            live: the session; asked only to cover and uncover.
            palette: colours of the game.
        """
        super().__init__()
        self.panel = screens_of(protocol).panel(protocol, palette)
        self.add_class(f"-{protocol.game}")
        names = [person.name for person in protocol.people]
        keys = protocol.keys_of_people
        self.feedback = (
            PeopleBar(list(zip(names, keys, strict=True))) if names else FeedbackBar(protocol.keys)
        )
        self._several = len(keys) > 1
        self._status = Static(id="status")
        self._protocol = protocol
        self._words = words_of(protocol.game)
        self._episodes = protocol.session.episodes
        self._unseen = protocol.session.unseen_between
        self._live = live
        self._picture: Picture | None = None
        self._watched = 0
        self._playing = False
        """Whether a watched game has begun and not ended."""
        self._human_weights: list[float] = []
        """In use, one per game so far; empty where they are not to be seen."""
        self._shows_weight = protocol.screen.show_weight
        self._counts = protocol.screen.count_down_s > 0
        self._count_down = CountDown(self, self.panel.game_widget(), protocol.screen.count_down_s)
        self._questioning = Questioning(self, live, self.panel, self.feedback, protocol)
        self._said = ""
        self._silence_shown = False
        self._disk_failed = False
        used = {letter for each in keys for letter in each.letters}
        self._letters = {letter: action for action, (letter, _) in COMMANDS.items() if letter not in used}

    def compose(self) -> ComposeResult:
        """Lay everything out in fixed sizes."""
        with Horizontal(id="play-area"):
            yield self.panel.game_widget()
            with Vertical(id="side"):
                with Horizontal(id="figures"):
                    yield from self.panel.figures()
                yield self.feedback
                yield self._questioning.bar
                yield self._status
        yield Static(session_keys(*self._protocol.keys_of_people), id="session-keys")

    # --- what happens ---------------------------------------------------------------------------------------

    def show(self, occurrence: Occurrence) -> None:
        """Draw what has happened."""
        match occurrence:
            case Picture():
                self._show_picture(occurrence)
            case KeyPressed():
                self._show_press(occurrence)
            case TakenFor():
                self.feedback.show_taken(self.panel.mark(occurrence), occurrence.press)
            case PressRetracted():
                self.panel.unmark()
                self.feedback.show_retraction(occurrence, self._live.left_of(occurrence))
                self._tell_presses_left()
            case WrongPressAsked():
                self.feedback.ask_wrong(True)
            case EpisodeStarted():
                self._begin_episode(occurrence)
            case EpisodeEnded():
                self._end_episode(occurrence)
            case Preparing(fraction=fraction) if self._live.phase == "running":
                self._say(f"One moment, this first time:\n{bar(fraction)}")
            case QuestionPosed() | AskNow() | QuestionAnswered():
                self._show_question(occurrence)
            case TimeGap():
                self._lay_over(PauseScreen(gap_s=length_s(occurrence)), "gap")
            case StopAsked() | SessionEnded():
                self._count_down.stop()
                self._questioning.over()
                self._say("Stopping: everything is being saved ...")

    def go_on_after(self, outputs: Iterable[Output]) -> None:
        """Count the games that were finished before the session broke off."""
        for output in outputs:
            if isinstance(output, EpisodeStarted):
                self._watched += 1
                if self._shows_weight:
                    self._human_weights.append(weight_in_use(output))

    def take_painted(self) -> int | None:
        """Return the step whose picture has been drawn since the last call; None where none has."""
        drawn = self.panel.take_drawn()
        return self._picture.step if drawn and self._picture is not None else None

    def _show_picture(self, picture: Picture) -> None:
        self._picture = picture
        performances = tuple(self._live.tally.performances)
        progress = Progress(max(1, self._watched), self._episodes, tuple(self._human_weights), performances)
        self.panel.show(picture, progress)

    def take_question_painted(self) -> bool:
        """Return whether the options of a question have been drawn that was not on screen before."""
        question = self._live.question
        return question is not None and question.needs_frame and self._questioning.bar.take_drawn()

    def _show_question(self, occurrence: QuestionPosed | AskNow | QuestionAnswered) -> None:
        match occurrence:
            case QuestionPosed():
                self._questioning.announce(occurrence)
                self._say(self._questioning.coming())
            case AskNow():
                self._say("")
                self._questioning.ask(occurrence)
            case QuestionAnswered():
                said = self._questioning.over(occurrence)
                self._say(said)
                after(self, HOLD_S, lambda: self._say("" if self._said == said else self._said))
                self.panel.refresh()

    def _show_press(self, press: KeyPressed) -> None:
        if press.press == self._questioning.answered_press:
            return
        if self._questioning.on_screen and press.value is not None:
            self._questioning.hint()
            return
        is_command = any(
            (press.read_as or press.key) in (letter, *keys.split(",")) for letter, keys in COMMANDS.values()
        )
        if press.verdict != "other" or not is_command:
            self.feedback.show_press(press, self._live.left_of(press))
        self.feedback.ask_wrong(self._live.gate.wrong_asked)
        self._tell_presses_left()

    def _tell_presses_left(self) -> None:
        """Write beside the game how many presses are left: of several people the feedback bar says it."""
        if not self._several:
            self.panel.presses_left(self._live.presses_left)

    def _begin_episode(self, episode: EpisodeStarted) -> None:
        self._watched += 1
        self._playing = True
        if self._shows_weight:
            self._human_weights.append(weight_in_use(episode))
        self.feedback.begin_game(self._live.presses_left)
        self._tell_presses_left()
        self.panel.title(f"Game {self._watched}")
        self.panel.unmark()
        self._say("")
        if not self._live.gate.covered:  # a page lies over the game: the count-down comes when it is left
            self._count()

    def _count(self) -> None:
        """Count down; no step is on screen meanwhile."""
        if not self._counts:
            return
        self._live.count_down()
        self._count_down.start(f"Game {self._watched}", self._go_on)

    def _go_on(self) -> None:
        """Let the game go on, and draw once more: what was drawn before came too early to count."""
        self._live.uncover()
        if self._questioning.waiting:
            self._questioning.show()
        self.panel.refresh()

    def _end_episode(self, episode: EpisodeEnded) -> None:
        self._playing = False
        lines = self._words.told(episode.performance)
        self.panel.title("Game over" if episode.ended == "termination" else "End of this game")
        if self._watched >= self._episodes or self._live.phase != "running":
            self._say(f"That was the last game: {lines}.")
        elif self._unseen:
            self._say(
                f"{lines}. Before the next game, the computer\npractises {self._unseen} games on its own."
            )
        else:
            self._say(f"{lines}. The next game is about to begin.")

    def _say(self, text: str) -> None:
        if self._disk_failed:
            return
        self._said = text
        self._silence_shown = False
        self._status.update(text)

    def show_disk_failure(self) -> None:
        """Say that nothing counts from here on, because it cannot be recorded."""
        self.feedback.show_not_saved()
        self._say("[b]The recording cannot be written.[/]\nThe session ends here.")
        self._disk_failed = True

    def show_silence(self, silent_s: float | None) -> None:
        """Say for how long the learner has not answered, seconds; None: it does."""
        if silent_s is not None:
            self._silence_shown = True
            waits = "Still practising" if not self._playing else "The computer has not answered"
            key = "Q" if "q" in self._letters else "Ctrl+Q"
            self._status.update(f"{waits} for {silent_s:.0f} s.\n{key} ends the session; all is kept.")
        elif self._silence_shown:
            self._say(self._said)

    # --- what the participant asks for ----------------------------------------------------------------------

    async def on_key(self, event: events.Key) -> None:
        """Act on a command's letter, unless the protocol has given it to feedback."""
        action = self._letters.get(event.key.lower())
        if action is not None:
            event.stop()
            await self.run_action(action)

    def action_pause(self) -> None:
        """Let the game wait."""
        self._lay_over(PauseScreen(), "pause")

    def action_guide(self) -> None:
        """Show all keys."""
        self._lay_over(HelpScreen(self._protocol, self._words.rules), "help")

    def action_leave(self) -> None:
        """Ask whether to stop."""
        self._lay_over(StopScreen(), "quit-dialogue", self._stop_if)

    def on_resize(self, event: events.Resize) -> None:
        """Ask for a larger window where the game does not fit."""
        if self.is_active and not fits_into(self.panel.needed, event.size):
            self._lay_over(
                SmallWindowScreen(self.panel.needed), "resize", lambda large: self._stop_if(large is False)
            )

    def _lay_over(
        self, page: PageScreen, reason: Cover, then: Callable[[bool | None], None] | None = None
    ) -> None:
        if self._count_down.running:
            self._count_down.stop()
            self._live.uncover()
        self._questioning.take_down()
        if self._live.phase != "running" or self._live.gate.covered:
            return
        self._live.cover(reason)

        def uncover(answer: bool | None) -> None:
            self._go_on()
            if then is not None:
                then(answer)
            if self._live.phase == "running" and self._playing and not self._questioning.waiting:
                self._count()

        self.app.push_screen(page, uncover)

    def _stop_if(self, stop: bool | None) -> None:
        if stop:
            cast(SessionControls, self.app).ask_to_stop()
