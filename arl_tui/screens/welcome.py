"""The first screen: what will happen, in plain words, and which keys there are."""

from collections.abc import Callable, Iterable
from typing import ClassVar, cast

from rich.text import Text
from textual.binding import Binding, BindingType
from textual.widget import Widget
from textual.widgets import Static

from arl_tui.app.link import Preparing, Ready
from arl_tui.app.outcome import SessionControls
from arl_tui.games.pace import pace_line, pace_warning
from arl_tui.games.registry import screens_of
from arl_tui.language import later, tr, trn
from arl_tui.screens.overview import KEY as OVERVIEW_KEY
from arl_tui.screens.overview import OverviewPage
from arl_tui.screens.page import PageScreen, keys_of_all, presses_of_all
from arl_tui.screens.question import about_questions
from core.numerics.clock import NS_PER_S, Clock, MonotonicClock
from core.session.protocol import Protocol

AT_SCREEN_S = 10.0
"""A participant who pressed the start key at most this long ago is taken to look at the screen still."""
CALL = later("Press {key_enter} to start, {key_stop} to leave")


class WelcomeScreen(PageScreen):
    """Explains, and waits for the start key while the worker gets ready.

    A game begins only in front of a participant: where getting ready took longer than `AT_SCREEN_S` after the
    start key was pressed, the key has to be pressed again.
    """

    BINDINGS: ClassVar[list[BindingType]] = [
        Binding("enter", "start", "Start", id="welcome.start", tooltip="Start the session"),
        Binding("q,ctrl+q,ctrl+c", "leave", "Leave", id="welcome.leave", tooltip="Leave without starting"),
        # Without an id: the participant's help does not name it.
        Binding(OVERVIEW_KEY, "overview", "", show=False, system=True),
    ]

    def __init__(
        self,
        protocol: Protocol,
        participant: str,
        *,
        simulated: bool,
        games_done: int = 0,
        practice: bool = False,
        part: str = "",
        overview: Callable[[Ready | None], dict[str, str]] | None = None,
        clock: Clock | None = None,
    ) -> None:
        """Prepare.

        Args:
            protocol: of the session.
            participant: pseudonym.
            simulated: a simulated participant presses keys, too.
            games_done: watched games that were finished before the session broke off.
            practice: nothing counts.
            part: where in a visit the session is, in words ("Block 2 of 3").
            overview: what the session will do, topic by topic, for the experimenter; None where the
                experimenter is not to see it either.
            clock: tells how long ago the start key was pressed.
        """
        super().__init__()
        self._games_done = games_done
        self._practice = practice
        self._protocol = protocol
        self._words = screens_of(protocol).words_for(protocol)
        self.HEADING = f"{tr(self._words.heading)}  -  {part}" if part else self._words.heading
        self._in_study = bool(part)
        self._participant = participant
        self._simulated = simulated
        self._overview = overview
        self._clock = clock or MonotonicClock()
        self._asked_ns: int | None = None
        """When the start key was pressed; None before."""
        self._progress: Preparing | None = None
        self._worker_ready: Ready | None = None

    def body(self) -> Iterable[Widget]:
        """Return the explanation."""
        session = self._protocol.session
        games = trn("one game", "{n} games", session.episodes)
        words = self._words
        if self._practice:
            yield Static(
                tr("[b]Practice[/]: nothing counts, the game is slow, and marks what you judged.") + "\n"
            )
        if self._games_done:
            yield Static(
                tr("[b]Your session goes on after {done} of {games}.[/]", done=self._games_done, games=games)
                + "\n"
            )
        practises = tr(words.practises) if session.unseen_between else ""
        yield Static(tr(words.welcome, games=games, practises=practises, task=words.task))
        asking = self._protocol.agent.asking
        answers = f"\n{about_questions(asking)}" if asking.per_episode else ""
        yield Static(f"\n{keys_of_all(self._protocol)}{answers}\n")
        # The page is full in the smallest window: a line for answers takes the room of the last sentence.
        last = "" if answers else " " + tr("Nothing you press is wrong: only your opinion counts.")
        yield Static(
            tr(
                "You have [b]{presses}[/], so save them for what matters, and press as soon as you have "
                "made up your mind.",
                presses=presses_of_all(self._protocol),
            )
            + last
        )
        yield from self._remarks()
        yield Static(id="pace")
        yield Static(id="call", classes="call")

    def _remarks(self) -> Iterable[Widget]:
        """Return what holds for some sessions only, and where presses are written."""
        if self._protocol.keys.wrong_press_rate > 0:
            yield Static(
                "\n"
                + tr(
                    "Now and then the screen asks you to press the [b]wrong[/] key on purpose. Please do it "
                    "then: we want to know how the computer copes with mistakes."
                )
            )
        if self._simulated:
            yield Static(
                "\n"
                + tr(
                    "This is a demonstration: a [b]simulated person[/] presses keys as well. You may press, "
                    "too, or just watch."
                )
            )
        yield Static(
            "\n"
            + tr(
                "[dim]Your key presses and their times are written to a file on this computer under the "
                "code[/] [b]{code}[/][dim]. You can pause or stop at any time.[/]",
                code=self._participant,
            )
        )

    def on_mount(self) -> None:
        """Say whether the start key works already."""
        self._tell()

    def show_progress(self, progress: Preparing) -> None:
        """Say how far the preparation is."""
        self._progress = progress
        self._tell()

    def show_ready(self, ready: Ready) -> None:
        """Say that the start key works; start at once where it has just been pressed."""
        self._worker_ready = ready
        waited = self._asked_ns is not None
        if (
            waited
            and self.is_current
            and self._clock.now_ns() - (self._asked_ns or 0) <= AT_SCREEN_S * NS_PER_S
        ):
            cast(SessionControls, self.app).begin()
            return
        if waited:
            self.app.bell()
        self._tell()

    def _tell(self) -> None:
        """Write the last lines."""
        if not self.query("#call"):
            return  # Not laid out yet: `on_mount` comes back here.
        warning = self._warning()
        self.query_one("#pace").display = bool(warning)  # an empty line would take the room of the last one
        if warning:
            self.query_one("#pace", Static).update(Text(f"For the experimenter: {warning}", style="dim"))
            self.query_one("#call").add_class("-close")  # the page is full in the smallest window
        self.query_one("#call", Static).update(self._call())

    def _warning(self) -> str:
        """Return what the experimenter is told of the pace."""
        return pace_warning(self._protocol, self._worker_ready) if self._tells_pace else ""

    @property
    def _tells_pace(self) -> bool:
        """Whether the experimenter reads of the pace here.

        Not in a demonstration; nor in a visit of a study, where participants are alone with the page: `arl
        study check` says it before, and `arl study run` at the end.
        """
        return not self._simulated and not self._in_study

    def _call(self) -> str:
        """Return two lines: what can be pressed, and how far the preparation is."""
        if self._worker_ready is not None:
            line = tr(CALL) if self._asked_ns is None else f"{tr('Ready.')} {tr(CALL)}"
            # The warning takes the room of the second line: nothing moves without one.
            if self._warning():
                return line
            pace = pace_line(self._protocol, self._worker_ready) if self._tells_pace else ""
            return f"{line}\n[dim]{pace and f'For the experimenter: {pace}'}[/]"
        far = tr("getting ready")
        if self._progress is not None and self._progress.compiled:
            far = tr(
                "getting ready: {done} of about {needed} parts",
                done=self._progress.compiled,
                needed=self._progress.needed,
            )
        if self._asked_ns is None:
            return f"{tr(CALL)}\n[dim]{far}[/]"
        return f"{tr('Please wait: the first time this may take half a minute')}\n[dim]{far}[/]"

    def action_start(self) -> None:
        """Start, or as soon as the worker is ready."""
        if self._worker_ready is not None:
            cast(SessionControls, self.app).begin()
            return
        self._asked_ns = self._clock.now_ns()
        self._tell()

    def action_overview(self) -> None:
        """Show the experimenter what the session will do."""
        if self._overview is not None:
            self.app.push_screen(OverviewPage(self._overview(self._worker_ready)))

    def action_leave(self) -> None:
        """Leave: nothing has been recorded."""
        cast(SessionControls, self.app).leave()
