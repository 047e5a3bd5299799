"""`arl play --resume`: a real session breaks off, and goes on in a new file."""

import os
import signal
from pathlib import Path

import pytest

from core.events import EpisodeEnded, KeyPressed, SessionEnded
from core.recording.joined import read_session
from core.recording.summary import summarise_recording
from core.session.protocol_reading import protocol_from
from core.session.replay import replay_exactly
from core.session.session import build_session
from tests.e2e.processes import descendants, left_after
from tests.e2e.terminal import Terminal


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


@pytest.mark.parametrize(
    "end",
    [
        kill,
        pytest.param(close_the_window, marks=pytest.mark.slow),
        pytest.param(stop, marks=pytest.mark.slow),
    ],
)
def test_a_session_that_broke_off_in_its_second_game_goes_on(
    end, tmp_path: Path, protocol_file: Path
) -> None:
    arguments = ("play", "tetris", "--protocol", str(protocol_file), "--seed", "11", "--participant", "P07")
    with Terminal(*arguments, cwd=tmp_path) as terminal:
        terminal.start()
        terminal.pump(0.8)
        terminal.press("j")
        terminal.wait_for("Game 2")
        terminal.pump(0.5)
        terminal.press("f")
        terminal.pump(0.3)
        pids = descendants(terminal.child.pid)
        end(terminal)
        assert not left_after(pids, 10.0)
    (first,) = (tmp_path / "recordings").glob("*.jsonl")
    before = first.read_bytes()

    with Terminal("play", "--resume", str(first), cwd=tmp_path) as terminal:
        terminal.wait_for("Enter  to ")
        assert "1 of 2 games" in terminal.text
        terminal.press("\r")
        terminal.wait_for("Game 2")
        terminal.pump(0.5)
        terminal.press("j")
        terminal.wait_for("Thank you")
        terminal.press("\r")
        assert terminal.wait_for_exit() == 0
    assert first.read_bytes() == before
    (second,) = set((tmp_path / "recordings").glob("*.jsonl")) - {first}
    session = read_session(second)
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

    for arguments, words in (
        (("play", "--resume", str(first)), f"{second} goes on with it already"),
        (("play", "--resume", str(second)), "this session is finished"),
        (("play", "--resume", str(second), "--seed", "3"), "leave out --seed"),
    ):
        with Terminal(*arguments, cwd=tmp_path, columns=300) as terminal:
            assert terminal.wait_for_exit() != 0
            assert words in terminal.text.replace("\n", ""), terminal.text
    with Terminal("replay", str(second), cwd=tmp_path, columns=200) as terminal:
        assert terminal.wait_for_exit() == 0
        assert "Replay: exact" in terminal.text
        assert "the weights bit for bit" in terminal.text
    with Terminal("recordings", cwd=tmp_path, columns=200) as terminal:
        assert terminal.wait_for_exit() == 0
        assert f"goes on with {first.name}" in terminal.text
        assert "1 sound, 0 damaged" in terminal.text
