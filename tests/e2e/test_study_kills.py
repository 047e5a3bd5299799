"""Sittings killed at random moments: every one can go on, and nothing that the screen had confirmed is lost.

A few kills by default; 200 by name: `pytest -m slow tests/e2e/test_study_kills.py`.
"""

import os
import signal
import time
from pathlib import Path

import numpy as np
import pytest

from core.recording.joined import read_session
from studies.lab.ledger import read_ledger
from tests.e2e.confirmed import Confirmed
from tests.e2e.processes import descendants, left_after
from tests.e2e.terminal import PATIENCE_S, TROUBLE, Terminal
from tests.e2e.test_study import Lab, exact, no_secrets

KILLS_EACH = 4
"""Kills of one participant's sitting before they are left to finish it."""
LONGEST_S = 16.0
ANSWERS = (
    ("I agree.", "yn\r"),
    ("Enter  to start, ", "\r"),
    ("Enter  to leave", "\r"),
    ("Question", "3\r"),
    ("Enter  to read on", "\r"),
    ("Enter  to go on", "\r"),
)
"""What stands on the screen, and what the participant presses then."""


def take_part(lab: Lab, rng: np.random.Generator, kill_after_s: float | None) -> bool:
    """Take part until the sitting is over, or until it is killed; return whether it was killed."""
    confirmed = Confirmed()
    before = set(lab.data.rglob("P1-*.jsonl"))
    with lab.run("--participant", "P1") as terminal:
        end = time.monotonic() + (PATIENCE_S if kill_after_s is None else kill_after_s)
        while time.monotonic() < end:
            if not terminal.pump(rng.uniform(0.05, 0.25)):
                status = terminal.wait_for_exit()
                said = f"status {status}, last words {terminal.received[-500:]!r}"
                assert "P1 finished the sitting." in terminal.text, said
                return False
            no_secrets(terminal)
            assert TROUBLE not in terminal.text, terminal.text
            if in_game(terminal):
                confirmed.look(terminal)
                terminal.press("jf"[rng.integers(2)])
                continue
            keys = next((keys for text, keys in ANSWERS if text in terminal.text), "")
            if "Thank you!" in terminal.text or "Enter  to start" in terminal.text:
                check(lab, before, confirmed)
                confirmed, before = Confirmed(), set(lab.data.rglob("P1-*.jsonl"))
            terminal.press(keys)
        assert kill_after_s is not None, f"not finished within {PATIENCE_S:.0f} s:\n{terminal.text}"
        if in_game(terminal):
            confirmed.look(terminal)
        pids = descendants(terminal.child.pid)
        victims = (terminal.child.pid,) if rng.integers(2) else (*pids, terminal.child.pid)
        for pid in victims:
            os.kill(pid, signal.SIGKILL)
        assert not left_after(pids, 10.0)
    check(lab, before, confirmed)
    return True


def in_game(terminal: Terminal) -> bool:
    """Return whether a game is on screen, and no page that covers one that is over."""
    text = terminal.text
    return "Game " in text and "Enter  to" not in text and "Thank you!" not in text


def check(lab: Lab, before: set[Path], confirmed: Confirmed) -> None:
    """Check that the newest recording holds what the screen had confirmed of it.

    Where there is none since the last check, the screen still showed the last game of the block before.
    """
    if not confirmed.presses:
        return
    recordings = set(lab.data.rglob("P1-*.jsonl"))
    new = recordings - before
    assert len(new) <= 1, f"one block on screen, and {new}"
    path = max(new or recordings, key=lambda one: one.stat().st_mtime_ns)
    assert confirmed.missing_from(read_session(path)) == {}


def go_on_until_finished(number: int, folder: Path) -> None:
    """Kill a participant's sitting several times, and let them go on each time."""
    rng = np.random.default_rng(number)
    lab = Lab(folder)
    old: dict[Path, bytes] = {}
    for _ in range(KILLS_EACH):
        if not take_part(lab, rng, rng.uniform(2.0, LONGEST_S)):
            break
        for path, content in old.items():
            assert path.read_bytes() == content, f"{path} was changed"
        old = {path: path.read_bytes() for path in lab.data.rglob("P1-*.jsonl")}
        if (lab.data / "ledger.jsonl").exists():
            read_ledger(lab.data / "ledger.jsonl")
    else:
        assert not take_part(lab, rng, None)
    finished = [block for block in lab.blocks() if block.finished]
    assert len(finished) == 2
    for block in finished:
        assert exact(block.recording)
        assert block.summary.games_finished == 2
    assert lab.participant().sittings[0].ended == "finished"


@pytest.mark.parametrize("number", range(1))
def test_a_sitting_that_is_killed_again_and_again_is_finished(number: int, tmp_path: Path) -> None:
    go_on_until_finished(number, tmp_path)


@pytest.mark.slow
@pytest.mark.parametrize("number", range(1, 1 + 200 // KILLS_EACH))
def test_200_kills(number: int, tmp_path: Path) -> None:
    go_on_until_finished(number, tmp_path)
