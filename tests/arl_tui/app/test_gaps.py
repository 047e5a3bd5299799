"""A machine that sleeps, a stopped process, a window without the keyboard: noticed and recorded."""

import contextvars
import threading

import pytest

from arl_tui.app.gaps import LONGEST_NS, GapWatch
from arl_tui.screens.covers import PauseScreen
from arl_tui.screens.play import PlayScreen
from arl_tui.session_app import ArlApp
from core.events import (
    FocusLost,
    FocusRegained,
    FrameShown,
    KeyPressed,
    Resumed,
    ScreenCleared,
    TimeGap,
)
from core.numerics.clock import NS_PER_S, ManualClock, suspended_ns
from core.session.protocol import Protocol
from tests.arl_tui.app.test_live import MS, Bench
from tests.arl_tui.driving import SIZE, begin, settle, text_of
from tests.arl_tui.fakes import FakeLink


@pytest.mark.usefixtures("notices_gaps")
def test_only_more_than_a_second_without_a_look_is_a_gap() -> None:
    clock = ManualClock(5 * NS_PER_S)
    watch = GapWatch(clock, suspended=lambda: 0)
    clock.advance_ns(LONGEST_NS)
    assert watch.look() is None
    clock.advance_ns(LONGEST_NS + 1)
    assert watch.look() == TimeGap(last_ns=6 * NS_PER_S, time_ns=7 * NS_PER_S + 1)
    assert watch.look() is None


@pytest.mark.usefixtures("notices_gaps")
def test_a_sleep_that_the_clock_does_not_count_is_a_gap() -> None:
    clock, asleep = ManualClock(5 * NS_PER_S), [100]
    watch = GapWatch(clock, suspended=lambda: asleep[0])
    asleep[0] += 30_000  # two clocks are not read in the same moment
    assert watch.look() is None
    clock.advance_ns(3 * MS)
    asleep[0] += 60 * NS_PER_S
    assert watch.look() == TimeGap(
        last_ns=5 * NS_PER_S, time_ns=5 * NS_PER_S + 3 * MS, suspended_ns=60 * NS_PER_S
    )
    assert watch.look() is None


def test_the_time_a_machine_was_suspended_never_falls() -> None:
    first = suspended_ns()
    assert first > -MS
    assert suspended_ns() >= first - MS


def gap_of(bench: Bench, *, last_ms: int, now_ms: int, suspended_ms: int = 0) -> None:
    gaps = [TimeGap(last_ns=last_ms * MS, time_ns=now_ms * MS, suspended_ns=suspended_ms * MS)]
    bench.clock.advance_to_ns(now_ms * MS)
    bench.live.find_gap = lambda: gaps.pop() if gaps else None


def test_a_gap_is_in_the_file_between_what_was_seen_before_and_after() -> None:
    bench = Bench()
    bench.begin()
    bench.show(0, 1_000)
    bench.show(1, 1_450)  # left the program just before it was stopped, and was not noted any more
    bench.show(2, 4_005)  # and just after
    gap_of(bench, last_ms=1_400, now_ms=4_000)
    bench.live.key_pressed("j", 4_010 * MS)
    kinds = [event for event in bench.sink.events if isinstance(event, FrameShown | TimeGap | KeyPressed)]
    assert [type(event) for event in kinds] == [FrameShown, FrameShown, TimeGap, KeyPressed]
    assert kinds[2] == TimeGap(last_ns=1_450 * MS, time_ns=4_000 * MS)
    assert kinds[2] in bench.link.sent
    assert kinds[2] in bench.heard


def test_a_press_typed_while_the_program_stood_still_is_on_no_frame() -> None:
    bench = Bench()
    bench.begin()
    bench.show(0, 1_000)
    gap_of(bench, last_ms=1_400, now_ms=4_000)
    bench.live.key_pressed("j", 4_001 * MS)
    assert [(press.frame, press.step) for press in bench.presses()] == [(-1, -1)]


def test_a_gap_before_the_start_and_after_the_end_is_none() -> None:
    bench = Bench()
    gap_of(bench, last_ms=1_400, now_ms=4_000)
    bench.live.notice_gap()
    bench.begin()
    bench.live.stop()
    gap_of(bench, last_ms=5_400, now_ms=9_000)
    bench.live.notice_gap()
    assert not [event for event in bench.sink.events if isinstance(event, TimeGap)]


async def test_after_a_gap_the_session_pauses_by_itself_and_says_why(
    app: ArlApp, link: FakeLink, protocol: Protocol
) -> None:
    async with app.run_test(size=SIZE) as pilot:
        await begin(pilot, link, protocol, steps=1)
        now_ns = app._clock.now_ns()
        gaps = [TimeGap(last_ns=now_ns - 7 * NS_PER_S, time_ns=now_ns, suspended_ns=5 * NS_PER_S)]
        app.live.find_gap = lambda: gaps.pop() if gaps else None
        await pilot.press("j")
        await settle(pilot)
        assert isinstance(app.screen, PauseScreen)
        assert "held up for 12 seconds" in text_of(app)
        await pilot.press("p")
        await settle(pilot)
        assert isinstance(app.screen, PlayScreen)
        presses = [message for message in link.sent if isinstance(message, KeyPressed)]
        assert [(press.key, press.verdict) for press in presses] == [("j", "covered"), ("p", "other")]
        order = [type(m) for m in link.sent if isinstance(m, TimeGap | ScreenCleared | Resumed)]
        assert order == [TimeGap, ScreenCleared, Resumed]
        app.live.give_up("end of the test")
        await settle(pilot)


