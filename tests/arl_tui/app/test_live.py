"""The session as the screen's process knows it, without any screen."""

import pytest

from arl_tui.app.link import Alive, Begin, Crashed, Ready
from arl_tui.app.live_session import LiveSession
from core.events import (
    Event,
    FrameShown,
    KeyPressed,
    PressRetracted,
    Resumed,
    ScreenCleared,
    StopAsked,
    TimeGap,
    WrongPressAsked,
)
from core.feedback.frames import FRAMES_REMEMBERED, FrameLedger
from core.feedback.keys import KeyConfig
from core.numerics.clock import ManualClock
from tests.arl_tui.fakes import FakeLink, ListSink, episode_ended, episode_started, session_ended, step_taken

MS = 1_000_000


class Bench:
    """A session with everything around it faked."""

    def __init__(
        self, keys: KeyConfig | None = None, root_seed: int = 1, earlier: tuple[Event, ...] = ()
    ) -> None:
        self.clock = ManualClock(1_000 * MS)
        self.link = FakeLink()
        self.sink = ListSink()
        self.stamps: list[tuple[int, int]] = []
        self.heard: list[object] = []
        self.over: list[str | None] = []
        self.live = LiveSession(
            keys=keys or KeyConfig(),
            root_seed=root_seed,
            link=self.link,
            clock=self.clock,
            listener=self.heard.append,
            on_over=self.over.append,
            earlier=earlier,
        )
        self.live.take_stamps = self._take
        self.link.listen(self.live.take_in, self.live.worker_lost)

    def _take(self) -> list[tuple[int, int]]:
        taken, self.stamps = self.stamps, []
        return taken

    def begin(self) -> None:
        self.live.begin(self.sink)
        self.link.say(episode_started())

    def show(self, step: int, time_ms: int) -> int:
        """Draw a frame of `step`, flushed at `time_ms`."""
        frame = self.live.painted(step)
        self.stamps.append((frame, time_ms * MS))
        return frame

    def presses(self) -> list[KeyPressed]:
        return [event for event in self.sink.events if isinstance(event, KeyPressed)]


def test_a_press_is_bound_to_the_frame_that_was_on_screen_when_the_key_was_read() -> None:
    bench = Bench()
    bench.begin()
    bench.link.say(step_taken(0), step_taken(1))
    first = bench.show(0, 100)
    second = bench.show(1, 200)
    bench.live.key_pressed("j", 199 * MS)
    bench.live.key_pressed("f", 350 * MS)
    assert [(press.frame, press.step) for press in bench.presses()] == [(first, 0), (second, 1)]


def test_a_press_before_the_first_frame_belongs_to_no_step() -> None:
    bench = Bench()
    bench.begin()
    bench.live.key_pressed("j", 50 * MS)
    assert [(press.frame, press.step) for press in bench.presses()] == [(-1, -1)]


def test_a_handler_that_runs_late_does_not_move_the_press_to_a_later_step() -> None:
    bench = Bench()
    bench.begin()
    bench.show(0, 100)
    bench.show(1, 200)
    bench.live.collect_frames()
    bench.live.key_pressed("j", 150 * MS)
    assert bench.presses()[0].step == 0


def test_inputs_are_sent_to_the_worker_as_they_are_recorded_and_in_the_same_order() -> None:
    bench = Bench()
    bench.begin()
    bench.show(0, 100)
    bench.live.key_pressed("j", 150 * MS)
    bench.live.key_pressed("u", 400 * MS)
    bench.clock.advance_to_ns(1_500 * MS)
    bench.live.cover("pause")
    bench.live.uncover()
    bench.live.stop()
    recorded = [event for event in bench.sink.events if event != episode_started()]
    assert bench.link.sent == [Begin(), *recorded]
    assert [type(event) for event in recorded] == [
        FrameShown,
        KeyPressed,
        KeyPressed,
        PressRetracted,
        ScreenCleared,
        Resumed,
        StopAsked,
    ]


def test_nothing_is_recorded_before_the_start_and_after_the_end() -> None:
    bench = Bench()
    bench.live.key_pressed("j", 10 * MS)
    bench.begin()
    bench.link.say(session_ended())
    bench.live.key_pressed("j", 20 * MS)
    bench.live.cover("pause")
    bench.live.stop()
    assert bench.sink.events == [episode_started(), session_ended()]
    assert bench.over == [None]


