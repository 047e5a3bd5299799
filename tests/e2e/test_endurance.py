"""Sessions of hours at 30 frames a second: nothing is lost, and neither memory nor delay grows.

By name: `pytest -n 0 -s -m slow tests/e2e/test_endurance.py` (ARL_ENDURANCE_S seconds a game, 7200 by
default). A session of seconds runs by default, so that the measuring itself is tested.
"""

import os
import statistics
import time
from dataclasses import dataclass, field
from pathlib import Path

import numpy as np
import pytest

from core.events import FrameShown, KeyPressed
from core.recording.reader import read_recording
from core.session.protocol_reading import protocol_from
from core.session.replay import replay_exactly
from core.session.session import build_session
from tests.e2e.growing import Growing
from tests.e2e.processes import left_after, memory_of, worker_of
from tests.e2e.terminal import Terminal

MS = 1_000_000
MOST_GROWTH = 20 << 20
"""Bytes that either process may grow by in a session of any length, after its first tenth."""
GAME_SETTINGS = {
    "tetris": "tick_ms = 33\n",
    "keepaway": "\n[domain]\ntype = \"keepaway\"\n",
}  # fmt: skip
"""Ends of the protocol."""
PROTOCOL = """
name = "endurance"

[session]
episodes = 10000
unseen_between = 2
unseen_steps = 30
watched_steps = 200

[keys]
max_presses_per_episode = 1000

[screen]
pause_between_episodes_s = 0.3
count_down_s = 0
"""


@dataclass
class Endured:
    """What was measured of a long session."""

    written: list[tuple[str, int]] = field(default_factory=list)
    """Keys that were written to the terminal, and when, ns."""
    to_file_ms: list[float] = field(default_factory=list)
    """From writing each key to its line in the file."""
    pauses: int = 0
    """Presses that met a covered game."""
    memory: list[tuple[float, int, int]] = field(default_factory=list)
    """Seconds since the start, private bytes of the app and of its worker."""

    def growth(self) -> tuple[int, int]:
        """Return by how many bytes app and worker have grown since the first tenth of the session."""
        settled = self.memory[len(self.memory) // 10]
        return self.memory[-1][1] - settled[1], self.memory[-1][2] - settled[2]


def endure(terminal: Terminal, recording: Growing, duration_s: float, every_s: float) -> Endured:
    """Press keys at random moments, and measure; the screen is read and let go, as a terminal would."""
    rng, found = np.random.default_rng(1), Endured()
    app, worker = terminal.child.pid, worker_of(terminal.child.pid)
    next_sample = start = time.monotonic()
    while time.monotonic() < start + duration_s:
        if time.monotonic() >= next_sample:
            found.memory.append((time.monotonic() - start, memory_of(app), memory_of(worker)))
            tell(found)
            next_sample += every_s
        terminal.discard(rng.uniform(0.3, 1.2))
        key = "jf"[rng.integers(2)]
        recording.new_presses()
        pressed_ns = terminal.press(key)
        found.written.append((key, pressed_ns))
        while not (written := recording.new_presses()):
            assert time.monotonic_ns() < pressed_ns + 10_000 * MS, f"key {len(found.written)} is not recorded"
            terminal.discard(0.001)
        found.to_file_ms.append((time.monotonic_ns() - pressed_ns) / MS)
        if any(b'"verdict":"covered"' in line for line in written):
            # A machine that stands still for seconds pauses the session: the participant goes on.
            found.pauses += 1
            terminal.discard(1.0)
            terminal.press(" ")
    return found


def tell(found: Endured) -> None:
    """Print how the session goes."""
    after_s, app, worker = found.memory[-1]
    delay_ms = statistics.median(found.to_file_ms[-40:] or [0.0])
    print(
        f"{after_s:.0f} s: app {app / 1e6:.1f} MB, worker {worker / 1e6:.1f} MB, {len(found.written)} keys, "
        f"the last in {delay_ms:.1f} ms in the file",
        flush=True,
    )


def play_for(game: str, duration_s: float, every_s: float, tmp_path: Path) -> None:
    """Play a session, measure, and check."""
    (tmp_path / "endurance.toml").write_text(PROTOCOL + GAME_SETTINGS[game])
    arguments = ("play", game, "--protocol", "endurance.toml", "--seed", "1", "--recordings", "r")
    with Terminal(*arguments, cwd=tmp_path) as terminal:
        terminal.begin("Game 1")
        (path,) = (tmp_path / "r").glob("*.jsonl")
        pids = {terminal.child.pid, worker_of(terminal.child.pid)}
        with path.open("rb") as growing:
            found = endure(terminal, Growing(growing), duration_s, every_s)
        terminal.child.kill(15)
        while terminal.child.isalive():
            terminal.discard(0.1)
        assert left_after(pids, 2.0) == set()
    check(game, path, found)


def check(game: str, path: Path, found: Endured) -> None:
    """Check that every key is in the file, and report growth and delay."""
    recording = read_recording(path, allow_truncated=False)
    presses = [event for event in recording.events if isinstance(event, KeyPressed)]
    presses = [press for press in presses if press.key in "jf"]  # others uncover the game
    assert [press.key for press in presses] == [key for key, _ in found.written]
    stamps = [
        (press.time_ns - written_ns) / MS
        for press, (_, written_ns) in zip(presses, found.written, strict=True)
    ]
    frames = sum(isinstance(event, FrameShown) for event in recording.events)
    hours = found.memory[-1][0] / 3600
    app, worker = found.growth()
    n = max(1, len(stamps) // 10)
    first, last = (statistics.median(part) for part in (stamps[:n], stamps[-n:]))
    to_file = [statistics.median(part) for part in (found.to_file_ms[:n], found.to_file_ms[-n:])]
    print(
        f"{game}: {hours:.2f} h, {len(stamps)} keys, none lost, {found.pauses} of them in pauses, "
        f"{len(recording.events)} events, {frames} frames\n"
        f"growth: app {app / 1e6:.1f} MB, worker {worker / 1e6:.1f} MB\n"
        f"median of the first tenth and of the last: key to stamp {first:.2f} and {last:.2f} ms, key to file "
        f"{to_file[0]:.2f} and {to_file[1]:.2f} ms; load {os.getloadavg()}"
    )
    assert app < MOST_GROWTH
    assert worker < MOST_GROWTH
    protocol = protocol_from(recording.header.protocol)
    result = replay_exactly(recording, build_session(protocol, recording.header.root_seed))
    assert result.difference is None, str(result.difference)


@pytest.mark.thorough
@pytest.mark.parametrize("game", GAME_SETTINGS)
def test_a_session_of_seconds_is_measured(game: str, tmp_path: Path) -> None:
    play_for(game, 4.0, 1.0, tmp_path)


@pytest.mark.slow
@pytest.mark.parametrize("game", GAME_SETTINGS)
def test_a_session_of_hours_grows_neither_in_memory_nor_in_delay(game: str, tmp_path: Path) -> None:
    play_for(game, float(os.environ.get("ARL_ENDURANCE_S", "7200")), 60.0, tmp_path)
