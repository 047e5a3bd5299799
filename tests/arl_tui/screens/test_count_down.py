"""The count-down before a game begins or goes on: what is seen, what is recorded, and which presses count."""

from pathlib import Path

import msgspec
import pytest
from textual.pilot import Pilot

from arl_tui.app.link import TakenFor
from arl_tui.app.outcome import SessionOutcome
from arl_tui.screens.covers import PauseScreen
from arl_tui.screens.play import PlayScreen
from arl_tui.session_app import ArlApp
from arl_tui.widgets.big_letters import big
from core.events import FrameShown, KeyPressed, Resumed, ScreenCleared
from core.session.protocol import Protocol
from tests.arl_tui.driving import SIZE, Worker, app_for, begin, recorded, settle
from tests.arl_tui.fakes import FakeLink, episode_ended, session_ended


@pytest.fixture
def protocol(protocol: Protocol) -> Protocol:
    screen = msgspec.structs.replace(protocol.screen, count_down_s=3)
    return msgspec.structs.replace(protocol, screen=screen)


@pytest.fixture
def app(protocol: Protocol, link: FakeLink, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> ArlApp:
    monkeypatch.setattr("arl_tui.screens.count_down.SECOND_S", 0.2)
    return app_for(protocol, link, tmp_path)


def board_text(app: ArlApp) -> str:
    board = app.play.panel.game_widget()
    drawn = board.drawn_frame
    text = "\n".join(board.render_line(y).text for y in range(board.size.height))
    board.drawn_frame = drawn  # looking is no drawing
    return text


async def wait_for_the_game(pilot: Pilot[SessionOutcome], app: ArlApp) -> None:
    for _ in range(100):
        await pilot.pause(0.05)
        if not app.play.panel.game_widget().covered:
            return
    raise AssertionError("the count-down does not end")


def covers(folder: Path) -> list[str]:
    """Return what covered the game, and that it came back, in order."""
    return [
        event.reason if isinstance(event, ScreenCleared) else "resumed"
        for event in recorded(folder).events
        if isinstance(event, ScreenCleared | Resumed)
    ]


async def test_a_number_stands_in_the_games_place_and_no_press_counts(
    app: ArlApp, link: FakeLink, protocol: Protocol, tmp_path: Path
) -> None:
    async with app.run_test(size=SIZE) as pilot:
        worker = await begin(pilot, link, protocol)
        text = board_text(app)
        assert "Game 1" in text
        assert any(all(line in text for line in big(number)) for number in "123")
        await pilot.press("j")
        assert "not begun" in app.play.feedback.note
        await wait_for_the_game(pilot, app)
        worker.step(0)
        await settle(pilot)
        await pilot.press("j")
        link.say(episode_ended(), session_ended())
        await settle(pilot)
    recording = recorded(tmp_path)
    assert covers(tmp_path) == ["count-down", "resumed"]
    verdicts = [event.verdict for event in recording.events if isinstance(event, KeyPressed) and event.value]
    assert verdicts == ["covered", "accepted"]
    # Nothing that was drawn below the count-down is said to have been on screen.
    (cleared,) = [event for event in recording.events if isinstance(event, ScreenCleared)]
    (resumed,) = [event for event in recording.events if isinstance(event, Resumed)]
    shown = [event.flushed_ns for event in recording.events if isinstance(event, FrameShown)]
    assert shown
    assert not any(cleared.time_ns <= time_ns < resumed.time_ns for time_ns in shown)


async def test_it_comes_again_after_a_pause_and_a_pause_during_it_begins_it_anew(
    app: ArlApp, link: FakeLink, protocol: Protocol, tmp_path: Path
) -> None:
    async with app.run_test(size=SIZE) as pilot:
        worker = await begin(pilot, link, protocol)
        await pilot.press("p")  # during the count-down
        assert isinstance(app.screen, PauseScreen)
        await pilot.press("p")
        await settle(pilot)
        assert isinstance(app.screen, PlayScreen)
        assert app.play.panel.game_widget().covered
        await wait_for_the_game(pilot, app)
        worker.step(0)
        await settle(pilot)
        await pilot.press("p", "p")
        await settle(pilot)
        assert app.play.panel.game_widget().covered
        await wait_for_the_game(pilot, app)
        link.say(episode_ended(), session_ended())
        await settle(pilot)
    assert covers(tmp_path) == [
        *("count-down", "resumed", "pause", "resumed", "count-down", "resumed"),
        *("pause", "resumed", "count-down", "resumed"),
    ]


async def test_between_two_games_there_is_nothing_to_count_down_to(
    app: ArlApp, link: FakeLink, protocol: Protocol, tmp_path: Path
) -> None:
    async with app.run_test(size=SIZE) as pilot:
        worker = await begin(pilot, link, protocol)
        await wait_for_the_game(pilot, app)
        worker.step(0)
        link.say(episode_ended())
        await settle(pilot)
        await pilot.press("p", "p")
        await settle(pilot)
        assert not app.play.panel.game_widget().covered
        link.say(session_ended())
        await settle(pilot)


async def test_stopping_during_the_count_down_ends_it(
    app: ArlApp, link: FakeLink, protocol: Protocol, tmp_path: Path
) -> None:
    async with app.run_test(size=SIZE) as pilot:
        await begin(pilot, link, protocol)
        await pilot.press("q", "y")
        await settle(pilot)
        assert not app.play.panel.game_widget().covered
        link.say(session_ended("participant"))
        await settle(pilot)
    assert covers(tmp_path) == ["count-down", "resumed", "quit-dialogue", "resumed"]


async def test_without_seconds_the_game_begins_at_once(
    link: FakeLink, protocol: Protocol, tmp_path: Path
) -> None:
    screen = msgspec.structs.replace(protocol.screen, count_down_s=0)
    app = app_for(msgspec.structs.replace(protocol, screen=screen), link, tmp_path)
    async with app.run_test(size=SIZE) as pilot:
        await begin(pilot, link, protocol, steps=1)
        assert not app.play.panel.game_widget().covered
        link.say(episode_ended(), session_ended())
        await settle(pilot)
    assert covers(tmp_path) == []


@pytest.mark.parametrize("size", [(80, 24), (120, 40)], ids=str)
def test_the_count_down_looks_as_it_did(
    snap_compare, app: ArlApp, link: FakeLink, protocol: Protocol, size
) -> None:
    async def play(pilot: Pilot[SessionOutcome]) -> None:
        await begin(pilot, link, protocol)
        app.play._count_down.stop()
        app.play.panel.game_widget().cover("\n".join(["Game 1", "", *big("3")]))

    assert snap_compare(app, terminal_size=size, run_before=play)


# --- what a press was taken for -----------------------------------------------------------------------------


@pytest.fixture
def playing(protocol: Protocol, link: FakeLink, tmp_path: Path) -> ArlApp:
    screen = msgspec.structs.replace(protocol.screen, count_down_s=0)
    return app_for(msgspec.structs.replace(protocol, screen=screen), link, tmp_path)


def taken_for(worker: Worker, step: int, *, press: int = 0, value: float = 1.0) -> TakenFor:
    return TakenFor(press=press, value=value, step=step, place=worker.renderer.place_of(step))


async def test_a_press_marks_the_landed_piece_and_is_no_frame(
    playing: ArlApp, link: FakeLink, protocol: Protocol, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr("arl_tui.widgets.board.MARK_S", 0.3)
    app = playing
    async with app.run_test(size=SIZE) as pilot:
        worker = await begin(pilot, link, protocol, steps=2)
        frames = len([e for e in recorded_so_far(app) if isinstance(e, FrameShown)])
        await pilot.press("j")
        link.say(taken_for(worker, 0))
        await settle(pilot)
        assert board_text(app).count("++") == 4
        assert app.play.feedback.note == "Counted for the marked piece"
        for _ in range(40):
            await pilot.pause(0.05)
            if "++" not in board_text(app):
                break
        assert "++" not in board_text(app)
        await settle(pilot)
        assert len([e for e in recorded_so_far(app) if isinstance(e, FrameShown)]) == frames
        # The next step is seen and stamped as ever.
        worker.step(2, column=4)
        await settle(pilot)
        assert len([e for e in recorded_so_far(app) if isinstance(e, FrameShown)]) == frames + 1
        link.say(episode_ended(), session_ended())
        await settle(pilot)


def recorded_so_far(app: ArlApp):
    app.live.collect_frames()
    assert app._recorder is not None
    path = app._recorder.path
    from core.recording.reader import read_recording

    return read_recording(path).events


async def test_taking_a_press_back_takes_the_mark_away(
    playing: ArlApp, link: FakeLink, protocol: Protocol
) -> None:
    async with playing.run_test(size=SIZE) as pilot:
        worker = await begin(pilot, link, protocol, steps=2)
        await pilot.press("f")
        link.say(taken_for(worker, 1, value=-1.0))
        await settle(pilot)
        assert board_text(playing).count("--") == 4
        await pilot.press("u")
        await settle(pilot)
        assert "--" not in board_text(playing)
        link.say(session_ended())
        await settle(pilot)


async def test_a_press_for_nothing_says_so(playing: ArlApp, link: FakeLink, protocol: Protocol) -> None:
    async with playing.run_test(size=SIZE) as pilot:
        await begin(pilot, link, protocol, steps=1)
        await pilot.press("j")
        link.say(TakenFor(press=0, value=1.0, step=-1))
        await settle(pilot)
        assert playing.play.feedback.note == "Counted but no piece had landed"
        link.say(session_ended())
        await settle(pilot)


@pytest.mark.parametrize("size", [(80, 24), (120, 40)], ids=str)
def test_a_marked_piece_looks_as_it_did(
    snap_compare, playing: ArlApp, link: FakeLink, protocol: Protocol, size
) -> None:
    async def play(pilot: Pilot[SessionOutcome]) -> None:
        worker = await begin(pilot, link, protocol, steps=3)
        await pilot.press("j")
        link.say(taken_for(worker, 1))
        await pilot.pause(0.05)

    assert snap_compare(playing, terminal_size=size, run_before=play)
