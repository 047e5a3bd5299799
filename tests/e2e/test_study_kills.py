"""Sittings killed at random moments: every one can go on, and nothing that the screen had confirmed is lost.

A few kills by default; 200 by name, two participants at a time, with a line of progress for each 8 kills:
`pytest -n 2 -v -m slow tests/e2e/test_study_kills.py`.
"""

import contextlib
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
from tests.e2e.test_study import STUDY, Lab, exact, no_secrets

KILLS_EACH = 8
"""Kills of sittings in one folder; who has finished is followed by another participant."""
LONGEST_S = 9.0
"""A kill comes at most so long after the first page is seen: a sitting without kills takes twice as long."""
AT_START = 0.15
"""Fraction of kills that come while the program is starting."""
FAST = STUDY.replace("watched_steps = 7", "watched_steps = 5").replace("tick_ms = 70", "tick_ms = 40")
ANSWERS = (
    ("I agree.", "yn\r"),
    ("Enter  to start, ", "\r"),
    ("Enter  to leave", "\r"),
    ("Question", "3\r"),
    ("Enter  to read on", "\r"),
    ("Enter  to go on", "\r"),
)
"""What stands on the screen, and what the participant presses then."""


def take_part(lab: Lab, code: str, rng: np.random.Generator, *, to_kill: bool) -> bool:
    """Take part until the sitting is over, or until it is killed; return whether it was killed.

    How long a computer takes to start the program is not part of the moment of a kill, so a busy one kills
    where a quiet one does.
    """
    confirmed = Confirmed()
    over = (f"{code} finished the sitting.", f"{code} has finished: there is nothing left to do")
    before = recordings(lab, code)
    at_start = bool(rng.random() < AT_START)
    after_s = rng.uniform(0.1, 2.0) if at_start else rng.uniform(0.2, LONGEST_S)
    with lab.run("--participant", code) as terminal:
        last = time.monotonic() + PATIENCE_S
        end = time.monotonic() + after_s if to_kill and at_start else last
        seen = False
        while (now := time.monotonic()) < end:
            if not terminal.pump(rng.uniform(0.05, 0.2)):
                # Not what stands on the screen: Enter, pressed once more, may have moved it away.
                # A kill may come between the last line of the ledger and the last word to the experimenter.
                said = terminal.received
                assert any(words.encode() in said for words in over), terminal.text
                check(lab, code, before, confirmed)
                return False
            if to_kill and not seen and "Enter" in terminal.text:
                seen, end = True, end if at_start else now + after_s
            no_secrets(terminal)
            assert TROUBLE not in terminal.text, terminal.text
            if in_game(terminal):
                confirmed.look(terminal)
                terminal.press("jf"[rng.integers(2)])
                continue
            keys = next((keys for text, keys in ANSWERS if text in terminal.text), "")
            if "Thank you!" in terminal.text or "Enter  to start" in terminal.text:
                check(lab, code, before, confirmed)
                confirmed, before = Confirmed(), recordings(lab, code)
            terminal.press(keys)
        assert now < last, f"nothing to kill and not finished within {PATIENCE_S:.0f} s:\n{terminal.text}"
        if in_game(terminal):
            confirmed.look(terminal)
        pids = descendants(terminal.child.pid)
        victims = (terminal.child.pid,) if rng.integers(2) else (*pids, terminal.child.pid)
        for pid in victims:
            with contextlib.suppress(ProcessLookupError):
                os.kill(pid, signal.SIGKILL)
        # What is left says so on a terminal that is read: the guard waits for one that is not.
        end = time.monotonic() + 60.0
        while (left := left_after(pids, 0.1)) and time.monotonic() < end:
            terminal.drain(0.2)
        assert not left
    check(lab, code, before, confirmed)
    return True


def recordings(lab: Lab, code: str) -> set[Path]:
    """Return the recordings of a participant's sessions."""
    return set(lab.data.rglob(f"{code}-*.jsonl"))


def in_game(terminal: Terminal) -> bool:
    """Return whether a game is on screen, and no page that covers one that is over."""
    text = terminal.text
    return "Game " in text and "Enter  to" not in text and "Thank you!" not in text


def check(lab: Lab, code: str, before: set[Path], confirmed: Confirmed) -> None:
    """Check that the newest recording holds what the screen had confirmed of it.

    Where there is none since the last check, the screen still showed the last game of the block before.
    """
    if not confirmed.presses:
        return
    now = recordings(lab, code)
    new = now - before
    assert len(new) <= 1, f"one block on screen, and {new}"
    path = max(new or now, key=lambda one: one.stat().st_mtime_ns)
    assert confirmed.missing_from(read_session(path)) == {}


def kill_and_go_on(number: int, folder: Path, kills: int) -> None:
    """Kill sittings at random moments, and let each participant go on until they have finished."""
    rng, lab, began = np.random.default_rng(number), Lab(folder, FAST), time.monotonic()
    killed = participants = 0
    while killed < kills:
        participants += 1
        code = f"P{participants}"
        old: dict[Path, bytes] = {}
        while take_part(lab, code, rng, to_kill=killed < kills):
            killed += 1
            assert {path: path.read_bytes() for path in old} == old, "an old recording was changed"
            old = {path: path.read_bytes() for path in recordings(lab, code)}
            if (lab.data / "ledger.jsonl").exists():
                read_ledger(lab.data / "ledger.jsonl")
        finished = [block for block in lab.blocks(code) if block.finished]
        assert len(finished) == 2
        for block in finished:
            assert exact(block.recording)
            assert block.summary.games_finished == 2
        assert lab.participant(code).sittings[0].ended == "finished"
    print(
        f"{number}: {killed} kills, {participants} participants finished, {time.monotonic() - began:.0f} s",
        flush=True,
    )


@pytest.mark.thorough
def test_sittings_that_are_killed_again_and_again_are_finished(tmp_path: Path) -> None:
    kill_and_go_on(0, tmp_path, 2)


@pytest.mark.slow
@pytest.mark.parametrize("number", range(1, 1 + 200 // KILLS_EACH))
def test_200_kills(number: int, tmp_path: Path) -> None:
    kill_and_go_on(number, tmp_path, KILLS_EACH)
