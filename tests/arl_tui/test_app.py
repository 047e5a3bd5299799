"""The app with a faked worker: what the participant does, what the worker is told, and what is in the
file."""

import gc
from pathlib import Path

import pytest

from arl_tui.app.link import Begin, Ready
from arl_tui.app.outcome import SessionOutcome
from arl_tui.screens.closing import ClosingScreen
from arl_tui.screens.covers import HelpScreen, PauseScreen, StopScreen
from arl_tui.screens.play import PlayScreen
from arl_tui.screens.welcome import WelcomeScreen
from arl_tui.session_app import ArlApp
from core.events import (
    FrameShown,
    KeyPressed,
    Resumed,
    ScreenCleared,
    StopAsked,
    UnseenPlayed,
)
from core.session.protocol import Protocol
from tests.arl_tui.driving import SIZE, begin, recorded, settle, text_of
from tests.arl_tui.fakes import FakeLink, episode_ended, episode_started, session_ended


async def test_nothing_starts_before_the_worker_is_ready(app: ArlApp, link: FakeLink, tmp_path: Path) -> None:
    async with app.run_test(size=SIZE) as pilot:
        assert isinstance(app.screen, WelcomeScreen)
        await pilot.press("enter")
        assert isinstance(app.screen, WelcomeScreen)
        assert link.sent == []
        link.say(Ready(warm_up_ns=1))
        await pilot.pause()
        assert isinstance(app.screen, PlayScreen)
        assert link.sent == [Begin()]
    assert len(list(tmp_path.glob("P01-*.jsonl"))) == 1


async def test_no_practising_is_told_of_beside_a_game_that_began_before_the_page(
    app: ArlApp, link: FakeLink
) -> None:
    """On a busy machine the first game has begun before its page is laid out."""
    async with app.run_test(size=SIZE) as pilot:
        link.say(Ready(warm_up_ns=1))
        app.play.show(episode_started())
        await pilot.press("enter")
        await settle(pilot)
        assert isinstance(app.screen, PlayScreen)
        assert "Practising" not in text_of(app)
        link.say(session_ended())
        await settle(pilot)


async def test_leaving_the_welcome_screen_leaves_no_recording(app: ArlApp, tmp_path: Path) -> None:
    async with app.run_test(size=SIZE) as pilot:
        await pilot.press("q")
    assert app.return_value == SessionOutcome(None, app.live.tally)
    assert list(tmp_path.iterdir()) == []


async def test_the_welcome_screen_names_the_keys_and_the_limit(app: ArlApp) -> None:
    async with app.run_test(size=SIZE) as pilot:
        await pilot.pause()
        text = text_of(app)
    assert " J " in text
    assert " F " in text
    assert "2 presses in each game" in text
    assert "P01" in text


async def test_a_session_is_recorded_from_start_to_end(
    app: ArlApp, link: FakeLink, protocol: Protocol, tmp_path: Path
) -> None:
    async with app.run_test(size=SIZE) as pilot:
        worker = await begin(pilot, link, protocol, steps=1)
        await pilot.press("j")
        worker.step(1, column=4)
        await settle(pilot)
        await pilot.press("f", "x")
        link.say(episode_ended(), session_ended())
        await settle(pilot)
        assert isinstance(app.screen, ClosingScreen)
        assert link.closed
        await pilot.press("enter")
    recording = recorded(tmp_path)
    assert recording.complete
    assert recording.header.participant == "P01"
    assert recording.header.root_seed == 5
    presses = [event for event in recording.events if isinstance(event, KeyPressed)]
    assert [(press.key, press.verdict, press.step) for press in presses] == [
        ("j", "accepted", 0),
        ("f", "accepted", 1),
        ("x", "other", 1),
    ]
    shown = [event.step for event in recording.events if isinstance(event, FrameShown)]
    assert shown == sorted(shown)
    assert set(shown) == {-1, 0, 1}
    assert app.return_value is not None
    assert app.return_value.recording == recording.path
    assert app.return_value.trouble is None


async def test_pause_help_and_the_question_cover_the_game(
    app: ArlApp, link: FakeLink, protocol: Protocol, tmp_path: Path
) -> None:
    async with app.run_test(size=SIZE) as pilot:
        await begin(pilot, link, protocol, steps=1)
        for key, back, page in (("p", "p", PauseScreen), ("h", "space", HelpScreen), ("q", "n", StopScreen)):
            await pilot.press(key)
            assert isinstance(app.screen, page)
            await pilot.press("j")
            await pilot.press(back)
            await settle(pilot)
            assert isinstance(app.screen, PlayScreen)
        app.live.give_up("end of the test")
        await settle(pilot)
    events = recorded(tmp_path).events
    assert [event.reason for event in events if isinstance(event, ScreenCleared)] == [
        "pause",
        "help",
        "quit-dialogue",
    ]
    verdicts = [event.verdict for event in events if isinstance(event, KeyPressed) and event.key == "j"]
    assert verdicts == ["covered"] * 3
    for number, event in enumerate(events):
        if isinstance(event, Resumed):
            # The step is seen again, so its interval on screen begins again.
            assert any(isinstance(later, FrameShown) and later.step == 0 for later in events[number:])


async def test_stopping_asks_first_then_lets_the_worker_finish(
    app: ArlApp, link: FakeLink, protocol: Protocol, tmp_path: Path
) -> None:
    async with app.run_test(size=SIZE) as pilot:
        await begin(pilot, link, protocol, steps=1)
        await pilot.press("q", "y")
        await settle(pilot)
        assert isinstance(app.screen, PlayScreen)
        assert any(isinstance(message, StopAsked) for message in link.sent)
        link.say(episode_ended(), session_ended("participant"))
        await settle(pilot)
        assert isinstance(app.screen, ClosingScreen)
        await pilot.press("enter")
    assert recorded(tmp_path).complete
    assert app.return_value is not None
    assert app.return_value.trouble is None


@pytest.mark.usefixtures("nothing_frozen")
async def test_the_collector_rests_during_an_episode_and_works_after_it(
    app: ArlApp, link: FakeLink, protocol: Protocol
) -> None:
    async with app.run_test(size=SIZE) as pilot:
        await begin(pilot, link, protocol)
        assert not gc.isenabled()
        link.say(episode_ended())
        assert gc.isenabled()
        link.say(episode_started(1))
        assert not gc.isenabled()
    assert gc.isenabled()
    assert gc.get_freeze_count() == 0


async def test_unseen_episodes_are_told_at_the_end(app: ArlApp, link: FakeLink, protocol: Protocol) -> None:
    async with app.run_test(size=SIZE) as pilot:
        worker = await begin(pilot, link, protocol)
        worker.step(0)
        link.say(
            episode_ended(),
            UnseenPlayed(
                first_episode=1,
                time_ns=0,
                inputs=0,
                policies=[0, 1, 2],
                performances=[0.0, 1.0, 2.0],
                steps=[9, 9, 9],
                agreed=[0, 0, 0],
                agreed_worst=[0, 0, 0],
                trust=0.5,
                weights=[0.1, 0.3, 0.5],
                digest="00",
            ),
            session_ended(),
        )
        await settle(pilot)
        text = text_of(app)
    assert "practised 3 games" in text
    assert "50" not in text  # the trust tells the condition
