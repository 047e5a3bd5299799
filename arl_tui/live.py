"""A live session as the screen's process knows it: what was shown when, which presses count, what is recorded.

No widgets here and no rules of a game: `LiveSession` stands between the link (worker), the recorder (disk) and a
listener (the screens).
"""

from collections import deque
from collections.abc import Callable, Iterator
from dataclasses import dataclass, field
from typing import Literal, Protocol

from arl_tui.link import Begin, Crashed, FromWorker, Link, Picture, Preparing, PressSuggested, Ready
from core.clock import Clock
from core.episode import (
    EpisodeEnded,
    EpisodeStarted,
    Event,
    FrameShown,
    Input,
    KeyPressed,
    Output,
    PressRetracted,
    Resumed,
    ScreenCleared,
    SessionEnded,
    StepTaken,
    StopAsked,
    UnseenPlayed,
    WrongPressAsked,
)
from core.keys import KeyConfig, PressGate

FRAMES_REMEMBERED = 256
"""About ten seconds: far more than a key's handler is ever late."""

Cover = Literal["pause", "help", "quit-dialogue", "resize"]
Occurrence = Event | Picture | PressSuggested | Preparing | Ready


class EventSink(Protocol):
    """Where events are recorded (`core.recording.recorder.Recorder`)."""

    def record(self, event: Event) -> None:
        """Take one event; never wait."""
        ...


class FrameLedger:
    """Which frame, and which step, was on screen at a time that has just passed."""

    def __init__(self) -> None:
        self._steps: dict[int, int] = {}
        self._next_frame = 0
        self._shown: deque[tuple[int, int, int]] = deque([(0, -1, -1)], maxlen=FRAMES_REMEMBERED)

    def painted(self, step: int) -> int:
        """Give the number of a frame that has been drawn, though it has not reached the terminal yet."""
        frame = self._next_frame
        self._next_frame += 1
        self._steps[frame] = step
        return frame

    def flushed(self, frame: int, time_ns: int) -> FrameShown:
        """Note when a frame's last byte left."""
        step = self._steps.pop(frame)
        self._shown.append((time_ns, frame, step))
        return FrameShown(frame=frame, step=step, flushed_ns=time_ns)

    def dropped(self, frame: int) -> None:
        """Note that a frame does not count: something else covered it."""
        self._steps.pop(frame, None)

    def cleared(self, time_ns: int) -> None:
        """Note that no frame is on screen from this time on."""
        self._shown.append((time_ns, -1, -1))

    def at(self, time_ns: int) -> tuple[int, int]:
        """Return (frame, step) on screen at `time_ns`; -1 where there was none."""
        for shown_ns, frame, step in reversed(self._shown):
            if shown_ns <= time_ns:
                return frame, step
        return -1, -1


@dataclass
class Tally:
    """What the summary at the end tells the participant."""

    performances: list[float] = field(default_factory=list)
    """Of the watched episodes."""
    unseen: int = 0
    """Episodes played out of sight."""
    practised: list[float] = field(default_factory=list)
    """Mean performance of each block of them."""
    good: int = 0
    bad: int = 0
    taken_back: int = 0
    w_h: float = 0.0
    steps: int = 0


def uniform_draws(root_seed: int) -> Iterator[float]:
    """Yield the numbers in [0, 1) of the stream that says which presses are asked to be wrong."""
    from core.streams import stream  # not at the top: the first picture need not wait for numpy

    rng = stream(root_seed, "wrong-press")
    while True:
        yield float(rng.random())


