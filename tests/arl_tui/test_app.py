"""The app with a faked worker: what the participant does, what the worker is told, and what is in the file."""

import gc
import json
from pathlib import Path

import pytest
from msgspec.structs import replace
from textual.pilot import Pilot
from textual.widgets import Static

from arl_tui.app import ArlApp, Outcome, Sitting, build_app, key_name
from arl_tui.link import Begin, Crashed, Picture, PressSuggested, Ready
from arl_tui.screens.closing import ClosingScreen
from arl_tui.screens.covers import HelpScreen, PauseScreen, SmallWindowScreen, StopScreen
from arl_tui.screens.play import PlayScreen
from arl_tui.screens.welcome import WelcomeScreen
from arl_tui.stage import TetrisStage
from core.clock import MonotonicClock
from core.episode import (
    Event,
    FrameShown,
    KeyPressed,
    PressRetracted,
    Resumed,
    ScreenCleared,
    StopAsked,
    UnseenPlayed,
)
from core.keys import KeyConfig
from core.protocol import Protocol
from core.recording.reader import Recording, read_recording
from core.recording.recorder import LineWriter
from core.tetris.config import TetrisConfig
from tests.arl_tui.fakes import FakeLink, episode_ended, episode_started, session_ended, step_taken

SIZE = (80, 24)


class Worker:
    """Plays the worker's part: outputs, and the pictures that go with them."""

    def __init__(self, link: FakeLink, protocol: Protocol) -> None:
        self.link = link
        self.stage = TetrisStage(protocol.domain)
        self.pictures = 0

    def start_episode(self) -> None:
        started = episode_started()
        self.link.say(started)
        self.show(-1, self.stage.begin(started)[0].view)

    def step(self, number: int, column: int = 0) -> None:
        taken = step_taken(number, column=column)
        self.link.say(taken)
        self.show(number, self.stage.act(taken)[0].view)

    def show(self, step: int, view: object) -> None:
        self.link.say(Picture(number=self.pictures, step=step, view=view))  # type: ignore[arg-type]
        self.pictures += 1


async def begin(pilot: Pilot[Outcome], link: FakeLink, protocol: Protocol) -> Worker:
    """Bring the app to a running episode."""
    link.say(Ready(warm_up_ns=1))
    await pilot.press("enter")
    await pilot.pause()
    worker = Worker(link, protocol)
    worker.start_episode()
    await settle(pilot)
    return worker


async def settle(pilot: Pilot[Outcome]) -> None:
    """Wait until what has been said is drawn and stamped."""
    await pilot.pause(0.05)


def recorded(folder: Path) -> Recording:
    (path,) = folder.glob("*.jsonl")
    return read_recording(path)


def text_of(app: ArlApp) -> str:
    return "\n".join(str(widget.render()) for widget in app.screen.query(Static))


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


async def test_leaving_the_welcome_screen_leaves_no_recording(app: ArlApp, tmp_path: Path) -> None:
    async with app.run_test(size=SIZE) as pilot:
        await pilot.press("q")
    assert app.return_value == Outcome(None, app.live.tally)
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
        worker = await begin(pilot, link, protocol)
        worker.step(0)
        await settle(pilot)
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


async def test_pause_help_and_the_question_cover_the_game(
    app: ArlApp, link: FakeLink, protocol: Protocol, tmp_path: Path
) -> None:
    async with app.run_test(size=SIZE) as pilot:
        worker = await begin(pilot, link, protocol)
        worker.step(0)
        await settle(pilot)
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
        worker = await begin(pilot, link, protocol)
        worker.step(0)
        await settle(pilot)
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


async def test_a_worker_that_dies_ends_the_session_with_a_message_and_a_complete_recording(
    app: ArlApp, link: FakeLink, protocol: Protocol, tmp_path: Path
) -> None:
    async with app.run_test(size=SIZE) as pilot:
        worker = await begin(pilot, link, protocol)
        worker.step(0)
        await settle(pilot)
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


async def test_a_suggested_press_goes_the_way_of_a_real_one_and_is_marked(
    app: ArlApp, link: FakeLink, protocol: Protocol, tmp_path: Path
) -> None:
    async with app.run_test(size=SIZE) as pilot:
        worker = await begin(pilot, link, protocol)
        worker.step(0)
        await settle(pilot)
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
        worker = await begin(pilot, link, protocol)
        worker.step(0)
        await settle(pilot)
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
        worker = await begin(pilot, link, protocol)
        worker.step(0)
        await settle(pilot)
        await pilot.press("J")
    presses = [message for message in link.sent if isinstance(message, KeyPressed)]
    assert [(press.key, press.verdict) for press in presses] == [("j", "accepted")]