def test_presses_under_a_cover_are_recorded_and_do_not_count() -> None:
    bench = Bench()
    bench.begin()
    bench.show(0, 100)
    bench.live.cover("help")
    bench.live.key_pressed("j", 1_200 * MS)
    bench.live.key_pressed("h", 1_300 * MS)
    bench.live.uncover()
    bench.live.key_pressed("j", 1_400 * MS)
    assert [(press.verdict, press.step) for press in bench.presses()] == [
        ("covered", -1),
        ("other", -1),
        ("accepted", -1),
    ]


def test_a_frame_that_leaves_after_the_cover_was_recorded_is_not_shown() -> None:
    bench = Bench()
    bench.begin()
    bench.show(0, 100)
    bench.live.cover("pause")
    bench.show(0, 1_001)
    bench.live.uncover()
    frames = [event for event in bench.sink.events if isinstance(event, FrameShown)]
    assert [frame.frame for frame in frames] == [0]


def test_a_worker_that_dies_leaves_a_stop_in_the_recording_and_a_reason_for_the_participant() -> None:
    bench = Bench()
    bench.begin()
    bench.link.say(Crashed(error="ValueError: boom", trace="Traceback ..."))
    bench.link.die("The learner's process left with status 1.")
    stop = bench.sink.events[-1]
    assert isinstance(stop, StopAsked)
    assert stop.reason == "worker-died"
    assert bench.over == ["ValueError: boom\n\nTraceback ..."]


def test_the_session_ends_only_once() -> None:
    bench = Bench()
    bench.begin()
    bench.link.say(session_ended())
    bench.live.worker_lost("gone")
    bench.live.give_up("too slow")
    assert bench.over == [None]


def test_the_worker_finishes_what_it_has_to_say_after_a_stop() -> None:
    bench = Bench()
    bench.begin()
    bench.live.stop()
    assert bench.live.phase == "stopping"
    bench.link.say(episode_ended(), session_ended("participant"))
    assert bench.sink.events[-2:] == [episode_ended(), session_ended("participant")]
    assert bench.over == [None]


def test_the_tally_counts_what_counts() -> None:
    bench = Bench(KeyConfig(max_presses_per_episode=3))
    bench.begin()
    bench.link.say(step_taken(0), step_taken(1))
    for number, key in enumerate("jfjuff"):
        bench.live.key_pressed(key, (100 + 900 * number) * MS)
    bench.link.say(episode_ended(performance=4.0))
    tally = bench.live.tally
    # j f j, u takes the second j back, f is the third that counts, the next f is one too many.
    assert (tally.good, tally.bad, tally.taken_back, tally.steps) == (1, 2, 1, 2)
    assert tally.performances == [4.0]