class LiveSession:
    """One session from the start key to the end line.

    Phases: `waiting` (for the start) -> `running` -> `stopping` (the worker finishes) -> `over`.
    """

    def __init__(
        self,
        *,
        keys: KeyConfig,
        root_seed: int,
        link: Link,
        clock: Clock,
        listener: Callable[[Occurrence], None],
        on_over: Callable[[str | None], None],
    ) -> None:
        """Prepare; nothing is recorded before `begin`.

        Args:
            keys: which keys mean what.
            root_seed: the session's seed (stream "wrong-press" says which presses are asked to be wrong).
            link: the worker.
            clock: the clock of key and flush times.
            listener: told of everything that happens, in order.
            on_over: called once when nothing more will happen; with the reason if the worker failed.
        """
        self.gate = PressGate(keys)
        self.tally = Tally()
        self.phase: Literal["waiting", "running", "stopping", "over"] = "waiting"
        self.ready = False
        self.take_stamps: Callable[[], list[tuple[int, int]]] = list
        """Returns flush stamps (frame, time) not seen yet; set by the app that owns the driver."""
        self._frames = FrameLedger()
        self._link = link
        self._clock = clock
        self._listener = listener
        self._on_over = on_over
        self._sink: EventSink | None = None
        self._accepted: dict[int, float] = {}
        self._root_seed = root_seed
        self._draws: Iterator[float] | None = None
        self._wrong_next = self._draw_wrong()
        self._worker_error: str | None = None

    # --- from the screens ---------------------------------------------------------------------------------------

    def begin(self, sink: EventSink) -> None:
        """Start: events are recorded from here on."""
        if self.phase == "waiting":
            self._sink = sink
            self.phase = "running"
            self._link.send(Begin())

    def press(
        self, key: str, time_ns: int, *, source: Literal["participant", "simulated"] = "participant"
    ) -> None:
        """Take in a key press made at `time_ns`."""
        if self.phase != "running":
            return
        self.collect_frames()
        self.gate.frame, self.gate.step = self._frames.at(time_ns)
        for record in self.gate.press(key, time_ns, source=source):
            self._count(record)
            self._enter(record)

    def painted(self, step: int) -> int:
        """Note that new content for `step` has been drawn; returns the frame's number."""
        return self._frames.painted(step)

    def collect_frames(self) -> None:
        """Take in the flush stamps that have arrived."""
        for frame, time_ns in self.take_stamps():
            if self.phase != "running" or self.gate.covered:
                self._frames.dropped(frame)
            else:
                self._enter(self._frames.flushed(frame, time_ns))

    def cover(self, reason: Cover) -> None:
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

    def stop(self, reason: Literal["participant", "worker-died", "time-limit"] = "participant") -> None:
        """End the session: the worker truncates the episode and says its last word."""
        if self.phase == "running":
            self.collect_frames()
            self.phase = "stopping"
            self._enter(StopAsked(time_ns=self._clock.now_ns(), reason=reason))

    def give_up(self, reason: str) -> None:
        """End without the worker's last word."""
        if self.phase == "running":
            self.stop("worker-died")
        if self.phase != "over":
            self.phase = "over"
            self._on_over(reason)

    # --- from the worker ----------------------------------------------------------------------------------------

    def take_in(self, message: FromWorker) -> None:
        """Act on a message of the worker."""
        if isinstance(message, Crashed):
            self._worker_error = f"{message.error}\n\n{message.trace}"
        elif isinstance(message, Picture | PressSuggested | Preparing):
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
        # What was flushed before this message arrived comes before it in the file.
        self.collect_frames()
        self._sink.record(output)
        match output:
            case EpisodeStarted():
                self.gate.episode_started()
            case StepTaken():
                self.tally.steps += 1
                self._ask_wrong_press(output.step)
            case EpisodeEnded():
                self.tally.performances.append(output.performance)
                self.tally.w_h = output.w_h
            case UnseenPlayed():
                self.tally.unseen += len(output.policies)
                self.tally.practised.append(sum(output.performances) / len(output.performances))
                self.tally.w_h = output.w_h
        self._listener(output)
        if isinstance(output, SessionEnded):
            self.phase = "over"
            self._on_over(None)

    def _ask_wrong_press(self, step: int) -> None:
        if self._wrong_next and not self.gate.wrong_asked and self.gate.presses_left > 0:
            self._wrong_next = False
            self.gate.wrong_asked = True
            self._enter(WrongPressAsked(time_ns=self._clock.now_ns(), step=step))

    # --- both ---------------------------------------------------------------------------------------------------

    def _count(self, record: KeyPressed | PressRetracted) -> None:
        if isinstance(record, PressRetracted):
            value = self._accepted.pop(record.press)
            self.tally.taken_back += 1
            change = -1
        elif record.verdict == "accepted" and record.value is not None:
            value = self._accepted[record.press] = record.value
            self._wrong_next = self._draw_wrong()
            change = 1
        else:
            return
        if value > 0:
            self.tally.good += change
        else:
            self.tally.bad += change

    def _draw_wrong(self) -> bool:
        rate = self.gate.config.wrong_press_rate
        if rate == 0.0:
            return False
        if self._draws is None:
            self._draws = uniform_draws(self._root_seed)
        return next(self._draws) < rate

    def _enter(self, event: Input) -> None:
        """Record an input, send it to the worker, tell the screens."""
        assert self._sink is not None, "inputs are taken in only between begin and the end"
        self._sink.record(event)
        self._link.send(event)
        self._listener(event)