async def test_a_command_letter_can_be_given_to_feedback(
    protocol: Protocol, link: FakeLink, tmp_path: Path
) -> None:

    keys = KeyConfig(good="p", bad="q", retract="h")
    sitting = Sitting(
        protocol=replace(protocol, keys=keys), root_seed=1, participant="P01", recordings=tmp_path
    )
    app = build_app(sitting, link)
    async with app.run_test(size=SIZE) as pilot:
        worker = await begin(pilot, link, protocol)
        worker.step(0)
        await settle(pilot)
        await pilot.press("p", "q", "h")
        assert isinstance(app.screen, PlayScreen)
        await pilot.press("space")
        assert isinstance(app.screen, PauseScreen)
    presses = [message for message in link.sent if isinstance(message, KeyPressed)]
    assert [press.verdict for press in presses] == ["accepted", "accepted", "other", "other"]


async def test_a_window_that_is_too_small_covers_the_game_until_it_grows(
    app: ArlApp, link: FakeLink, protocol: Protocol
) -> None:
    async with app.run_test(size=SIZE) as pilot:
        worker = await begin(pilot, link, protocol)
        worker.step(0)
        await settle(pilot)
        await pilot.resize_terminal(60, 20)
        await settle(pilot)
        assert isinstance(app.screen, SmallWindowScreen)
        await pilot.resize_terminal(100, 30)
        await settle(pilot)
        assert isinstance(app.screen, PlayScreen)
    reasons = [message.reason for message in link.sent if isinstance(message, ScreenCleared)]
    assert reasons == ["resize"]


async def test_a_larger_board_asks_for_a_larger_window(
    protocol: Protocol, link: FakeLink, tmp_path: Path
) -> None:
    large = replace(protocol, domain=TetrisConfig(rows=26, columns=12))
    app = build_app(Sitting(protocol=large, root_seed=1, participant="P01", recordings=tmp_path), link)
    async with app.run_test(size=SIZE) as pilot:
        await begin(pilot, link, large)
        assert isinstance(app.screen, SmallWindowScreen)
        assert "82 columns and 29 lines" in text_of(app)
        await pilot.resize_terminal(82, 29)
        await settle(pilot)
        assert isinstance(app.screen, PlayScreen)
        assert app.play.scene.stage().region.bottom <= 29
        assert app.play.feedback.region.right <= 82


async def test_a_full_disk_stops_the_session_and_the_rest_is_saved_elsewhere(
    app: ArlApp, link: FakeLink, protocol: Protocol, monkeypatch: pytest.MonkeyPatch, tmp_path: Path
) -> None:
    write = LineWriter.write

    def until_a_press(self: LineWriter, event: Event) -> None:
        if isinstance(event, KeyPressed):
            raise OSError(28, "No space left on device")
        write(self, event)

    monkeypatch.setattr(LineWriter, "write", until_a_press)
    monkeypatch.setattr("tempfile.tempdir", str(tmp_path / ".."))
    async with app.run_test(size=SIZE) as pilot:
        worker = await begin(pilot, link, protocol)
        worker.step(0)
        await settle(pilot)
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
    sitting = Sitting(protocol=protocol, root_seed=1, participant="P01", recordings=tmp_path / "file" / "r")
    app = build_app(sitting, link)
    async with app.run_test(size=SIZE) as pilot:
        link.say(Ready(warm_up_ns=1))
        await pilot.press("enter")
        await settle(pilot)
        assert "cannot be written" in text_of(app)
        await pilot.press("enter")
    assert app.return_value is not None
    assert app.return_value.recording is None


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
                w_h=0.5,
                digest="00",
            ),
            session_ended(),
        )
        await settle(pilot)
        text = text_of(app)
    assert "practised 3 games" in text
    assert "50%" in text


async def test_keys_are_named_as_they_are_recorded() -> None:
    from textual.events import Key

    assert key_name(Key("J", "J")) == "j"
    assert key_name(Key("ctrl+J", None)) == "ctrl+J"
    assert key_name(Key("left_shift", None)) == "left_shift"
