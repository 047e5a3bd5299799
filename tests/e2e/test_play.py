"""The real app in a pseudo-terminal, with a scripted participant at the other end."""

import os
import signal
import time
from pathlib import Path

import pytest

from core.events import EpisodeEnded, FrameShown, KeyPressed, SessionEnded, StepTaken, StopAsked
from core.recording.reader import Recording, read_recording
from core.session.protocol_reading import protocol_from
from core.session.replay import replay_exactly
from core.session.session import build_session
from tests.e2e.processes import is_running, worker_of
from tests.e2e.terminal import PATIENCE_S, TROUBLE, Terminal

MS = 1_000_000


def play(tmp_path: Path, protocol_file: Path, *more: str) -> Terminal:
    return Terminal(
        "play",
        "tetris",
        "--protocol",
        str(protocol_file),
        "--seed",
        "11",
        "--recordings",
        "r",
        *more,
        cwd=tmp_path,
    )


def start(terminal: Terminal) -> None:
    terminal.begin("Game 1")


def the_recording(tmp_path: Path) -> Recording:
    (path,) = (tmp_path / "r").glob("*.jsonl")
    return read_recording(path)


def replayed(recording: Recording) -> None:
    protocol = protocol_from(recording.header.protocol)
    result = replay_exactly(recording, build_session(protocol, recording.header.root_seed))
    assert result.difference is None, str(result.difference)


def test_a_scripted_participants_presses_are_recorded_at_the_right_step_and_time(
    tmp_path: Path, protocol_file: Path
) -> None:
    written: list[tuple[str, int, int]] = []
    with play(tmp_path, protocol_file) as terminal:
        start(terminal)
        answered = -1
        while terminal.wait_for("Game 1", "Game 2", "Thank you") == "Game 1" and len(written) < 6:
            # No rows are cleared by the first pieces, so the blocks in sight tell which step it is.
            step = terminal.blocks_on_board() // 4 - 1
            if step > answered:
                key = "jfx"[len(written) % 3]
                written.append((key, terminal.press(key), step))
                answered = step
        terminal.wait_for("Thank you")
        terminal.press("\r")
        assert terminal.wait_for_exit() == 0
        assert "Recording: r/" in terminal.text
    recording = the_recording(tmp_path)
    assert recording.complete
    assert len(written) > 2
    presses = [event for event in recording.events if isinstance(event, KeyPressed)][: len(written)]
    assert [press.key for press in presses] == [key for key, _, _ in written]
    # On a busy machine a key may be read late, or before the flush it answers is stamped: not always, and the
    # step is always the one whose flush had been stamped.
    late_ms = [
        (press.time_ns - time_ns) / MS for press, (_, time_ns, _) in zip(presses, written, strict=True)
    ]
    assert min(late_ms) >= 0.0
    assert min(late_ms) < 20.0, late_ms
    assert any(press.step == step for press, (_, _, step) in zip(presses, written, strict=True))
    frames = [event for event in recording.events if isinstance(event, FrameShown)]
    for press in presses:
        assert press.step == [frame.step for frame in frames if frame.flushed_ns <= press.time_ns][-1]
    check_frames(recording)
    replayed(recording)


def check_frames(recording: Recording) -> None:
    """Hold that every step was seen, after it had been decided, and that the stamps are those of flushes."""
    assert recording.header.terminal["stamps"] == "flush"
    frames = [event for event in recording.events if isinstance(event, FrameShown)]
    decided = {event.step: event.time_ns for event in recording.events if isinstance(event, StepTaken)}
    assert {frame.step for frame in frames} == {*decided, -1}
    assert [frame.frame for frame in frames] == list(range(len(frames)))
    times = [frame.flushed_ns for frame in frames]
    assert times == sorted(times)
    for step, decided_ns in decided.items():
        assert min(frame.flushed_ns for frame in frames if frame.step == step) > decided_ns


def test_a_killed_session_loses_nothing_but_the_line_being_written(
    tmp_path: Path, protocol_file: Path
) -> None:
    with play(tmp_path, protocol_file) as terminal:
        start(terminal)
        worker = worker_of(terminal.child.pid)
        terminal.wait_for("Pieces        2")
        terminal.press("j")
        terminal.wait_for("4 of 5 presses left")
        os.kill(terminal.child.pid, signal.SIGKILL)
        terminal.child.wait()
        recording = the_recording(tmp_path)
        assert not recording.complete
        assert [event.key for event in recording.events if isinstance(event, KeyPressed)] == ["j"]
        replayed(recording)
        for _ in range(1200):
            if not is_running(worker):
                return
            time.sleep(0.05)
    raise AssertionError("the worker outlives the screen by more than a minute")


