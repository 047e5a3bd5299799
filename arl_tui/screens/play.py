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
from arl_tui.app.link import AskNow, Picture, Practised, Preparing, TakenFor
from arl_tui.app.live_session import LiveSession, Occurrence
from arl_tui.app.once import after
from arl_tui.app.outcome import SessionControls
from arl_tui.app.tally import weight_in_use
from arl_tui.games.panel import Progress
from arl_tui.games.registry import screens_of
from arl_tui.language import key_for, key_name, tr
from arl_tui.palette import Palette
from arl_tui.screens.count_down import CountDown
from arl_tui.screens.covers import (
    BreakScreen,
    HelpScreen,
    PauseScreen,
    SmallWindowScreen,
    StopScreen,
    fits_into,
)
from arl_tui.screens.page import IN_SESSION, PageScreen, bar, session_key, session_keys
from arl_tui.screens.question import Questioning
from arl_tui.widgets.feedback_bar import HOLD_S, FeedbackBar
from arl_tui.widgets.people_bar import PeopleBar
from core.events import (
    CoverReason,
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

ACTIONS = {"pause": "pause", "help": "guide", "stop": "leave"}
"""Name of an action of this screen by what it does (`arl_tui.screens.page.IN_SESSION`)."""

MOVES_S = 0.5
"""How often something moves while unseen episodes are played, seconds."""
MOVING = "◐◓◑◒"


class PlayScreen(Screen[None], inherit_bindings=False):
    """Draws what the session reports; decides nothing about it."""

    BINDING_GROUP_TITLE = "Session"
    BINDINGS: ClassVar[list[BindingType]] = [
        Binding(IN_SESSION["pause"], "pause", "Pause", id="play.pause", tooltip="Let the game wait"),
        Binding(IN_SESSION["help"], "guide", "Help", id="play.help", tooltip="Show all keys"),
        Binding(IN_SESSION["stop"], "leave", "Stop", id="play.stop", tooltip="Stop the session"),
    ]

    def __init__(self, protocol: Protocol, live: LiveSession, palette: Palette, *, part: str = "") -> None:
        """Draw a session that has not begun.

        Args:
            protocol: size of the board, keys, number of games.
            live: the session; asked only to cover and uncover.
            palette: colours of the game.
            part: where in a visit the session is, in words ("Block 2 of 3").
        """
        super().__init__()
        self.panel = screens_of(protocol).panel(protocol, palette)
        self.add_class(f"-{protocol.game}")
        if part:
            self.panel.part(part)
        names = [person.name for person in protocol.people]
        keys = protocol.keys_of_people
        self.feedback = (
            PeopleBar(list(zip(names, keys, strict=True))) if names else FeedbackBar(protocol.keys)
        )
        self.feedback.rest(True)
        self._several = len(keys) > 1
        self._status = Static(id="status")
        self._protocol = protocol
        self._words = screens_of(protocol).words_for(protocol)
        self._episodes = protocol.session.episodes
        self._unseen = protocol.session.unseen_between
        self._unseen_before = protocol.session.unseen_before
        self._live = live
        self._picture: Picture | None = None
        self._watched = 0
        self._playing = False
        """Whether a watched game has begun and not ended."""
        self._human_weights: list[float] = []
        """In use, one per game so far; empty where they are not to be seen."""
        self._shows_weight = protocol.screen.show_weight
        self._stretch, self._block = protocol.screen.games_per_stretch, protocol.screen.games_per_block
        self._counts = protocol.screen.count_down_s > 0
        self._count_down = CountDown(self, self.panel.game_widget(), protocol.screen.count_down_s)
        self._practised: Practised | None = None
        """How far the unseen episodes are; None while none are played."""
        self._result = ""
        """How the last game went, in words."""
        self._moving = not protocol.screen.reduced_motion
        self._moved = 0
        self._questioning = Questioning(self, live, self.panel, self.feedback, protocol)
        self._said = ""
        self._silence_shown = False
        self._disk_failed = False
        self._keys_of_people = keys
        used = {letter for each in keys for letter in each.letters}
        self._letters = {
            key_for(name): action for name, action in ACTIONS.items() if key_for(name) not in used
        }
        self._commands = {key for fixed in IN_SESSION.values() for key in fixed.split(",")}
        self._commands |= {key_for(name) for name in ACTIONS}

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

    def on_mount(self) -> None:
        """Let something move while unseen episodes are played, also before the first game."""
        before = self._unseen if self._watched else self._unseen_before
        if before and not self._playing:  # a game may have begun before the screen is there
            self._practised = Practised(done=0, count=before)
            self._tell_practised()
        self.set_interval(MOVES_S, self._move)

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
                self._practised = None
                self._moved += 1
                self._say(f"{self._going_on(tr('One moment, this first time:'))}\n{bar(fraction)}")
            case Practised():
                self._practised = occurrence
                self._tell_practised()
            case QuestionPosed() | AskNow() | QuestionAnswered():
                self._show_question(occurrence)
            case TimeGap():
                self._lay_over(PauseScreen(gap_s=length_s(occurrence)), "gap")
            case StopAsked() | SessionEnded():
                self._count_down.stop()
                self.feedback.rest(True)
                self._practised = None
                self._questioning.over()
                self._say(tr("Stopping: everything is being saved ..."))

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
        if press.verdict != "other" or (press.read_as or press.key) not in self._commands:
            self.feedback.show_press(press, self._live.left_of(press))
        self.feedback.ask_wrong(self._live.gate.wrong_asked)
        self._tell_presses_left()

    def _tell_presses_left(self) -> None:
        """Write beside the game how many presses are left, as long as there is something to judge.

        Of several participants the feedback bar says it.
        """
        if self._playing and not self._several:
            self.panel.presses_left(self._live.presses_left)

    def _begin_episode(self, episode: EpisodeStarted) -> None:
        self._watched += 1
        self._playing = True
        if self._shows_weight:
            self._human_weights.append(weight_in_use(episode))
        self.feedback.begin_game(self._live.presses_left)
        self._tell_presses_left()
        self.panel.title(tr("Game {number}", number=self._watched))
        self.panel.unmark()
        self._practised = None
        self._say("")
        self.feedback.rest(self._live.gate.covered)
        if self._live.gate.covered:
            return  # a page lies over the game: the count-down comes when it is left
        done = self._watched - 1
        if self._block and done and done % self._block == 0:
            self._lay_over(BreakScreen(done, self._episodes), "pause")
        elif done % self._stretch == 0:
            self._count()

    def _count(self) -> None:
        """Count down; no step is on screen meanwhile, and no press is asked for."""
        if not self._counts:
            return
        self._live.count_down()
        self.feedback.rest(True)
        self._count_down.start(tr("Game {number}", number=self._watched), self._go_on)

    def _go_on(self) -> None:
        """Let the game go on, and draw once more: what was drawn before came too early to count."""
        self._live.uncover()
        self.feedback.rest(not self._playing)
        if self._questioning.waiting:
            self._questioning.show()
        self.panel.refresh()

    def _end_episode(self, episode: EpisodeEnded) -> None:
        self._playing = False
        self.feedback.rest(True)
        self.panel.presses_left(None)
        lines = self._words.told(episode.performance)
        self.panel.title(tr("Game over") if episode.ended == "termination" else tr("End of this game"))
        if self._watched >= self._episodes or self._live.phase != "running":
            self._say(tr("That was the last game: {performance}.", performance=lines))
        elif self._unseen:
            self._result = f"{lines}."
            self._practised, self._moved = Practised(done=0, count=self._unseen), 0
            self._tell_practised()
        else:
            self._say(tr("{performance}. The next game is about to begin.", performance=lines))

    def _tell_practised(self) -> None:
        """Say how many of the unseen games are played: the share is true, and the sign moves meanwhile."""
        far = self._practised
        if far is None or self._silence_shown:
            return
        practising = tr("Practising: {done} of {all} games", done=far.done, all=far.count)
        told = f"{self._going_on(practising)}\n{bar(far.done / far.count)}"
        self._say(f"{self._result}\n{told}".strip())

    def _going_on(self, what: str) -> str:
        """Return what is being done, with a sign that turns, or with the seconds it has taken."""
        if self._moving:
            return f"{MOVING[self._moved % len(MOVING)]} {what}"
        return f"{what} ({int(self._moved * MOVES_S)} s)"

    def _move(self) -> None:
        if self._practised is not None:
            self._moved += 1
            self._tell_practised()

    def _say(self, text: str) -> None:
        if self._disk_failed:
            return
        self._said = text
        self._silence_shown = False
        self._status.update(text)

    def show_disk_failure(self) -> None:
        """Say that nothing counts from here on, because it cannot be recorded."""
        self.feedback.show_not_saved()
        self._say(tr("[b]The recording cannot be written.[/]\nThe session ends here."))
        self._disk_failed = True

    def show_silence(self, silent_s: float | None) -> None:
        """Say for how long the learner has not answered, seconds; None: it does."""
        if silent_s is not None:
            self._silence_shown = True
            told = (
                tr("The computer has not answered for {seconds:.0f} s.", seconds=silent_s)
                if self._playing
                else tr("Still practising for {seconds:.0f} s.", seconds=silent_s)
            )
            key = key_name(session_key("stop", *self._keys_of_people))
            self._status.update(f"{told}\n" + tr("{key} ends the session; all is kept.", key=key))
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
        self._lay_over(HelpScreen(self._protocol, self._words), "help")

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
        self, page: PageScreen, reason: CoverReason, then: Callable[[bool | None], None] | None = None
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
