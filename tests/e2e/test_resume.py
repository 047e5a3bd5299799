"""`arl play --resume`: a real session breaks off, and goes on in a new file."""

import os
import signal
from collections.abc import Callable
from pathlib import Path

import pytest

from core.events import EpisodeEnded, KeyPressed, SessionEnded
from core.recording.joined import read_session
from core.recording.summary import summarise_recording
from core.session.protocol_reading import protocol_from
from core.session.replay import replay_exactly
from core.session.session import build_session
from tests.e2e.processes import descendants, left_after
from tests.e2e.terminal import START, Terminal


def kill(terminal: Terminal) -> None:
    os.kill(terminal.child.pid, signal.SIGKILL)


def close_the_window(terminal: Terminal) -> None:
    terminal.hang_up()
    assert terminal.ends_by_itself(10.0)


def stop(terminal: Terminal) -> None:
    terminal.press("q")
    terminal.wait_for("Stop here?", "stop")
    terminal.press("y")
    terminal.wait_for("Thank you")
    terminal.press("\r")
    assert terminal.wait_for_exit() == 0


ENDS = (kill, close_the_window, stop)


def watch_game_2(terminal: Terminal) -> None:
    """Press once in the second game."""
    terminal.wait_for("Game 2")
    terminal.pump(0.5)
    terminal.press("f")
    terminal.pump(0.3)


def break_off(terminal: Terminal, end: Callable[[Terminal], None]) -> None:
    """Break a session off in its second game."""
    watch_game_2(terminal)
    pids = descendants(terminal.child.pid)
    end(terminal)
    assert not left_after(pids, 10.0)


@pytest.mark.thorough
def test_a_session_that_broke_off_in_its_second_game_three_times_goes_on(
    tmp_path: Path, protocol_file: Path
) -> None:
    recordings = tmp_path / "recordings"
    arguments = ("play", "tetris", "--protocol", str(protocol_file), "--seed", "11", "--participant", "P07")
    with Terminal(*arguments, cwd=tmp_path) as terminal:
        terminal.begin("Game 1")
        terminal.pump(0.8)
        terminal.press("j")
        break_off(terminal, ENDS[0])
    files = list(recordings.glob("*.jsonl"))
    assert len(files) == 1
    before = {files[0]: files[0].read_bytes()}

    for end in (*ENDS[1:], None):
        with Terminal("play", "--resume", str(files[-1]), cwd=tmp_path) as terminal:
            terminal.wait_for(START)
            assert "1 of 2 games" in terminal.text
            terminal.begin("Game 2")
            if end is not None:
                break_off(terminal, end)
            else:
                watch_game_2(terminal)
                terminal.wait_for("Thank you")
                terminal.press("\r")
                assert terminal.wait_for_exit() == 0
        files += set(recordings.glob("*.jsonl")) - set(files)
        before[files[-1]] = files[-1].read_bytes()
    assert len(files) == 4
    assert {path: path.read_bytes() for path in files} == before

    is_one_session(files[-1])
    is_told_of_by_commands(tmp_path, files)


def is_one_session(last: Path) -> None:
    """Check that the last of four files tells the whole session, and that it replays exactly."""
    session = read_session(last)
    assert len(session.older) == 3
    assert session.header.participant == "P07"
    assert (
        replay_exactly(
            session, build_session(protocol_from(session.header.protocol), session.header.root_seed)
        ).difference
        is None
    )
    assert summarise_recording(session).games_finished == 2
    assert len([event for event in session.events if isinstance(event, EpisodeEnded)]) == 2
    assert isinstance(session.events[-1], SessionEnded)
    numbers = [event.press for event in session.events if isinstance(event, KeyPressed)]
    assert numbers == list(range(len(numbers)))


def is_told_of_by_commands(folder: Path, files: list[Path]) -> None:
    """Check what `arl play --resume`, `arl replay` and `arl recordings` say of the files, in their order."""
    first, last = files[0], files[-1]
    for arguments, words in (
        (("play", "--resume", str(first)), f"{files[1]} goes on with it already"),
        (("play", "--resume", str(last)), "this session is finished"),
        (("play", "--resume", str(last), "--seed", "3"), "leave out --seed"),
    ):
        with Terminal(*arguments, cwd=folder, columns=300) as terminal:
            assert terminal.wait_for_exit() != 0
            assert words in terminal.text.replace("\n", ""), terminal.text
    with Terminal("replay", str(last), cwd=folder, columns=200) as terminal:
        assert terminal.wait_for_exit() == 0
        assert "Replay: exact" in terminal.text
        assert "the weights bit for bit" in terminal.text
    with Terminal("recordings", cwd=folder, columns=200, lines=50) as terminal:
        assert terminal.wait_for_exit() == 0
        assert all(f"goes on with {path.name}" in terminal.text for path in files[:-1])
        assert "0 damaged" in terminal.text
