"""`arl demo`, which is the first thing anybody runs."""

import subprocess
import sys
from pathlib import Path

import pytest

from core.events import KeyPressed
from core.recording.reader import read_recording
from tests.e2e.terminal import Terminal


def the_only_recording(folder: Path) -> Path:
    (path,) = folder.glob("*.jsonl")
    return path


@pytest.mark.parametrize(
    ("game", "games"), [pytest.param("tetris", 3, marks=pytest.mark.thorough), ("keepaway", 5)]
)
def test_without_a_terminal_it_plays_records_replays_and_summarises(
    tmp_path: Path, game: str, games: int
) -> None:
    done = subprocess.run(
        [sys.executable, "-m", "arl_tui.cli", "demo", game, "--seed", "3", "--recordings", str(tmp_path)],
        capture_output=True,
        text=True,
        stdin=subprocess.DEVNULL,
        check=False,
    )
    assert done.returncode == 0, done.stderr
    path = the_only_recording(tmp_path)
    assert str(path) in done.stdout
    assert "Replay: exact" in done.stdout
    assert f"Games watched: {games}" in done.stdout
    recording = read_recording(path)
    assert recording.complete
    assert recording.header.origin == "simulated"
    presses = [event for event in recording.events if isinstance(event, KeyPressed)]
    assert f"Presses that counted: {sum(press.verdict == 'accepted' for press in presses)}" in done.stdout
    assert {press.source for press in presses} == {"simulated"}


@pytest.mark.slow
def test_in_a_terminal_it_takes_about_a_minute_and_a_person_may_press_too(tmp_path: Path) -> None:
    with Terminal("demo", "--seed", "3", "--recordings", "r", cwd=tmp_path, lines=50) as terminal:
        terminal.wait_for("Q  to leave")
        assert "simulated person" in terminal.text
        terminal.press("\r")
        terminal.wait_for("Game 2")
        terminal.press("j")
        terminal.wait_for("Thank you")
        terminal.press("\r")
        assert terminal.wait_for_exit() == 0
        assert "Replay: exact" in terminal.text
        assert "Weight of the participant in the last game" in terminal.text
    recording = read_recording(the_only_recording(tmp_path / "r"))
    assert recording.complete
    presses = [event for event in recording.events if isinstance(event, KeyPressed)]
    assert {"participant", "simulated"} == {press.source for press in presses}
    first, last = recording.outputs[0], recording.outputs[-1]
    assert 40e9 < last.time_ns - first.time_ns < 100e9  # type: ignore[union-attr]
