"""The app when something fails: the worker, the disk, the folder of recordings, the size of the window."""

import json
from pathlib import Path

import pytest
from msgspec.structs import replace
from textual.pilot import Pilot

from arl_tui.app.link import Crashed, Ready
from arl_tui.app.outcome import SessionOutcome
from arl_tui.screens.closing import ClosingScreen
from arl_tui.screens.covers import SmallWindowScreen
from arl_tui.screens.play import PlayScreen
from arl_tui.session_app import ArlApp
from core.events import (
    Event,
    KeyPressed,
    ScreenCleared,
    StopAsked,
)
from core.recording.recorder import LineWriter
from core.session.protocol import Protocol
from core.tetris.config import TetrisConfig
from tests.arl_tui.driving import SIZE, app_for, begin, recorded, settle, text_of
from tests.arl_tui.fakes import FakeLink, session_ended


async def test_a_worker_that_dies_ends_the_session_with_a_message_and_a_complete_recording(
    app: ArlApp, link: FakeLink, protocol: Protocol, tmp_path: Path
) -> None:
    async with app.run_test(size=SIZE) as pilot:
        await begin(pilot, link, protocol, steps=1)
        await pilot.press("j")
        await pilot.press("p")
        link.say(Crashed(error="ZeroDivisionError: oh", trace="Traceback\n  line 1\nZeroDivisionError: oh"))
        link.die("left with status 1")
        await settle(pilot)
        assert isinstance(app.screen, ClosingScreen)
        text = text_of(app)
        await pilot.press("enter")
    assert "ZeroDivisionError: oh" in text
    assert "Everything up to this moment is recorded" in text
    recording = recorded(tmp_path)
    assert recording.complete
    assert isinstance(recording.events[-1], StopAsked)
    assert any(isinstance(event, KeyPressed) for event in recording.events)
    assert app.return_value is not None
    assert "ZeroDivisionError" in str(app.return_value.trouble)


async def test_a_worker_that_dies_on_the_welcome_screen_is_reported(app: ArlApp, link: FakeLink) -> None:
    async with app.run_test(size=SIZE) as pilot:
        link.say(Crashed(error="ImportError: no numba", trace="..."))
        link.die("left")
        await settle(pilot)
        assert "ImportError: no numba" in text_of(app)
        await pilot.press("enter")
    assert app.return_value is not None
    assert app.return_value.recording is None


async def test_a_full_disk_stops_the_session_and_the_rest_is_saved_elsewhere(
    app: ArlApp, link: FakeLink, protocol: Protocol, monkeypatch: pytest.MonkeyPatch, tmp_path: Path
) -> None:
    append = LineWriter.append

    def until_a_press(self: LineWriter, event: Event) -> None:
        if isinstance(event, KeyPressed):
            raise OSError(28, "No space left on device")
        append(self, event)

    monkeypatch.setattr(LineWriter, "append", until_a_press)
    monkeypatch.setattr("tempfile.tempdir", str(tmp_path / ".."))
    async with app.run_test(size=SIZE) as pilot:
        worker = await begin(pilot, link, protocol, steps=1)
        await pilot.press("j")
        worker.step(1)
        await settle(pilot)
        assert any(isinstance(message, StopAsked) for message in link.sent)
        link.say(session_ended("participant"))
        await settle(pilot)
        text = text_of(app)
        await pilot.press("enter")
    assert "No space left on device" in text
    assert app.return_value is not None
    assert app.return_value.trouble is not None
    rest = Path(
        app.return_value.trouble.splitlines()[1].removeprefix("What could not be written to it is in ")
    )
    assert json.loads(rest.read_text().splitlines()[0])["key"] == "j"
    assert not recorded(tmp_path).complete


async def test_a_folder_that_takes_no_files_is_reported(
    protocol: Protocol, link: FakeLink, tmp_path: Path
) -> None:
    (tmp_path / "file").touch()
    app = app_for(protocol, link, tmp_path / "file" / "r")
    async with app.run_test(size=SIZE) as pilot:
        link.say(Ready(warm_up_ns=1))
        await pilot.press("enter")
        await settle(pilot)
        assert "cannot be written" in text_of(app)
        await pilot.press("enter")
    assert app.return_value is not None
    assert app.return_value.recording is None


async def begin_and_shrink(pilot: Pilot[SessionOutcome], link: FakeLink, protocol: Protocol) -> None:
    """Show a step, and make the window too small for it."""
    await begin(pilot, link, protocol, steps=1)
    await pilot.resize_terminal(60, 20)
    await settle(pilot)


async def test_a_window_that_is_too_small_covers_the_game_until_it_grows(
    app: ArlApp, link: FakeLink, protocol: Protocol
) -> None:
    async with app.run_test(size=SIZE) as pilot:
        await begin_and_shrink(pilot, link, protocol)
        assert isinstance(app.screen, SmallWindowScreen)
        await pilot.resize_terminal(100, 30)
        await settle(pilot)
        assert isinstance(app.screen, PlayScreen)
    reasons = [message.reason for message in link.sent if isinstance(message, ScreenCleared)]
    assert reasons == ["resize"]


async def test_whoever_cannot_have_a_larger_window_can_stop(
    app: ArlApp, link: FakeLink, protocol: Protocol
) -> None:
    async with app.run_test(size=SIZE) as pilot:
        await begin_and_shrink(pilot, link, protocol)
        assert "Q stops" in text_of(app)
        await pilot.press("q")
        await settle(pilot)
        assert isinstance(app.screen, PlayScreen)
    assert any(isinstance(message, StopAsked) for message in link.sent)


async def test_a_larger_board_asks_for_a_larger_window(
    protocol: Protocol, link: FakeLink, tmp_path: Path
) -> None:
    large = replace(protocol, domain=TetrisConfig(rows=26, columns=12))
    app = app_for(large, link, tmp_path)
    async with app.run_test(size=SIZE) as pilot:
        await begin(pilot, link, large)
        assert isinstance(app.screen, SmallWindowScreen)
        assert "82 columns and 29 lines" in text_of(app)
        await pilot.resize_terminal(82, 29)
        await settle(pilot)
        assert isinstance(app.screen, PlayScreen)
        assert app.play.panel.game_widget().region.bottom <= 29
        assert app.play.feedback.region.right <= 82
