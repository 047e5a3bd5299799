"""Plays a session in real time: shows each step, and takes in what the participant does.

Simulated time follows the clock. A picture is due at the step's start plus a whole number of ticks, so
nothing drifts. Time stands still while the screen is covered.
"""

from collections.abc import Iterable
from typing import TYPE_CHECKING

from arl_tui.ahead import Ahead, fill
from arl_tui.app.compile_order import session_order
from arl_tui.app.demo_participant import DemoParticipant
from arl_tui.app.link import AskNow, Begin, Line, Picture, Practised, Preparing, TakenFor
from arl_tui.app.taken import StepsShown
from arl_tui.games.registry import screens_of
from arl_tui.games.rendering import Place, PlacesOptions, TickView
from core.events import (
    EpisodeEnded,
    EpisodeStarted,
    FrameShown,
    Input,
    KeyPressed,
    Output,
    QuestionAnswered,
    QuestionPosed,
    Resumed,
    ScreenCleared,
    StepTaken,
    StopAsked,
)
from core.numerics.clock import NS_PER_S, Clock
from core.session.protocol import Protocol

if TYPE_CHECKING:
    from core.session.resume import ResumedSession
    from core.session.session import Session

PROGRESS_S = 0.25
"""How often the screen is told how far compiling is, or practising unseen, seconds."""


