"""A terminal that goes away, stalls or sends nonsense; and signals: the session ends, and says how, or goes
on."""

import os
import signal
import termios
import time
from pathlib import Path

import pytest

from core.events import KeyPressed, SessionEnded, StopAsked
from core.recording.reader import Recording, read_recording
from tests.e2e.processes import descendants, left_after, worker_of
from tests.e2e.terminal import Terminal
from tests.e2e.two_ends import TwoEnds

ENDS_WITHIN_S = 2.0
"""After its terminal has closed, a program has this long to write how the session ended, and to leave."""
ANSWERS_WITHIN_S = 30.0
RESET = ("\x1b[?1049l", "\x1b[?25h", "\x1b[?1004l", "\x1b[?2004l")
"""Alternate screen, cursor, focus reports, bracketed paste."""

ARGUMENTS = {
    "demo": ("demo", "--seed", "11", "--recordings", "r"),
    "practice": ("practice", "--seed", "3"),
    "watch": ("watch", "keepaway", "--seed", "3"),
    "calibrate": ("calibrate", "--participant", "P01", "--tasks", "simple", "--recordings", "r"),
}
"""Arguments of the commands, without a session of one's own."""
READY = {"demo": "Enter  to start, ", "practice": "to leave", "watch": "quit", "calibrate": "Enter"}
BY_DEFAULT = {"demo": "window", "practice": "input", "watch": "output", "calibrate": "both"}
"""Each command and each end once; every pair by name (`-m slow`)."""
EVERY_END = [
    pytest.param(
        command, closed, id=f"{command}-{closed}", marks=[] if by_default == closed else [pytest.mark.slow]
    )
    for command, by_default in BY_DEFAULT.items()
    for closed in ("input", "output", "both", "window")
]


@pytest.fixture
def long_file(protocol_file: Path) -> Path:
    """A session that is still on when a busy machine comes to look at it."""
    text = protocol_file.read_text().replace("unseen_between = 4", "unseen_between = 0")
    path = protocol_file.with_name("long.toml")
    path.write_text(
        text.replace("episodes = 2", "episodes = 40").replace("watched_steps = 7", "watched_steps = 500")
    )
    return path


def play_arguments(protocol_file: Path) -> tuple[str, ...]:
    return ("play", "tetris", "--protocol", str(protocol_file), "--seed", "11", "--recordings", "r")


def play(tmp_path: Path, protocol_file: Path) -> Terminal:
    return Terminal(*play_arguments(protocol_file), cwd=tmp_path)


def start(terminal: Terminal | TwoEnds) -> None:
    terminal.begin(*(f"Pieces        {pieces}" for pieces in range(1, 10)))


def the_recording(tmp_path: Path) -> Recording:
    (path,) = (tmp_path / "r").glob("*.jsonl")
    return read_recording(path)


def stop_reason(recording: Recording) -> str:
    (stop,) = [event for event in recording.events if isinstance(event, StopAsked)]
    return stop.reason


@pytest.mark.parametrize("repetition", [0, *(pytest.param(n, marks=pytest.mark.slow) for n in (1, 2))])
def test_a_closed_terminal_ends_a_session_which_says_so(
    repetition: int, tmp_path: Path, long_file: Path
) -> None:
    with play(tmp_path, long_file) as terminal:
        start(terminal)
        terminal.press("j")
        terminal.wait_for("4 of 5 presses left")
        time.sleep(0.1 * repetition)
        family = {terminal.child.pid, *descendants(terminal.child.pid)}
        assert len(family) >= 3  # the app, its worker, and the guard of the terminal
        terminal.hang_up()
        assert terminal.ends_by_itself(ENDS_WITHIN_S)
        assert left_after(family, ENDS_WITHIN_S) == set()
    recording = the_recording(tmp_path)
    assert recording.complete
    assert stop_reason(recording) == "window-closed"
    assert isinstance(recording.outputs[-1], SessionEnded)


