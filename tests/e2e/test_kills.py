"""Sessions killed at random moments: what the screen had confirmed is in the file, and the file replays.

A dozen kills by default; 200 by name: `pytest -m slow tests/e2e/test_kills.py`.
"""

import os
import signal
import time
from pathlib import Path

import numpy as np
import pytest

from core.recording.reader import read_recording
from core.session.protocol_reading import protocol_from
from core.session.replay import replay_exactly
from core.session.session import build_session
from tests.e2e.confirmed import Confirmed
from tests.e2e.processes import left_after, worker_of
from tests.e2e.terminal import TROUBLE, Terminal

KILLS, MANY_KILLS = 12, 200
VICTIMS = ("app", "worker", "both")
GAMES = ("tetris", "keepaway")
GAME_SETTINGS = {
    "tetris": "[screen]\ntick_ms = 60\npause_between_episodes_s = 0.3\n",
    "keepaway": "[domain]\ntype = \"keepaway\"\n\n[screen]\npause_between_episodes_s = 0.3\n",
}  # fmt: skip
PROTOCOL = """
name = "killed"

[session]
episodes = 40
unseen_between = 2
unseen_steps = 30
watched_steps = 60

[keys]
max_presses_per_episode = 60

"""
LONGEST_PLAY_S = 4.0


def kill_one(number: int, tmp_path: Path) -> None:
    """Play a session, press keys, kill, and compare."""
    rng = np.random.default_rng(number)
    game, victim = GAMES[number % 2], VICTIMS[number // 2 % 3]
    (tmp_path / "killed.toml").write_text(PROTOCOL + GAME_SETTINGS[game])
    confirmed = Confirmed()
    arguments = ("play", game, "--protocol", "killed.toml", "--seed", str(number), "--recordings", "r")
    with Terminal(*arguments, cwd=tmp_path) as terminal:
        terminal.begin("Game 1")
        app, worker = terminal.child.pid, worker_of(terminal.child.pid)
        end = time.monotonic() + rng.uniform(0.3, LONGEST_PLAY_S)
        while (left_s := end - time.monotonic()) > 0:
            terminal.press("jfux"[rng.choice(4, p=[0.45, 0.35, 0.1, 0.1])])
            pause = time.monotonic() + min(left_s, rng.uniform(0.02, 0.3))
            while time.monotonic() < pause:
                terminal.pump(0.01)
                confirmed.look(terminal)
        # The app first: between two kills a busy machine would leave it the time to end the recording.
        for pid in {"app": [app], "worker": [worker], "both": [app, worker]}[victim]:
            os.kill(pid, signal.SIGKILL)
        if victim == "worker":
            terminal.wait_for(TROUBLE, patience_s=60.0)
            terminal.press("\r")
            assert terminal.wait_for_exit() == 1
        else:
            drain(terminal, confirmed)
        assert left_after({app, worker}, 2.0) == set()
    (path,) = (tmp_path / "r").glob("*.jsonl")
    recording = read_recording(path)
    assert recording.complete == (victim == "worker")
    assert confirmed.missing_from(recording) == {}, f"kill {number} of the {victim}, {game}"
    protocol = protocol_from(recording.header.protocol)
    result = replay_exactly(recording, build_session(protocol, recording.header.root_seed))
    assert result.difference is None, f"kill {number}: {result.difference}"


def drain(terminal: Terminal, confirmed: Confirmed) -> None:
    """Read what the program had written before it was killed: the participant has seen it, too."""
    end = time.monotonic() + 1.0
    while terminal.pump(0.02) and time.monotonic() < end:
        if "unexpectedly" in terminal.text:
            return
        confirmed.look(terminal)


@pytest.mark.parametrize("number", range(KILLS))
def test_presses_that_were_confirmed_survive_a_kill(number: int, tmp_path: Path) -> None:
    kill_one(number, tmp_path)


@pytest.mark.slow
@pytest.mark.parametrize("number", range(KILLS, MANY_KILLS))
def test_presses_that_were_confirmed_survive_many_kills(number: int, tmp_path: Path) -> None:
    kill_one(number, tmp_path)
