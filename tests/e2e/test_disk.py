"""A disk that is slow, full or gone: what the screen confirms is in the file, and what is not is named."""

import os
import re
import resource
import shutil
import time
from pathlib import Path

import pytest

from core.events import StopAsked
from core.recording.reader import Recording, read_recording
from core.system.private_files import FILE_MODE, FOLDER_MODE
from tests.e2e.confirmed import Confirmed, accepted
from tests.e2e.terminal import TROUBLE, Terminal

PROTOCOL = """
name = "long"

[session]
episodes = 4
unseen_between = 4
unseen_steps = 50
watched_steps = 300

[screen]
tick_ms = 150
pause_between_episodes_s = 0.3

[keys]
max_presses_per_episode = 60
"""
TOLD_WITHIN_S = 1.0
SLOW_DISK = """
import os, time
sync, calls = os.fsync, 0
def slow(descriptor):
    global calls
    calls += 1
    time.sleep({first_s} if calls <= {n_first} else {then_s})
    sync(descriptor)
os.fsync = slow
"""


def play(tmp_path: Path, *, slow: str | None = None) -> Terminal:
    (tmp_path / "long.toml").write_text(PROTOCOL)
    exported = {}
    if slow is not None:
        (tmp_path / "site").mkdir()
        (tmp_path / "site" / "sitecustomize.py").write_text(slow)
        exported["PYTHONPATH"] = os.pathsep.join([str(tmp_path / "site"), os.environ.get("PYTHONPATH", "")])
    (tmp_path / "t").mkdir()
    exported["TMPDIR"] = str(tmp_path / "t")
    terminal = Terminal(
        "play", "tetris", "--protocol", "long.toml", "--seed", "3", "--recordings", "r/s", cwd=tmp_path,
        exported=exported,
    )  # fmt: skip
    terminal.begin("Pieces        1", "Pieces        2")
    return terminal


def the_file(tmp_path: Path) -> Path:
    (path,) = (tmp_path / "r" / "s").glob("*.jsonl")
    return path


def press_until_confirmed(terminal: Terminal, confirmed: Confirmed, n_presses: int, within_s: float) -> None:
    """Press a key so many times, each when the one before is confirmed."""
    for number in range(n_presses):
        wanted = sum(confirmed.presses.values()) + 1
        terminal.press("jf"[number % 2])
        end = time.monotonic() + within_s
        while sum(confirmed.presses.values()) < wanted:
            assert time.monotonic() < end, f"press {number} is not confirmed:\n{terminal.text}"
            terminal.pump(0.02)
            confirmed.look(terminal)
        terminal.pump(0.12)


def presses_in(recording: Recording) -> int:
    return sum(accepted(recording).values())


@pytest.mark.parametrize("delay_ms", [0, *(pytest.param(ms, marks=pytest.mark.thorough) for ms in (50, 400))])
def test_what_the_screen_has_confirmed_is_in_the_file_however_slow_the_disk_is(
    delay_ms: int, tmp_path: Path
) -> None:
    slow = SLOW_DISK.format(n_first=0, first_s=0, then_s=delay_ms / 1000)
    with play(tmp_path, slow=slow) as terminal:
        confirmed = Confirmed()
        confirmed.look(terminal)
        for _ in range(8):
            press_until_confirmed(terminal, confirmed, 1, within_s=10.0)
            # What was confirmed on the screen a moment ago is in the file now.
            assert confirmed.missing_from(read_recording(the_file(tmp_path))) == {}
        terminal.child.kill(9)
        terminal.drain()
    assert confirmed.missing_from(read_recording(the_file(tmp_path))) == {}


@pytest.mark.thorough
def test_a_disk_that_hangs_is_reported_and_the_closing_page_says_what_is_known_to_be_on_it(
    tmp_path: Path,
) -> None:
    slow = SLOW_DISK.format(n_first=4, first_s=0, then_s=40)
    with play(tmp_path, slow=slow) as terminal:
        confirmed = Confirmed()
        confirmed.look(terminal)
        press_until_confirmed(terminal, confirmed, 10, within_s=10.0)
        terminal.wait_for("saving ...", patience_s=10.0)
        terminal.press("q")
        terminal.wait_for("Stop the session?")
        terminal.press("y")
        terminal.wait_for(TROUBLE, patience_s=30.0)
        assert "known to be on the disk" in terminal.text
        told = re.search(r"(\d+) of (\d+) events are known", terminal.text)
        assert told is not None
        assert int(told[1]) < int(told[2])
        terminal.press("\r")
        assert terminal.wait_for_exit() == 1
    recording = read_recording(the_file(tmp_path))
    assert presses_in(recording) == 10
    assert recording.complete