@pytest.mark.thorough
@pytest.mark.parametrize("closed", ["input", "output", "both"])
def test_a_session_of_which_one_end_closes_ends(closed: str, tmp_path: Path, long_file: Path) -> None:
    with TwoEnds(*play_arguments(long_file), cwd=tmp_path) as program:
        start(program)
        family = descendants(program.process.pid)
        program.close(closed)
        assert program.seconds_to_end() < ENDS_WITHIN_S
        assert left_after(family, ENDS_WITHIN_S) == set()
        shown = program.received.decode(errors="replace")
    recording = the_recording(tmp_path)
    assert recording.complete
    assert stop_reason(recording) == "window-closed"
    if closed == "input":
        # Somebody still looks at the screen: it is left usable.
        assert all(shown.rfind(code) > shown.rfind("\x1b[?1049h") for code in RESET)
        assert "unexpectedly" not in shown


@pytest.mark.parametrize(("command", "closed"), EVERY_END)
def test_every_command_ends_with_its_terminal(command: str, closed: str, tmp_path: Path) -> None:
    if closed == "window":
        with Terminal(*ARGUMENTS[command], cwd=tmp_path) as terminal:
            terminal.wait_for(READY[command])
            family = {terminal.child.pid, *descendants(terminal.child.pid)}
            terminal.hang_up()
            assert terminal.ends_by_itself(ENDS_WITHIN_S)
    else:
        with TwoEnds(*ARGUMENTS[command], cwd=tmp_path) as program:
            program.wait_for(READY[command])
            family = descendants(program.process.pid)
            program.close(closed)
            assert program.seconds_to_end() < ENDS_WITHIN_S
    assert left_after(family, ENDS_WITHIN_S) == set()


@pytest.mark.thorough
def test_a_terminal_that_nobody_reads_does_not_keep_a_session_from_ending(
    tmp_path: Path, long_file: Path
) -> None:
    with play(tmp_path, long_file) as terminal:
        start(terminal)
        time.sleep(4.0)  # nothing is read: the terminal's buffer fills up, and the writing thread blocks
        os.kill(terminal.child.pid, signal.SIGTERM)
        assert terminal.ends_by_itself(ENDS_WITHIN_S + 1.0)
    assert the_recording(tmp_path).complete


@pytest.mark.parametrize("number", [pytest.param(signal.SIGINT, marks=pytest.mark.thorough), signal.SIGTERM])
def test_a_signal_ends_the_session_and_the_terminal_is_as_before(
    number: signal.Signals, tmp_path: Path, long_file: Path
) -> None:
    with play(tmp_path, long_file) as terminal:
        before = termios.tcgetattr(terminal.child.child_fd)
        start(terminal)
        assert termios.tcgetattr(terminal.child.child_fd) != before
        for _ in range(50):
            os.kill(terminal.child.pid, number)
        assert terminal.wait_for_exit_only() == 128 + number
        assert termios.tcgetattr(terminal.child.child_fd) == before
        assert "Recording: r/" in terminal.text
        assert "Traceback" not in terminal.text
    recording = the_recording(tmp_path)
    assert recording.complete
    assert stop_reason(recording) == "signal"


@pytest.mark.thorough
def test_several_signals_in_a_row_end_the_session_once(tmp_path: Path, long_file: Path) -> None:
    with play(tmp_path, long_file) as terminal:
        start(terminal)
        for number in (signal.SIGTERM, signal.SIGHUP, signal.SIGINT):
            os.kill(terminal.child.pid, number)
        terminal.wait_for_exit_only()
    assert the_recording(tmp_path).complete


def test_a_stop_from_outside_leaves_the_terminal_as_it_was_in_the_end(
    tmp_path: Path, long_file: Path
) -> None:
    with play(tmp_path, long_file) as terminal:
        before = termios.tcgetattr(terminal.child.child_fd)
        start(terminal)
        raw = termios.tcgetattr(terminal.child.child_fd)
        os.kill(terminal.child.pid, signal.SIGSTOP)
        time.sleep(0.5)
        termios.tcsetattr(terminal.child.child_fd, termios.TCSANOW, before)  # as a shell does
        os.kill(terminal.child.pid, signal.SIGCONT)
        end = time.monotonic() + ANSWERS_WITHIN_S
        while termios.tcgetattr(terminal.child.child_fd) != raw and time.monotonic() < end:
            terminal.pump()
        assert termios.tcgetattr(terminal.child.child_fd) == raw
        os.kill(terminal.child.pid, signal.SIGTERM)
        terminal.wait_for_exit_only()
        assert termios.tcgetattr(terminal.child.child_fd) == before
    assert the_recording(tmp_path).complete


