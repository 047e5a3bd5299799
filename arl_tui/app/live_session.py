"""A live session as the screen's process knows it: what was shown when, which presses count, what is
recorded.

No widgets here and no rules of a game: `LiveSession` stands between the link (worker), the recorder (disk)
and a listener (the screens).
"""

from collections.abc import Callable, Sequence
from itertools import count
from typing import Literal

from arl_tui.app.asking import OpenQuestion
from arl_tui.app.link import (
    Alive,
    AskNow,
    Begin,
    Crashed,
    FromWorker,
    Link,
    Picture,
    Practised,
    Preparing,
    PressSuggested,
    Ready,
    TakenFor,
    TriedOut,
)
from arl_tui.app.tally import Tally
from arl_tui.app.unconfirmed import EventSink, UnconfirmedPresses
from core.events import (
    CoverReason,
    EpisodeStarted,
    Event,
    FocusLost,
    FocusRegained,
    FrameShown,
    Input,
    KeyPressed,
    Output,
    PressRetracted,
    QuestionAnswered,
    QuestionPosed,
    Resumed,
    ScreenCleared,
    SessionEnded,
    StepTaken,
    StopAsked,
    StopReason,
    TimeGap,
    WrongPressAsked,
)
from core.feedback.asking_config import AskingConfig
from core.feedback.frames import FrameLedger
from core.feedback.keys import KeyConfig, PressGate, WrongPressPlan
from core.feedback.people import new_gate
from core.numerics.clock import NS_PER_S, Clock
from core.recording.joined import latest_ns

Occurrence = Event | Picture | PressSuggested | Practised | Preparing | Ready | TakenFor | AskNow


