"""Presses in the app: what they are bound to, how they are confirmed, and which letters are whose."""

from pathlib import Path

from msgspec.structs import replace

from arl_tui.app.link import PressSuggested
from arl_tui.screens.covers import PauseScreen
from arl_tui.screens.play import PlayScreen
from arl_tui.session_app import ArlApp, key_name
from core.events import (
    FrameShown,
    KeyPressed,
    PressRetracted,
)
from core.feedback.keys import KeyConfig
from core.numerics.clock import MonotonicClock
from core.session.protocol import Protocol
from tests.arl_tui.driving import SIZE, app_for, begin, recorded, settle
from tests.arl_tui.fakes import FakeLink


async def test_each_press_is_bound_to_a_frame_that_was_shown_before_it(
    app: ArlApp, link: FakeLink, protocol: Protocol, tmp_path: Path
) -> None:
    async with app.run_test(size=SIZE) as pilot:
        worker = await begin(pilot, link, protocol)
        for step in range(3):
            worker.step(step, column=3 * step)
            await settle(pilot)
            await pilot.press("j")
        app.live.give_up("end of the test")
        await settle(pilot)
    events = recorded(tmp_path).events
    flushed = {event.frame: event for event in events if isinstance(event, FrameShown)}
    presses = [event for event in events if isinstance(event, KeyPressed)]
    assert len(presses) == 3
    for press in presses:
        assert flushed[press.frame].step == press.step
        assert flushed[press.frame].flushed_ns <= press.time_ns


async def test_a_suggested_press_goes_the_way_of_a_real_one_and_is_marked(
    app: ArlApp, link: FakeLink, protocol: Protocol, tmp_path: Path
) -> None:
    async with app.run_test(size=SIZE) as pilot:
        await begin(pilot, link, protocol, steps=1)
        link.say(PressSuggested(key="f", time_ns=MonotonicClock().now_ns() + 20_000_000))
        await settle(pilot)
        await pilot.press("j")
        app.live.give_up("end of the test")
        await settle(pilot)
    presses = [event for event in recorded(tmp_path).events if isinstance(event, KeyPressed)]
    assert [(press.key, press.source, press.verdict, press.step) for press in presses] == [
        ("f", "simulated", "accepted", 0),
        ("j", "participant", "accepted", 0),
    ]


async def test_a_press_is_confirmed_and_taken_back_on_screen(
    app: ArlApp, link: FakeLink, protocol: Protocol
) -> None:
    async with app.run_test(size=SIZE) as pilot:
        await begin(pilot, link, protocol, steps=1)
        bar = app.play.feedback
        await pilot.press("j")
        assert (bar.word, bar.presses_left) == ("GOOD", 1)
        await pilot.press("u")
        assert (bar.word, bar.presses_left) == ("TAKEN BACK", 2)
        await pilot.press("f")
        assert (bar.word, bar.presses_left) == ("BAD", 1)
    assert any(isinstance(message, PressRetracted) for message in link.sent)


async def test_capital_letters_are_the_same_keys(app: ArlApp, link: FakeLink, protocol: Protocol) -> None:
    async with app.run_test(size=SIZE) as pilot:
        await begin(pilot, link, protocol, steps=1)
        await pilot.press("J")
    presses = [message for message in link.sent if isinstance(message, KeyPressed)]
    assert [(press.key, press.verdict) for press in presses] == [("j", "accepted")]


async def test_a_command_letter_can_be_given_to_feedback(
    protocol: Protocol, link: FakeLink, tmp_path: Path
) -> None:
    keys = KeyConfig(good="p", bad="q", retract="h")
    app = app_for(replace(protocol, keys=keys), link, tmp_path)
    async with app.run_test(size=SIZE) as pilot:
        await begin(pilot, link, protocol, steps=1)
        await pilot.press("p", "q", "h")
        assert isinstance(app.screen, PlayScreen)
        await pilot.press("space")
        assert isinstance(app.screen, PauseScreen)
    presses = [message for message in link.sent if isinstance(message, KeyPressed)]
    assert [press.verdict for press in presses] == ["accepted", "accepted", "other", "other"]


async def test_keys_are_named_as_they_are_recorded() -> None:
    from textual.events import Key

    assert key_name(Key("J", "J")) == "j"
    assert key_name(Key("ctrl+J", None)) == "ctrl+J"
    assert key_name(Key("left_shift", None)) == "left_shift"