class SessionPlayer:
    """Plays a session in front of the participant."""

    def __init__(
        self,
        line: Line,
        protocol: Protocol,
        clock: Clock,
        demo_participant: DemoParticipant | None = None,
        ahead: Ahead | None = None,
    ) -> None:
        """Prepare.

        Args:
            line: to the screen.
            protocol: pace, and size of the game.
            clock: of simulated time.
            demo_participant: a simulated participant who watches, too.
            ahead: compiles what Python stands in for until then.
        """
        self._protocol = protocol
        self._ahead = ahead
        self._line = line
        self._clock = clock
        self._demo_participant = demo_participant
        self._renderer = screens_of(protocol).renderer(protocol)
        self._break_ns = round(protocol.screen.pause_between_episodes_s * NS_PER_S)
        self._steps_shown = StepsShown(*(credit.delay for credit in protocol.credit_of_participants))
        self._marks_presses = protocol.screen.mark_presses
        self._arrived: list[Input] = []
        self._begun = False
        self._covered_since_ns: int | None = None
        self._stopped = False
        self._settle_ns = round(protocol.agent.asking.settle_s * NS_PER_S)
        self._answered = -1
        self._step_on_screen = -1
        self._pictures = 0
        self._due_ns = 0
        self._told_ns = 0
        """When the screen was last told how far the unseen episodes are."""

    def during(self, step: int) -> Iterable[Input]:
        """Return the inputs that have arrived since the last call (`core.session.rollout.FeedbackSource`)."""
        self._take_in(0.0)
        arrived, self._arrived = self._arrived, []
        return arrived

    def run(self, session: "Session | ResumedSession") -> None:
        """Wait for the start, then play to the end; each output is sent before it is shown."""
        while not self._begun:
            self._take_in(None)
        self._due_ns = self._clock.now_ns()
        session.before_unseen = self._wait_for_kernels
        session.after_unseen = self._tell_practised
        for output in session.run(self, self._clock):
            self._line.send(output)
            self._show(output)

    def _show(self, output: Output) -> None:
        match output:
            case EpisodeStarted():
                if self._demo_participant is not None:
                    self._demo_participant.begin(output)
                self._due_ns = self._clock.now_ns()
                self._play(-1, self._renderer.begin(output))
            case StepTaken():
                ticks = self._renderer.act(output)
                self._suggest(output, len(ticks))
                self._play(output.step, ticks)
                if ticks:
                    self._wait_until_seen(output.step)
            case QuestionPosed() if not self._stopped:
                self._ask(output)
            case EpisodeEnded() if not self._stopped:
                self._send_picture(-1, TickView(self._renderer.picture))
                self._due_ns = self._clock.now_ns() + self._break_ns
                if self._ahead is not None and self._ahead.finished:
                    self._load_kernels()
                self._wait_until_due()

    def _ask(self, posed: QuestionPosed) -> None:
        """Let the game stand still, so that what was last seen can be judged; then ask, and wait."""
        self._send_picture(-1, TickView(self._renderer.picture))
        self._due_ns = self._clock.now_ns() + self._settle_ns
        self._wait_until_due()
        if self._stopped:
            return
        places: tuple[Place, ...] = ()
        if isinstance(self._renderer, PlacesOptions):
            places = tuple(self._renderer.place_of_option(detail) for detail in posed.details)
        self._line.send(AskNow(question=posed.question, places=places))
        if self._demo_participant is not None:
            self._line.send(self._demo_participant.answer(posed, shown_ns=self._clock.now_ns()))
        while not self._stopped and (self._answered < posed.question or self._covered_since_ns is not None):
            self._take_in(None)
        self._due_ns = self._clock.now_ns()

    def _wait_for_kernels(self) -> None:
        """Wait until everything is compiled, and say how far it is: unseen episodes would take Python
        minutes.
        """
        from core.numerics.interpreting import progress

        while self._ahead is not None:
            far = progress()
            self._line.send(Preparing(compiled=far.compiled, needed=far.needed, fraction=far.fraction))
            if self._ahead.finished:
                self._load_kernels()
            else:
                self._take_in(PROGRESS_S)

    def _tell_practised(self, done: int, count: int) -> None:
        """Say how many unseen episodes are done: at most once in `PROGRESS_S`, and when all are."""
        now_ns = self._clock.now_ns()
        if done == count or now_ns - self._told_ns >= PROGRESS_S * NS_PER_S:
            self._told_ns = now_ns
            self._line.send(Practised(done=done, count=count))

    def _load_kernels(self) -> None:
        """Change over from Python to compiled code: it gives the same bits."""
        from core.numerics.interpreting import load_interpreted, stop_interpreting

        load_interpreted()
        stop_interpreting()
        fill(session_order(self._protocol))
        self._ahead = None

    def _suggest(self, step: StepTaken, n_ticks: int) -> None:
        if self._demo_participant is not None:
            now_ns = self._clock.now_ns()
            judged_ns = now_ns + self._renderer.judged_after_ns(n_ticks)
            presses = self._demo_participant.watch(step, shown_ns=now_ns, hidden_ns=judged_ns)
            for press in presses:
                self._line.send(press)

    def _play(self, step: int, ticks: Iterable[TickView]) -> None:
        for tick in ticks:
            if self._stopped:
                return
            self._send_picture(step, tick)
            # Where learning took longer than a tick, time went by unseen: begin anew instead of hurrying.
            self._due_ns = max(self._due_ns + self._renderer.tick_ns, self._clock.now_ns())
            self._wait_until_due()

    def _send_picture(self, step: int, tick: TickView) -> None:
        self._line.send(
            Picture(
                number=self._pictures,
                step=step,
                view=tick.view,
                ahead=tick.ahead,
                lasts_ns=self._renderer.tick_ns if tick.ahead is not None else 0,
            )
        )
        self._pictures += 1

    def _wait_until_due(self) -> None:
        while not self._stopped:
            if self._covered_since_ns is not None:
                self._take_in(None)
                continue
            left_ns = self._due_ns - self._clock.now_ns()
            if left_ns <= 0:
                return
            self._take_in(left_ns / NS_PER_S)

    def _wait_until_seen(self, step: int) -> None:
        """Wait for a terminal that is behind: no step is over before the participant has seen it."""
        while self._step_on_screen < step and not self._stopped:
            self._take_in(None)

    def _take_in(self, timeout_s: float | None) -> None:
        """Act on the messages that are there; wait for one up to `timeout_s` seconds (None: for ever)."""
        for message in self._line.receive(timeout_s):
            if isinstance(message, Begin):
                self._begun = True
            else:
                self._note(message)
                self._arrived.append(message)

    def _note(self, message: Input) -> None:
        self._steps_shown.note(message)
        match message:
            case KeyPressed(verdict="accepted") if self._marks_presses:
                self._tell_taken_for(message)
            case FrameShown(step=step):
                self._step_on_screen = max(step, self._step_on_screen)
            case ScreenCleared(time_ns=time_ns):
                self._covered_since_ns = time_ns
            case Resumed(time_ns=time_ns) if self._covered_since_ns is not None:
                self._due_ns += time_ns - self._covered_since_ns
                self._covered_since_ns = None
            case QuestionAnswered(question=question):
                self._answered = question
            case StopAsked():
                self._stopped = True

    def _tell_taken_for(self, press: KeyPressed) -> None:
        """Tell the screen what a press was taken for."""
        assert press.value is not None, "an accepted press means something"
        step = self._steps_shown.taken_for(press)
        self._line.send(
            TakenFor(
                press=press.press,
                person=press.person,
                value=press.value,
                step=step,
                place=self._renderer.place_of(step),
            )
        )
