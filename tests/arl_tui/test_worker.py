"""How the worker shows a session: with its line to the screen and its clock faked, and over a real pipe."""

import itertools
import multiprocessing
from collections.abc import Iterable, Iterator

import pytest

from arl_tui.app.link import Begin, FromWorker, Picture, TakenFor, ToWorker, WorkerLine
from arl_tui.session_player import SessionPlayer
from core.events import FrameShown, Input, KeyPressed, Output, Resumed, ScreenCleared, StepTaken, StopAsked
from core.numerics.clock import NS_PER_S, Clock, ManualClock
from core.session.protocol import Protocol, ScreenConfig
from core.session.rollout import FeedbackSource
from tests.arl_tui.fakes import episode_ended, episode_started, session_ended, step_taken

MS = 1_000_000
TICK_MS = 50


class ScriptedLine:
    """A line whose other end acts at given times, and shows each picture at once unless told not to."""

    def __init__(self, clock: ManualClock) -> None:
        self.clock = clock
        self.script: list[tuple[int, ToWorker]] = [(0, Begin())]
        self.sent: list[tuple[int, FromWorker]] = []
        self.shows = True
        self._frames = 0

    def at(self, time_ms: int, message: ToWorker) -> None:
        self.script.append((time_ms * MS, message))
        self.script.sort(key=lambda entry: entry[0])

    def send(self, message: FromWorker) -> None:
        self.sent.append((self.clock.now_ns(), message))
        if isinstance(message, Picture) and self.shows:
            self._frames += 1
            shown = FrameShown(frame=self._frames, step=message.step, flushed_ns=self.clock.now_ns())
            self.script.insert(0, (self.clock.now_ns(), shown))

    def receive(self, timeout_s: float | None = 0.0) -> list[ToWorker]:
        until_ns = None if timeout_s is None else self.clock.now_ns() + round(timeout_s * NS_PER_S)
        if until_ns is None or (self.script and self.script[0][0] <= until_ns):
            assert self.script, "the worker waits for ever"
            self.clock.advance_to_ns(self.script[0][0])
            messages = [message for time_ns, message in self.script if time_ns <= self.clock.now_ns()]
            self.script = [entry for entry in self.script if entry[0] > self.clock.now_ns()]
            return messages
        self.clock.advance_to_ns(until_ns)
        return []

    def pictures(self, step: int) -> list[int]:
        """Return when the pictures of a step were sent, ms."""
        return [
            time_ns // MS
            for time_ns, message in self.sent
            if isinstance(message, Picture) and message.step == step
        ]


class ScriptedSession:
    """Plays given outputs; notes the inputs it was given after each step."""

    def __init__(self, outputs: Iterable[Output]) -> None:
        self.outputs = outputs
        self.heard: dict[int, list[Input]] = {}

    def run(self, feedback: FeedbackSource, clock: Clock) -> Iterator[Output]:
        for output in self.outputs:
            yield output
            if isinstance(output, StepTaken):
                self.heard[output.step] = list(feedback.during(output.step))
                if any(isinstance(item, StopAsked) for item in self.heard[output.step]):
                    yield episode_ended()
                    yield session_ended("participant")
                    return


@pytest.fixture
def clock() -> ManualClock:
    return ManualClock()


@pytest.fixture
def line(clock: ManualClock) -> ScriptedLine:
    return ScriptedLine(clock)


def run(line: ScriptedLine, outputs: Iterable[Output]) -> ScriptedSession:
    protocol = Protocol(screen=ScreenConfig(tick_ms=TICK_MS, pause_between_episodes_s=1.0))
    session = ScriptedSession(outputs)
    SessionPlayer(line, protocol, line.clock).run(session)  # type: ignore[arg-type]
    return session


TWO_STEPS = (episode_started(), step_taken(0), step_taken(1, column=4), episode_ended(), session_ended())


def test_pictures_come_one_per_tick_from_the_start_of_the_step(line: ScriptedLine) -> None:
    run(line, TWO_STEPS)
    times = line.pictures(0)
    assert times == list(range(TICK_MS, TICK_MS * (len(times) + 1), TICK_MS))


def test_a_step_begins_when_the_one_before_is_over_so_nothing_drifts(line: ScriptedLine) -> None:
    run(line, TWO_STEPS)
    assert line.pictures(1)[0] == line.pictures(0)[-1] + TICK_MS


def test_outputs_are_sent_before_they_are_shown_and_pictures_are_numbered(line: ScriptedLine) -> None:
    run(line, TWO_STEPS)
    messages = [message for _, message in line.sent]
    assert messages.index(step_taken(0)) < next(
        number
        for number, message in enumerate(messages)
        if isinstance(message, Picture) and message.step == 0
    )
    numbers = [message.number for message in messages if isinstance(message, Picture)]
    assert numbers == list(range(len(numbers)))