def test_a_full_disk_is_told_within_a_second_and_nothing_is_confirmed_any_more(tmp_path: Path) -> None:
    with play(tmp_path) as terminal:
        confirmed = Confirmed()
        confirmed.look(terminal)
        press_until_confirmed(terminal, confirmed, 3, within_s=10.0)
        full_at = the_file(tmp_path).stat().st_size + 100  # in the middle of a line
        resource.prlimit(terminal.child.pid, resource.RLIMIT_FSIZE, (full_at, full_at))
        before = sum(confirmed.presses.values())
        for _ in range(5):
            terminal.press("j")
            terminal.pump(0.12)
            confirmed.look(terminal)
        terminal.wait_for("cannot be written", TROUBLE, patience_s=TOLD_WITHIN_S)
        terminal.wait_for(TROUBLE, patience_s=20.0)
        assert "File too large" in terminal.text
        assert "KeyPressed" in terminal.text  # what could not be written is named
        terminal.press("\r")
        terminal.drain()
    path = the_file(tmp_path)
    recording = read_recording(path)  # no line is torn
    assert path.read_bytes().endswith(b"\n")
    written = presses_in(recording)
    (rest,) = (tmp_path / "t").glob("*-unwritten-*.jsonl")
    unwritten = [line for line in rest.read_text().splitlines() if '"key-pressed"' in line]
    stopped = '"disk-failed"' in rest.read_text()
    assert stopped
    # The press that did not fit is in the rest, and the screen has confirmed those in the file only.
    assert written >= before
    assert unwritten
    assert sum(confirmed.presses.values()) <= written
    assert rest.stat().st_mode & 0o777 == FILE_MODE


@pytest.mark.thorough
def test_a_folder_that_is_deleted_is_told_within_a_second_and_the_recording_is_saved_elsewhere(
    tmp_path: Path,
) -> None:
    with play(tmp_path) as terminal:
        confirmed = Confirmed()
        confirmed.look(terminal)
        press_until_confirmed(terminal, confirmed, 3, within_s=10.0)
        shutil.rmtree(tmp_path / "r")
        terminal.wait_for("cannot be written", TROUBLE, patience_s=TOLD_WITHIN_S)
        terminal.wait_for(TROUBLE, patience_s=20.0)
        terminal.press("\r")
        assert terminal.wait_for_exit() == 1
    (saved,) = (tmp_path / "t").glob("*-rescued-*.jsonl")
    recording = read_recording(saved)
    assert recording.complete
    assert presses_in(recording) == 3
    (stop,) = [event for event in recording.events if isinstance(event, StopAsked)]
    assert stop.reason == "disk-failed"


@pytest.mark.thorough
def test_a_folder_made_read_only_takes_the_rest_of_the_open_recording(tmp_path: Path) -> None:
    with play(tmp_path) as terminal:
        confirmed = Confirmed()
        confirmed.look(terminal)
        (tmp_path / "r" / "s").chmod(0o500)
        press_until_confirmed(terminal, confirmed, 3, within_s=10.0)
        terminal.press("q")
        terminal.wait_for("Stop the session?")
        terminal.press("y")
        terminal.wait_for("Thank you")
        terminal.press("\r")
        assert terminal.wait_for_exit() == 0
    (tmp_path / "r" / "s").chmod(0o700)
    assert presses_in(read_recording(the_file(tmp_path))) == 3


def test_files_of_a_participant_are_private(tmp_path: Path) -> None:
    with play(tmp_path) as terminal:
        assert the_file(tmp_path).stat().st_mode & 0o777 == FILE_MODE
        for folder in (tmp_path / "r", tmp_path / "r" / "s"):
            assert folder.stat().st_mode & 0o777 == FOLDER_MODE
        for log in (tmp_path / "t").iterdir():
            assert log.stat().st_mode & 0o777 == FILE_MODE
        terminal.child.kill(9)
        terminal.drain()