def test_a_worker_that_is_killed_ends_the_session_with_a_message(tmp_path: Path, protocol_file: Path) -> None:
    with play(tmp_path, protocol_file) as terminal:
        start(terminal)
        terminal.wait_for("Pieces        1")
        os.kill(worker_of(terminal.child.pid), signal.SIGKILL)
        terminal.wait_for(TROUBLE)
        assert "signal 9" in terminal.text
        terminal.press("\r")
        assert terminal.wait_for_exit() == 1
    recording = the_recording(tmp_path)
    assert recording.complete
    last = recording.events[-1]
    assert isinstance(last, StopAsked)
    assert last.reason == "worker-died"
    # Nobody heard the stop: what there is replays, and no more is to come.
    replayed(recording)


def test_stopping_in_the_middle_saves_everything(tmp_path: Path, protocol_file: Path) -> None:
    with play(tmp_path, protocol_file) as terminal:
        start(terminal)
        terminal.press("p")
        terminal.wait_for("The game waits for you")
        terminal.press("p")
        terminal.wait_for("Game 1")
        terminal.press("q")
        terminal.wait_for("Stop the session?")
        terminal.press("y")
        terminal.wait_for("Thank you")
        terminal.press("\r")
        assert terminal.wait_for_exit() == 0
    recording = the_recording(tmp_path)
    assert recording.complete
    ended = [event for event in recording.events if isinstance(event, EpisodeEnded)]
    assert [event.ended for event in ended] == ["truncation"]
    assert isinstance(recording.events[-1], SessionEnded)
    replayed(recording)


@pytest.mark.thorough
def test_a_closed_window_ends_session_and_program(tmp_path: Path, protocol_file: Path) -> None:
    with play(tmp_path, protocol_file) as terminal:
        start(terminal)
        terminal.hang_up()
        assert terminal.ends_by_itself(PATIENCE_S)
    recording = the_recording(tmp_path)
    assert recording.complete
    assert isinstance(recording.outputs[-1], SessionEnded)


def test_a_request_to_terminate_saves_the_session_and_ends_the_program(
    tmp_path: Path, protocol_file: Path
) -> None:
    with play(tmp_path, protocol_file) as terminal:
        start(terminal)
        os.kill(terminal.child.pid, signal.SIGTERM)
        terminal.wait_for_exit()
    assert the_recording(tmp_path).complete


def test_play_without_a_terminal_says_what_to_do_instead(tmp_path: Path) -> None:
    from click.testing import CliRunner

    from arl_tui.cli import main

    result = CliRunner().invoke(main, ["play", "tetris", "--recordings", str(tmp_path)])
    assert result.exit_code == 1
    assert "needs a terminal to draw in and a keyboard; try `arl demo`" in result.output


def test_a_console_that_cannot_draw_is_refused(tmp_path: Path) -> None:
    with Terminal("play", "tetris", cwd=tmp_path, exported={"TERM": "dumb"}) as terminal:
        assert terminal.wait_for_exit() == 1
        assert "this one cannot draw (TERM=dumb" in " ".join(terminal.received.decode().split())
        assert b"\x1b" not in terminal.received


PRACTISED = """
[session]
episodes = 1
unseen_between = 0
watched_steps = 6

[screen]
tick_ms = 100
count_down_s = 0
pause_between_episodes_s = 0.3
"""


@pytest.mark.thorough
def test_practice_ends_when_both_keys_were_pressed_on_time_and_the_session_follows(tmp_path: Path) -> None:
    """Both are recorded, in a file each, and both are replayed exactly."""
    protocol_file = tmp_path / "practised.toml"
    protocol_file.write_text(PRACTISED)
    with play(tmp_path, protocol_file, "--practice") as terminal:
        terminal.wait_for("Practice: nothing counts")
        start(terminal)
        for key, word in (("j", "4 of 5"), ("f", "3 of 5")):
            terminal.wait_for("Pieces        2", "Pieces        4")
            terminal.press(key)
            terminal.wait_for(f"{word} presses left")
            terminal.wait_for("Pieces        4", "That was the practice")
        terminal.wait_for("That was the practice")
        terminal.wait_for("good 1, bad 1")
        terminal.wait_for("You watched 1 game")
        terminal.wait_for("Enter  to go on")
        terminal.press("\r")
        terminal.wait_for("to start, ")
        assert "Practice" not in terminal.text
        start(terminal)
        terminal.wait_for("Thank you")
        terminal.press("\r")
        assert terminal.wait_for_exit() == 0
    practice, session = (read_recording(path) for path in sorted((tmp_path / "r").glob("*.jsonl")))
    assert practice.header.source["purpose"] == "practice: it does not count"
    assert practice.outputs[-1].reason == "practised"
    assert session.outputs[-1].reason == "finished"
    assert practice.header.root_seed != session.header.root_seed
    for recording in (practice, session):
        replayed(recording)