def test_a_pause_stops_simulated_time_and_no_longer(line: ScriptedLine) -> None:
    line.at(120, ScreenCleared(time_ns=120 * MS, reason="pause"))
    line.at(5_120, Resumed(time_ns=5_120 * MS))
    run(line, TWO_STEPS)
    times = line.pictures(0)
    assert times[:3] == [50, 100, 5_150]
    gaps = {later - earlier for earlier, later in itertools.pairwise(times[2:])}
    assert gaps == {TICK_MS}


def test_inputs_reach_the_session_in_order_after_the_step_during_which_they_came(line: ScriptedLine) -> None:
    line.shows = False
    shown = [FrameShown(frame=step, step=step, flushed_ns=0) for step in range(2)]
    line.at(60, shown[0])
    line.at(70, ScreenCleared(time_ns=70 * MS, reason="help"))
    line.at(90, Resumed(time_ns=90 * MS))
    line.at(2_000, shown[1])
    session = run(line, TWO_STEPS)
    assert session.heard[0] == [
        shown[0],
        ScreenCleared(time_ns=70 * MS, reason="help"),
        Resumed(time_ns=90 * MS),
    ]
    assert session.heard[1] == [shown[1]]


def test_no_step_is_over_before_the_screen_has_shown_it(line: ScriptedLine) -> None:
    line.shows = False
    line.at(9_000, FrameShown(frame=0, step=0, flushed_ns=8_999 * MS))
    line.at(12_000, FrameShown(frame=1, step=1, flushed_ns=11_999 * MS))
    run(line, TWO_STEPS)
    assert line.pictures(1)[0] == 9_000


def test_a_stop_breaks_the_step_off_at_once(line: ScriptedLine) -> None:
    line.at(130, StopAsked(time_ns=130 * MS, reason="participant"))
    run(line, TWO_STEPS)
    assert line.pictures(0) == [50, 100]
    assert line.pictures(1) == []
    assert line.sent[-1][0] == 130 * MS


def test_the_final_board_stays_for_the_break_and_belongs_to_no_step(line: ScriptedLine) -> None:
    run(line, TWO_STEPS)
    last_tick_ends = line.pictures(1)[-1] + TICK_MS
    assert line.pictures(-1)[-1] == last_tick_ends
    assert line.sent[-1][0] // MS == last_tick_ends + 1_000


def test_the_line_keeps_what_is_said_whole_and_in_order() -> None:
    ours, theirs = multiprocessing.Pipe()
    line = WorkerLine(theirs)
    from arl_tui.app.link import _encoder

    inputs = [Begin(), *(FrameShown(frame=number, step=0, flushed_ns=number) for number in range(50))]
    for message in inputs:
        ours.send_bytes(_encoder.encode(message))
    assert line.receive() == inputs
    assert line.receive() == []
    ours.close()
    with pytest.raises(EOFError):
        line.receive()


def test_the_screen_is_told_at_once_what_a_press_was_taken_for(line: ScriptedLine) -> None:
    steps = (episode_started(), step_taken(0), step_taken(1, column=4), episode_ended(), session_ended())
    run(line, steps)
    second_ms = line.pictures(1)[0]
    again = ScriptedLine(ManualClock())
    time_ns = (second_ms + TICK_MS + 7) * MS
    pressed = {"key": "j", "value": 1.0, "frame": 0, "step": 1}
    again.at(second_ms + TICK_MS + 7, KeyPressed(press=4, time_ns=time_ns, verdict="accepted", **pressed))
    again.at(
        second_ms + TICK_MS + 9, KeyPressed(press=5, time_ns=time_ns, verdict="no-presses-left", **pressed)
    )
    run(again, steps)
    ((told_ns, taken),) = [(at, each) for at, each in again.sent if isinstance(each, TakenFor)]
    assert told_ns == time_ns  # not when the step is over
    assert (taken.press, taken.value, taken.step) == (4, 1.0, 0)
    assert len(taken.place) == 4


def test_a_setting_leaves_the_marks_out(line: ScriptedLine) -> None:
    line.at(
        200, KeyPressed(press=0, time_ns=200 * MS, key="j", value=1.0, frame=0, step=0, verdict="accepted")
    )
    screen = ScreenConfig(tick_ms=TICK_MS, pause_between_episodes_s=1.0, mark_presses=False)
    # type: ignore[arg-type]
    SessionPlayer(line, Protocol(screen=screen), line.clock).run(ScriptedSession(TWO_STEPS))
    assert not any(isinstance(message, TakenFor) for _, message in line.sent)