async def test_a_gap_under_a_pause_is_noted_and_the_pause_stays(
    app: ArlApp, link: FakeLink, protocol: Protocol
) -> None:
    async with app.run_test(size=SIZE) as pilot:
        await begin(pilot, link, protocol, steps=1)
        await pilot.press("p")
        now_ns = app._clock.now_ns()
        gaps = [TimeGap(last_ns=now_ns - 7 * NS_PER_S, time_ns=now_ns)]
        app.live.find_gap = lambda: gaps.pop() if gaps else None
        app.live.notice_gap()
        await settle(pilot)
        assert isinstance(app.screen, PauseScreen)
        assert "The computer slept" not in text_of(app)
        assert len([m for m in link.sent if isinstance(m, ScreenCleared)]) == 1
        app.live.give_up("end of the test")
        await settle(pilot)


async def test_the_window_s_focus_is_recorded_and_only_its_changes(
    app: ArlApp, link: FakeLink, protocol: Protocol
) -> None:
    from textual import events

    async with app.run_test(size=SIZE) as pilot:
        await begin(pilot, link, protocol, steps=1)
        for event in (events.AppFocus(), events.AppBlur(), events.AppBlur(), events.AppFocus()):
            app.post_message(event)
        await settle(pilot)
        sent = [type(m) for m in link.sent if isinstance(m, FocusLost | FocusRegained)]
        assert sent == [FocusLost, FocusRegained]
        app.live.give_up("end of the test")
        await settle(pilot)


def test_a_session_that_begins_without_the_focus_says_so() -> None:
    bench = Bench()
    bench.live.focus(False)
    bench.begin()
    assert any(isinstance(event, FocusLost) for event in bench.sink.events)


@pytest.mark.parametrize(
    ("keys", "screen"),
    [(("з",), PauseScreen), (("פ",), PauseScreen), (("π",), PauseScreen), (("\uff50",), PauseScreen)],
)
async def test_keys_of_another_layout_steer_the_session(
    app: ArlApp, link: FakeLink, protocol: Protocol, keys: tuple[str, ...], screen: type
) -> None:
    async with app.run_test(size=SIZE) as pilot:
        await begin(pilot, link, protocol, steps=1)
        await pilot.press(*keys)
        assert isinstance(app.screen, screen)
        await pilot.press(*keys)
        await settle(pilot)
        assert isinstance(app.screen, PlayScreen)
        pressed = [m for m in link.sent if isinstance(m, KeyPressed)]
        assert [(press.key, press.read_as) for press in pressed] == [(keys[0], "p")] * 2
        app.live.give_up("end of the test")
        await settle(pilot)


async def test_a_key_that_cannot_be_read_says_to_change_the_layout(
    app: ArlApp, link: FakeLink, protocol: Protocol
) -> None:
    async with app.run_test(size=SIZE) as pilot:
        await begin(pilot, link, protocol, steps=1)
        await pilot.press("ก")
        assert "keyboard set to Thai letters? Change it to English" in app.play.feedback.note
        app.live.give_up("end of the test")
        await settle(pilot)


async def test_a_mark_that_may_be_meant_for_q_says_so_at_the_second_press(
    app: ArlApp, link: FakeLink
) -> None:
    async with app.run_test(size=SIZE) as pilot:
        await pilot.press("slash")
        assert not app._notifications
        await pilot.press("slash")
        await settle(pilot)
        (said,) = app._notifications
        assert "other letters? Change it to English" in said.message


@pytest.mark.parametrize("first_told_by", ["the writing thread", "a signal"])
async def test_a_gap_that_another_thread_notices_first_pauses_the_session(
    app: ArlApp, link: FakeLink, protocol: Protocol, first_told_by: str
) -> None:
    async with app.run_test(size=SIZE) as pilot:
        await begin(pilot, link, protocol, steps=1)
        now_ns = app.live._clock.now_ns()
        gaps = [TimeGap(last_ns=now_ns - 2 * NS_PER_S, time_ns=now_ns)]
        app.live.find_gap = lambda: gaps.pop() if gaps else None
        tell = app._flush_clock.on_stamp
        if first_told_by == "a signal":

            def tell() -> None:
                app.soon(app.live.notice_gap)

        # Neither has the context in which Textual finds the app of a page.
        thread = threading.Thread(target=lambda: contextvars.Context().run(tell))
        thread.start()
        thread.join()
        await settle(pilot)
        assert isinstance(app.screen, PauseScreen)
        await pilot.press("space")
        await settle(pilot)
        assert isinstance(app.screen, PlayScreen)
