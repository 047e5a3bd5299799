"""Several robot participants at once on one machine: no key is lost, and each press meets its step.

Two robots for some seconds by default. By name: `pytest -n 0 -s -m slow tests/e2e/test_robots.py`: 1, 5, 10
and 20 robots for 45 s each (ARL_ROBOTS_S), with frame rates and delays.
"""

import os
import statistics
import time
from contextlib import ExitStack
from pathlib import Path

import numpy as np
import pytest

from core.events import FrameShown, KeyPressed
from core.numerics.clock import NS_PER_S
from core.recording.reader import Recording, read_recording
from core.session.protocol_reading import protocol_from
from core.session.replay import replay_exactly
from core.session.session import build_session
from tests.e2e.growing import Growing
from tests.e2e.terminal import PATIENCE_S, Terminal

MS = 1_000_000
PROTOCOL = """
name = "robots"

[session]
episodes = 1000
unseen_between = 2
unseen_steps = 30
watched_steps = 60

[keys]
max_presses_per_episode = 1000

[screen]
tick_ms = 33
count_down_s = 0
pause_between_episodes_s = 0.3
"""
MEAN_PAUSE_S = 0.5
"""Between two keys of a robot."""
LATEST_S = 30.0
"""A key that is not in the file by then is lost."""


class Robot:
    """A session in a terminal, and the one who presses keys in it."""

    def __init__(self, number: int, tmp_path: Path) -> None:
        self.folder = tmp_path / str(number)
        self.folder.mkdir()
        (self.folder / "robots.toml").write_text(PROTOCOL)
        arguments = ("play", "tetris", "--protocol", "robots.toml", "--seed", str(number))
        self.terminal = Terminal(*arguments, "--recordings", "r", cwd=self.folder)
        self.rng = np.random.default_rng(number)
        self.written: list[tuple[str, int]] = []
        self.to_file_ms: list[float] = []
        self.began_ns = 0
        self._asked = self._started = False
        self._growing: Growing | None = None
        self._due = 0.0

    @property
    def path(self) -> Path:
        (path,) = (self.folder / "r").glob("*.jsonl")
        return path

    def get_ready(self) -> bool:
        """Go on towards the first game; return whether it is on screen."""
        if not self._started:
            self.terminal.pump(0.02)
            text = self.terminal.text
            self._started = "Game 1" in text
            if not self._started and ("Ready. " in text or (not self._asked and "Enter  to start, " in text)):
                self._asked = True
                self.terminal.press("\r")
                self.terminal.pump(0.5)
        return self._started

    def begin(self) -> None:
        """Begin to press keys."""
        file = self.path.open("rb")
        file.seek(0, os.SEEK_END)
        self._growing = Growing(file)
        self.began_ns = time.monotonic_ns()

    @property
    def n_on_the_way(self) -> int:
        """How many keys have been pressed and are not in the file yet."""
        return len(self.written) - len(self.to_file_ms)

    def look(self, *, presses: bool = True) -> None:
        """Read the screen's bytes, note the keys that have reached the file, and press what is due."""
        self.terminal.discard(0.0005)
        assert self._growing is not None, "begun before"
        now_ns = time.monotonic_ns()
        lines = self._growing.new_presses()
        for _ in range(sum(b'"key":"j"' in line or b'"key":"f"' in line for line in lines)):
            _, pressed_ns = self.written[len(self.to_file_ms)]
            self.to_file_ms.append((now_ns - pressed_ns) / MS)
        if presses and time.monotonic() >= self._due:
            key = "jf"[self.rng.integers(2)]
            self.written.append((key, self.terminal.press(key)))
            self._due = time.monotonic() + self.rng.exponential(MEAN_PAUSE_S)

    def end(self) -> None:
        """Ask the session to end."""
        assert self._growing is not None, "begun before"
        self._growing.close()
        self.terminal.child.kill(15)


def run(n: int, duration_s: float, tmp_path: Path) -> list[Robot]:
    """Let so many robots play at once."""
    with ExitStack() as stack:
        robots = [Robot(number, tmp_path) for number in range(n)]
        for robot in robots:
            stack.enter_context(robot.terminal)
        until = time.monotonic() + PATIENCE_S
        while not_ready := [robot for robot in robots if not robot.get_ready()]:
            assert time.monotonic() < until, f"{len(not_ready)} sessions have not begun"
        for robot in robots:
            robot.begin()
        end = time.monotonic() + duration_s
        while time.monotonic() < end:
            for robot in robots:
                robot.look()
        # A key that no program has read when its session ends is in no file.
        until = time.monotonic() + LATEST_S
        while any(robot.n_on_the_way for robot in robots) and time.monotonic() < until:
            for robot in robots:
                robot.look(presses=False)
        for robot in robots:
            robot.end()
        while alive := [robot for robot in robots if robot.terminal.child.isalive()]:
            for robot in alive:
                robot.terminal.discard(0.01)
    return robots


def check(robots: list[Robot], duration_s: float) -> None:
    """Check that no key is lost and that each is where it belongs; print frame rates and delays."""
    stamps: list[float] = []
    rates: list[float] = []
    for robot in robots:
        recording = read_recording(robot.path, allow_truncated=False)
        presses = [event for event in recording.events if isinstance(event, KeyPressed)]
        presses = [press for press in presses if press.key in "jf"]  # one more Enter may have come late
        assert [press.key for press in presses] == [key for key, _ in robot.written]
        stamps += [
            (press.time_ns - written_ns) / MS
            for press, (_, written_ns) in zip(presses, robot.written, strict=True)
        ]
        rates.append(frame_rate(recording, robot.began_ns, duration_s))
        # Each press's frame and step follow again from the frames: replay refuses others.
        protocol = protocol_from(recording.header.protocol)
        result = replay_exactly(recording, build_session(protocol, recording.header.root_seed))
        assert result.difference is None, str(result.difference)
    to_file = [delay for robot in robots for delay in robot.to_file_ms]
    print(
        f"{len(robots)} robots, {duration_s:.0f} s, load {os.getloadavg()[0]:.1f}, {os.cpu_count()} cores: "
        f"{len(stamps)} keys, none lost; frames per second {min(rates):.1f} to {max(rates):.1f}\n"
        f"key to stamp {spread(stamps)}; key to file {spread(to_file)}"
    )


def spread(times_ms: list[float]) -> str:
    """Return median and 99th percentile in words."""
    late_ms = np.quantile(times_ms, 0.99)
    return f"{statistics.median(times_ms):.2f} ms in the median, 99 % within {late_ms:.1f}"


def frame_rate(recording: Recording, began_ns: int, duration_s: float) -> float:
    """Return frames per second while the robot pressed keys."""
    end_ns = began_ns + round(duration_s * NS_PER_S)
    shown = [event.flushed_ns for event in recording.events if isinstance(event, FrameShown)]
    return sum(began_ns <= time_ns < end_ns for time_ns in shown) / duration_s


@pytest.mark.thorough
def test_two_robots_lose_no_key(tmp_path: Path) -> None:
    robots = run(2, 4.0, tmp_path)
    check(robots, 4.0)


@pytest.mark.slow
@pytest.mark.parametrize("n", [1, 5, 10, 20])
def test_many_robots_lose_no_key(n: int, tmp_path: Path) -> None:
    duration_s = float(os.environ.get("ARL_ROBOTS_S", "45"))
    robots = run(n, duration_s, tmp_path)
    check(robots, duration_s)
