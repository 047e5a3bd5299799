"""A stopped process, lost focus, another alphabet, output that is not UTF-8: in a real terminal."""

import os
import signal
import time
from pathlib import Path

import numpy as np
import pytest

from core.events import FocusLost, FocusRegained, KeyPressed, ScreenCleared, TimeGap
from core.recording.reader import Recording, read_recording
from core.session.protocol_reading import protocol_from
from core.session.replay import replay_exactly
from core.session.session import build_session
from tests.e2e.processes import worker_of
from tests.e2e.terminal import Terminal

LONG = """
[session]
episodes = 1
unseen_between = 0
watched_steps = 200
[screen]
tick_ms = 60
count_down_s = 0
"""


@pytest.fixture
def play(tmp_path: Path) -> tuple[str, ...]:
    (tmp_path / "long.toml").write_text(LONG)
    return ("play", "tetris", "--seed", "3", "--protocol", str(tmp_path / "long.toml"))


def start(terminal: Terminal) -> None:
    terminal.begin("Game 1")
    terminal.pump(1.0)


def recorded(folder: Path) -> Recording:
    (path,) = (folder / "recordings").glob("*.jsonl")
    return read_recording(path)


def of(recording: Recording, kind: type) -> list:
    return [event for event in recording.inputs if isinstance(event, kind)]


def test_a_stopped_process_pauses_and_nothing_is_credited_across(
    tmp_path: Path, play: tuple[str, ...]
) -> None:
    with Terminal(*play, cwd=tmp_path) as terminal:
        start(terminal)
        os.kill(terminal.child.pid, signal.SIGSTOP)
        time.sleep(2.2)
        terminal.press("j")
        os.kill(terminal.child.pid, signal.SIGCONT)
        terminal.wait_for("so the game has been", patience_s=20)
        terminal.press("p")
        terminal.wait_for("Game 1", patience_s=20)
        terminal.press("\x1b[O")
        terminal.pump(0.4)
        terminal.press("\x1b[I")
        terminal.pump(0.4)
        terminal.press("qy")
        terminal.wait_for("The session is recorded.", patience_s=60)
        terminal.press("\r")
        # The program ends: Textual's own driver would have started a second reader at SIGCONT.
        assert terminal.wait_for_exit(patience_s=30) == 0
    recording = recorded(tmp_path)
    (gap,) = of(recording, TimeGap)
    assert 2.0e9 < gap.time_ns - gap.last_ns < 10e9
    (typed,) = [press for press in of(recording, KeyPressed) if press.key == "j"]
    assert typed.verdict == "covered"
    assert next(event.reason for event in of(recording, ScreenCleared)) == "gap"
    assert len(of(recording, FocusLost)) == len(of(recording, FocusRegained)) == 1
    session = build_session(protocol_from(recording.header.protocol), recording.header.root_seed)
    assert replay_exactly(recording, session).difference is None


@pytest.mark.slow
@pytest.mark.parametrize("seed", range(4))
def test_a_machine_that_stands_still_again_and_again_loses_nothing(
    seed: int, tmp_path: Path, play: tuple[str, ...]
) -> None:
    """Whoever notices first, the timer, a key or the writing thread: the session pauses and goes on."""
    rng, stalls = np.random.default_rng(seed), 24
    (tmp_path / "long.toml").write_text(LONG.replace("episodes = 1", "episodes = 1000"))
    with Terminal(*play, cwd=tmp_path) as terminal:
        start(terminal)
        app, worker = terminal.child.pid, worker_of(terminal.child.pid)
        for _ in range(stalls):
            terminal.pump(rng.uniform(0.2, 1.0))
            stopped = [app, worker] if rng.random() < 0.5 else [app]
            for _ in range(rng.integers(1, 4)):
                for pid in stopped:
                    os.kill(pid, signal.SIGSTOP)
                time.sleep(rng.uniform(1.1, 1.5))
                for pid in stopped:
                    os.kill(pid, signal.SIGCONT)
                time.sleep(rng.choice([0.0005, 0.002, 0.01, 0.03, 0.1, 0.2]))
            terminal.wait_for("so the game has been", patience_s=1.9)
            terminal.press(" ")
            terminal.wait_for("Your feedback", patience_s=20)
        os.kill(app, signal.SIGTERM)
        terminal.wait_for_exit_only()
    recording = recorded(tmp_path)
    assert recording.complete
    assert len(of(recording, TimeGap)) >= stalls


def test_a_session_can_be_played_with_a_keyboard_of_another_alphabet(
    tmp_path: Path, play: tuple[str, ...]
) -> None:
    with Terminal(*play, cwd=tmp_path) as terminal:
        start(terminal)
        terminal.press("\u043e")
        terminal.wait_for("as j: another keyboard", patience_s=20)
        terminal.press("ก")
        terminal.wait_for("Is your keyboard set to Thai", patience_s=20)
        terminal.press("\u0439")
        terminal.wait_for("Stop the session?", patience_s=20)
        terminal.press("\u043d")
        terminal.wait_for("The session is recorded.", patience_s=60)
        terminal.press("\r")
        assert terminal.wait_for_exit(patience_s=30) == 0
    first, *_ = of(recorded(tmp_path), KeyPressed)
    assert (first.key, first.read_as, first.layout, first.value) == ("\u043e", "j", "Russian", 1.0)


@pytest.mark.parametrize(
    "environment",
    [
        pytest.param({"LC_ALL": "C", "PYTHONIOENCODING": "ascii"}, marks=pytest.mark.thorough),
        {"LC_ALL": "C", "PYTHONUTF8": "0", "PYTHONCOERCECLOCALE": "0"},
        pytest.param({"PYTHONIOENCODING": "latin-1"}, marks=pytest.mark.thorough),
    ],
)
def test_the_first_page_is_drawn_whatever_the_environment_says_of_encodings(
    tmp_path: Path, play: tuple[str, ...], environment: dict[str, str]
) -> None:
    with Terminal(*play, cwd=tmp_path, exported=environment) as terminal:
        terminal.wait_for("to start")
        assert "╭" in terminal.text
        assert "?" not in terminal.text
        terminal.press("q")
        assert terminal.wait_for_exit(patience_s=30) == 0