def test_about_one_press_in_ten_is_asked_to_be_wrong_and_recorded_as_such() -> None:
    bench = Bench(KeyConfig(wrong_press_rate=0.1, max_presses_per_episode=5))
    bench.begin()
    time_ms = 0
    for step in range(2_000):
        if step % 5 == 0:
            bench.link.say(episode_started(step // 5))
        bench.link.say(step_taken(step))
        time_ms += 1_000
        bench.live.key_pressed("j" if step % 2 else "f", time_ms * MS)
    asked = [event for event in bench.sink.events if isinstance(event, WrongPressAsked)]
    wrong = [press for press in bench.presses() if press.asked_wrong]
    # Binomial(2000, 0.1): mean 200, sd 13.4; four of them.
    assert len(asked) == pytest.approx(200, abs=54)
    assert len(wrong) == len(asked)


def test_nobody_is_asked_for_wrong_presses_by_default() -> None:
    bench = Bench()
    bench.begin()
    bench.link.say(*(step_taken(step) for step in range(100)))
    assert not any(isinstance(event, WrongPressAsked) for event in bench.sink.events)


def test_ready_is_told_to_the_screens() -> None:
    bench = Bench()
    bench.link.say(Ready(warm_up_ns=5))
    assert bench.live.ready
    assert bench.heard == [Ready(warm_up_ns=5)]


def test_the_ledger_forgets_only_what_is_far_too_old_to_be_asked_for() -> None:
    ledger = FrameLedger()
    for number in range(FRAMES_REMEMBERED + 10):
        ledger.flushed(ledger.painted(number), number)
    assert ledger.at(FRAMES_REMEMBERED + 9) == (FRAMES_REMEMBERED + 9, FRAMES_REMEMBERED + 9)
    assert ledger.at(10) == (10, 10)
    assert ledger.at(3) == (-1, -1)


def test_a_press_is_confirmed_when_it_is_in_the_file_and_not_before() -> None:
    bench = Bench()
    bench.begin()
    bench.link.say(step_taken(0))
    bench.show(0, 1_000)
    bench.sink.held_back = 100
    bench.live.key_pressed("j", 1_100 * MS)
    bench.live.key_pressed("f", 1_900 * MS)
    assert [event for event in bench.heard if isinstance(event, KeyPressed)] == []
    assert bench.live.presses_left == 5
    bench.clock.advance_ns(300 * MS)
    assert bench.live.unconfirmed_s() == pytest.approx(0.3)
    bench.sink.held_back = 1
    bench.live.confirm()
    assert [event.key for event in bench.heard if isinstance(event, KeyPressed)] == ["j"]
    assert bench.live.presses_left == 4
    bench.sink.held_back = 0
    bench.live.confirm()
    assert [event.key for event in bench.heard if isinstance(event, KeyPressed)] == ["j", "f"]
    assert bench.live.unconfirmed_s() == 0.0


def test_nothing_is_confirmed_once_the_disk_has_failed() -> None:
    bench = Bench()
    bench.begin()
    bench.sink.failure = OSError(28, "No space left on device")
    bench.live.key_pressed("j", 1_100 * MS)
    bench.live.confirm()
    assert [event for event in bench.heard if isinstance(event, KeyPressed)] == []


def test_a_press_of_a_game_that_is_over_does_not_change_the_presses_left_of_the_next() -> None:
    bench = Bench()
    bench.begin()
    bench.sink.held_back = 100
    bench.live.key_pressed("j", 1_100 * MS)
    bench.link.say(episode_ended(), episode_started(1))
    bench.sink.held_back = 0
    bench.live.confirm()
    assert bench.live.presses_left == 5


def test_a_silent_worker_is_noticed_until_it_says_that_it_waits() -> None:
    bench = Bench()
    bench.begin()
    bench.clock.advance_ns(2_500 * MS)
    assert bench.live.silent_s() == pytest.approx(2.5)
    bench.link.say(Alive())
    assert bench.live.silent_s() == 0.0
    assert not any(isinstance(event, Alive) for event in bench.heard)


def test_a_session_that_goes_on_continues_numbers_tally_and_wrong_presses() -> None:
    keys = KeyConfig(wrong_press_rate=0.5, max_presses_per_episode=20)
    whole = Bench(keys, root_seed=4)
    resumed = None
    for game in range(6):
        if game == 3:
            # It breaks off after three games: another program knows only what is in the file.
            resumed = Bench(keys, root_seed=4, earlier=tuple(whole.sink.events))
            resumed.live.begin(resumed.sink)
            joint = resumed.sink.events[0]
            assert isinstance(joint, TimeGap)
            assert joint.joint
            assert resumed.link.sent == [Begin(), joint]
            assert joint not in resumed.heard
        for bench in (whole,) if resumed is None else (whole, resumed):
            play_a_game(bench, game)
    assert resumed is not None
    numbers = [press.press for press in whole.presses()]
    n_before = len(numbers) - len(resumed.presses())
    assert n_before == 12
    assert resumed.presses() == whole.presses()[n_before:]
    assert any(press.asked_wrong for press in resumed.presses())
    frames = [event.frame for event in whole.sink.events if isinstance(event, FrameShown)]
    again = [event.frame for event in resumed.sink.events if isinstance(event, FrameShown)]
    assert frames[-len(again) :] == again
    assert resumed.live.tally == whole.live.tally
    assert resumed.live.presses_left == whole.live.presses_left


def play_a_game(bench: Bench, game: int) -> None:
    if bench.live.phase == "waiting":
        bench.live.begin(bench.sink)
    bench.link.say(episode_started())
    for step in range(4 * game, 4 * game + 4):
        bench.link.say(step_taken(step))
        bench.show(step, 2000 * (step + 1))
        bench.live.collect_frames()
        bench.live.key_pressed("jf"[step % 2], (2000 * (step + 1) + 900) * MS)
    bench.link.say(episode_ended())