@pytest.mark.parametrize("number", [signal.SIGKILL, signal.SIGSEGV])
def test_a_program_that_crashes_leaves_a_terminal_that_can_be_used(
    number: signal.Signals, tmp_path: Path, long_file: Path
) -> None:
    with Terminal(*play_arguments(long_file), cwd=tmp_path, in_shell=True) as terminal:
        before = termios.tcgetattr(terminal.child.child_fd)
        start(terminal)
        family = descendants(terminal.pid)
        os.kill(terminal.pid, number)
        terminal.wait_for("arl ended unexpectedly", patience_s=ANSWERS_WITHIN_S)
        terminal.drain(0.3)
        assert termios.tcgetattr(terminal.child.child_fd) == before
        shown = terminal.received.decode(errors="replace")
        assert all(shown.rfind(code) > shown.rfind("\x1b[?1049h") for code in RESET)
        if number == signal.SIGSEGV:
            assert "Fatal Python error" in shown
        assert left_after(family, 2.0) == set()
    assert not the_recording(tmp_path).complete


@pytest.mark.parametrize(
    "noise",
    [
        b"\xe9",  # a Latin-1 key
        pytest.param(b"\x1b[M\x20\xf0\xf1", marks=pytest.mark.thorough),  # a mouse report beyond column 95
        pytest.param(b"\xff\xfe\x80\x00\xc3(\xa0\xa1", marks=pytest.mark.thorough),  # line noise
    ],
    ids=["latin-1", "mouse", "noise"],
)
def test_bytes_that_are_not_utf_8_are_keys_without_a_meaning(
    noise: bytes, tmp_path: Path, long_file: Path
) -> None:
    with play(tmp_path, long_file) as terminal:
        start(terminal)
        os.write(terminal.child.child_fd, noise)
        time.sleep(0.5)
        terminal.press("j")
        terminal.wait_for("4 of 5 presses left", patience_s=ANSWERS_WITHIN_S)
        assert b"\x1b[?1000h" not in terminal.received
        os.kill(terminal.child.pid, signal.SIGTERM)
        terminal.wait_for_exit_only()
    presses = [event for event in the_recording(tmp_path).events if isinstance(event, KeyPressed)]
    assert [press.key for press in presses if press.verdict == "accepted"] == ["j"]
    # A whole mouse report is understood as one, and is no key.
    assert any(press.verdict == "other" for press in presses) or noise.startswith(b"\x1b[M")


@pytest.mark.thorough
def test_a_learner_that_hangs_is_reported_and_the_session_can_be_ended(
    tmp_path: Path, long_file: Path
) -> None:
    with play(tmp_path, long_file) as terminal:
        start(terminal)
        worker = worker_of(terminal.child.pid)
        os.kill(worker, signal.SIGSTOP)
        terminal.wait_for("has not answered for", patience_s=ANSWERS_WITHIN_S)
        assert "Q ends the session" in terminal.text
        terminal.press("q")
        terminal.wait_for("Stop the session?")
        terminal.press("y")
        terminal.wait_for("had to end early", patience_s=ANSWERS_WITHIN_S)
        terminal.press("\r")
        assert terminal.wait_for_exit() == 1
        assert left_after({worker}, 1.0) == set()
    recording = the_recording(tmp_path)
    assert recording.complete
    assert stop_reason(recording) == "participant"


@pytest.mark.thorough
def test_a_learner_that_answers_again_is_no_longer_reported(tmp_path: Path, protocol_file: Path) -> None:
    with play(tmp_path, protocol_file) as terminal:
        start(terminal)
        worker = worker_of(terminal.child.pid)
        os.kill(worker, signal.SIGSTOP)
        terminal.wait_for("has not answered for", patience_s=ANSWERS_WITHIN_S)
        os.kill(worker, signal.SIGCONT)
        terminal.wait_for("Thank you", patience_s=ANSWERS_WITHIN_S)
        assert "has not answered" not in terminal.text