class LiveSession:
    """One session from the start key to the end line.

    Phases: `waiting` (for the start) -> `running` -> `stopping` (the worker finishes) -> `over`.
    """

    def __init__(
        self,
        *,
        keys: KeyConfig | Sequence[KeyConfig],
        root_seed: int,
        link: Link,
        clock: Clock,
        listener: Callable[[Occurrence], None],
        on_over: Callable[[str | None], None],
        earlier: Sequence[Event] = (),
        asking: AskingConfig | None = None,
    ) -> None:
        """Prepare; nothing is recorded before `begin`.

        Args:
            keys: which keys mean what; of several participants those of each.
            root_seed: the session's seed (stream "wrong-press" says which presses are asked to be wrong).
            link: the worker.
            clock: the clock of key and flush times.
            listener: told of everything that happens, in order.
            on_over: called once when nothing more will happen; with the reason if the worker failed.
            earlier: what the session had done before it broke off, up to its last finished game.
            asking: keys and limit of answers to questions; None: the defaults.
        """
        presses = [event.press for event in earlier if isinstance(event, KeyPressed)]
        of_each = (keys,) if isinstance(keys, KeyConfig) else tuple(keys)
        self.gate = new_gate(of_each, numbers=count(max(presses, default=-1) + 1))
        self.tally = Tally()
        self._asking = asking or AskingConfig()
        self.question: OpenQuestion | None = None
        """The question that covers the game; None where none does."""
        self.stop_reason: StopReason | None = None
        """Why the session was asked to end; None while it was not."""
        self.phase: Literal["waiting", "running", "stopping", "over"] = "waiting"
        self.ready = False
        self.take_stamps: Callable[[], list[tuple[int, int]]] = list
        """Returns flush stamps (frame, time) not seen yet; set by the app that owns the driver."""
        self.find_gap: Callable[[], TimeGap | None] = lambda: None
        """Returns a gap in time that has just ended (`arl_tui.app.gaps`); set by the app, asked before all
        that comes in."""
        self._has_focus = True
        frames = [event.frame for event in earlier if isinstance(event, FrameShown)]
        self._frames = FrameLedger(first=max(frames, default=-1) + 1)
        self._link = link
        self._clock = clock
        self._listener = listener
        self._on_over = on_over
        self._sink: EventSink | None = None
        self._accepted: dict[int, KeyPressed] = {}
        self._wrong_presses = WrongPressPlan(of_each[0].wrong_press_rate, root_seed)
        self._worker_error: str | None = None
        self._presses = UnconfirmedPresses(self.gate, len(of_each), clock, listener)
        self._heard_ns = clock.now_ns()
        self._ended_before_ns = latest_ns(earlier) if earlier else None
        """When the session broke off; None where it has just begun."""
        self._take_up(earlier)

    # --- from the screens -----------------------------------------------------------------------------------

    @property
    def presses_left(self) -> int:
        """Presses that are left of the first person's budget, as far as presses have been confirmed."""
        return self._presses.left_of_first

    def left_of(self, event: KeyPressed | PressRetracted) -> int:
        """Return how many presses of their budget the one has left whose press this is; 0 for nobody."""
        return self._presses.left_of(event)

    def begin(self, sink: EventSink) -> None:
        """Start: events are recorded from here on."""
        if self.phase == "waiting":
            self._sink = sink
            self.phase = "running"
            self._heard_ns = self._clock.now_ns()
            self._link.send(Begin())
            self._mark_joint()
            if not self._has_focus:
                self._enter(FocusLost(time_ns=self._clock.now_ns()))

    def _take_up(self, earlier: Sequence[Event]) -> None:
        """Count what had been done before the session broke off, and draw the same wrong presses again."""
        for event in earlier:
            match event:
                case KeyPressed() | PressRetracted():
                    self._count(event)
                    if isinstance(event, KeyPressed) and event.verdict == "accepted":
                        self._wrong_press_made()
                case WrongPressAsked() if isinstance(self.gate, PressGate):
                    self._wrong_presses.asked(self.gate)
                case _:
                    if isinstance(event, Output):
                        self.tally.note(event)

    def _wrong_press_made(self) -> None:
        if isinstance(self.gate, PressGate):
            self.gate.wrong_asked = False

    def _mark_joint(self) -> None:
        """Record where a session goes on: no press is credited to what was on screen before it broke off."""
        if self._ended_before_ns is not None:
            assert self._sink is not None, "the session has begun"
            joint = TimeGap(last_ns=self._ended_before_ns, time_ns=self._clock.now_ns(), joint=True)
            self._sink.record(joint)
            self._link.send(joint)  # not to the screens: the participant has not been interrupted now

    def key_pressed(
        self, key: str, time_ns: int, *, source: Literal["participant", "simulated"] = "participant"
    ) -> None:
        """Take in a key press made at `time_ns`."""
        if self.phase != "running":
            return
        self.notice_gap()
        self.collect_frames()
        self.gate.frame, self.gate.step = self._frames.at(time_ns)
        for record in self.gate.judge(key, time_ns, source=source):
            self._count(record)
            self._enter(record)
            if isinstance(record, KeyPressed) and self.question is not None:
                self._answer(self.question.answered_by(record))

    def pose(self, posed: QuestionPosed) -> None:
        """Note that a question covers the game, or is there again after a page."""
        self.cover("question")
        self.question = OpenQuestion(posed, self._asking)

    def question_painted(self) -> int:
        """Note that the options have been drawn; returns the frame's number."""
        frame = self._frames.painted(-1)
        if self.question is not None:
            self.question.painted(frame)
        return frame

    def look_at_question(self) -> float | None:
        """Take a question back whose time is up; return the seconds that are left; None where none is
        open.
        """
        if self.question is None or self.phase != "running":
            return None
        now_ns = self._clock.now_ns()
        self._answer(self.question.timed_out(now_ns))
        return None if self.question is None else self.question.left_s(now_ns)

    def take_question_down(self) -> None:
        """Note that a question has left the screen without an answer: a page comes in its place."""
        if self.question is not None:
            self.question = None
            self.uncover()

    def _answer(self, answered: QuestionAnswered | None) -> None:
        if answered is not None:
            self.question = None
            self._enter(answered)
            self.uncover()

    def painted(self, step: int) -> int:
        """Note that new content for `step` has been drawn; returns the frame's number."""
        return self._frames.painted(step)

    def collect_frames(self) -> None:
        """Take in the flush stamps that have arrived."""
        self.notice_gap()
        for frame, time_ns in self.take_stamps():
            if self.phase != "running" or self.gate.covered:
                self._frames.dropped(frame)
                if self.question is not None:
                    self.question.flushed(frame, time_ns)
            else:
                self._enter(self._frames.flushed(frame, time_ns))

    def notice_gap(self) -> None:
        """Note that the program has stood still, if it has: what it shows then covers the game by itself."""
        gap = self.find_gap()
        if gap is None or self.phase != "running":
            return
        last_ns, middle_ns = gap.last_ns, (gap.last_ns + gap.time_ns) // 2
        for frame, time_ns in self.take_stamps():
            # A frame that left just before the gap is in the file before it; one from after it comes under
            # the cover.
            if self.gate.covered or (time_ns > middle_ns and not gap.suspended_ns):
                self._frames.dropped(frame)
            else:
                self._enter(self._frames.flushed(frame, time_ns))
                last_ns = max(last_ns, time_ns)
        self._frames.cleared(last_ns)
        self._enter(
            TimeGap(last_ns=last_ns, time_ns=max(last_ns, gap.time_ns), suspended_ns=gap.suspended_ns)
        )

    def focus(self, has_focus: bool) -> None:
        """Note that the terminal's window has lost the keyboard, or has it again."""
        if has_focus == self._has_focus:
            return
        self._has_focus = has_focus
        if self.phase == "running":
            now_ns = self._clock.now_ns()
            self._enter(FocusRegained(time_ns=now_ns) if has_focus else FocusLost(time_ns=now_ns))

    def cover(self, reason: CoverReason) -> None:
        """Note that something else is on screen: simulated time stops."""
        if self.phase == "running" and not self.gate.covered:
            self.collect_frames()
            now_ns = self._clock.now_ns()
            self.gate.covered = True
            self._frames.cleared(now_ns)
            self._enter(ScreenCleared(time_ns=now_ns, reason=reason))

    def uncover(self) -> None:
        """Note that the step is on screen again."""
        if self.phase == "running" and self.gate.covered:
            # What was drawn before the cover and stamped under it does not count.
            self.collect_frames()
            self.gate.covered = False
            self._enter(Resumed(time_ns=self._clock.now_ns()))

    def count_down(self) -> None:
        """Note that a count-down is on screen in the step's place; after a page, that page is over."""
        self.uncover()
        self.cover("count-down")

    def confirm(self) -> None:
        """Pass on to the screens the presses that are in the file by now; none once the disk has failed."""
        if self._sink is not None:
            self._presses.confirm(self._sink)

    def unconfirmed_s(self) -> float:
        """Return for how long the oldest press has waited to be in the file, seconds; 0.0 where none
        waits.
        """
        return self._presses.waiting_s()

    def silent_s(self) -> float:
        """Return for how long the worker has sent nothing, seconds."""
        return (self._clock.now_ns() - self._heard_ns) / NS_PER_S

    def stop(self, reason: StopReason = "participant") -> None:
        """End the session: the worker truncates the episode and says its last word."""
        if self.phase == "running":
            self.collect_frames()
            self.phase = "stopping"
            self.stop_reason = reason
            self._enter(StopAsked(time_ns=self._clock.now_ns(), reason=reason))

    def give_up(self, reason: str) -> None:
        """End without the worker's last word."""
        if self.phase == "running":
            self.stop("worker-died")
        if self.phase != "over":
            self.phase = "over"
            self._on_over(reason)

    # --- from the worker ------------------------------------------------------------------------------------

    def take_in(self, message: FromWorker) -> None:
        """Act on a message of the worker."""
        self._heard_ns = self._clock.now_ns()
        if isinstance(message, Alive | TriedOut):
            return
        if isinstance(message, Crashed):
            self._worker_error = f"{message.error}\n\n{message.trace}".strip()
        elif isinstance(message, TakenFor):
            self._presses.note_taken(message)
        elif isinstance(message, Picture | PressSuggested | Practised | Preparing | AskNow):
            self._listener(message)
        elif isinstance(message, Ready):
            self.ready = True
            self._listener(message)
        else:
            self._take_output(message)

    def worker_lost(self, reason: str) -> None:
        """Act on the end of the worker's process."""
        self.give_up(self._worker_error or reason)

    def _take_output(self, output: Output) -> None:
        if self._sink is None or self.phase == "over":
            return
        self.notice_gap()
        # What was flushed before this message arrived comes before it in the file.
        self.collect_frames()
        self._sink.record(output)
        self.tally.note(output)
        if isinstance(output, EpisodeStarted):
            self.gate.episode_started()
            self._presses.episode_started()
        elif isinstance(output, StepTaken):
            self._ask_wrong_press(output.step)
        self._listener(output)
        if isinstance(output, SessionEnded):
            self.phase = "over"
            self._on_over(None)

    def _ask_wrong_press(self, step: int) -> None:
        if isinstance(self.gate, PressGate) and self._wrong_presses.due(self.gate):
            self._enter(WrongPressAsked(time_ns=self._clock.now_ns(), step=step))

    # --- both -----------------------------------------------------------------------------------------------

    def _count(self, record: KeyPressed | PressRetracted) -> None:
        if isinstance(record, PressRetracted):
            self.tally.count(self._accepted.pop(record.press), -1)
            self.tally.taken_back += 1
        elif record.verdict == "accepted" and record.value is not None:
            self._accepted[record.press] = record
            self._presses.accepted(record)
            self._wrong_presses.accepted()
            self.tally.count(record, 1)

    def _enter(self, event: Input) -> None:
        """Record an input, send it to the worker, tell the screens: of a press only when it is in the
        file.
        """
        assert self._sink is not None, "inputs are taken in only between begin and the end"
        self._sink.record(event)
        self._link.send(event)
        if isinstance(event, KeyPressed | PressRetracted):
            self._presses.wait_for(event, self._sink)
            self.confirm()
        else:
            self._listener(event)
