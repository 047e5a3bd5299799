"""The tutorial *A first study in ten minutes*, every command in it, as a stranger follows it: minutes, by
name: `pytest -n 0 -s -m thorough tests/e2e/test_first_study.py`.
"""

import csv
import shlex
import sys
import time
from pathlib import Path

import pytest

from tests.documented import DOCS, blocks_of
from tests.e2e.terminal import TROUBLE, Terminal
from tests.e2e.test_study import no_secrets
from tests.e2e.test_study_kills import ANSWERS, in_game
from tests.test_documented_blocks import in_shell, run

PAGE = DOCS / "tutorials" / "first-study.md"
LONGEST_S = 1200.0
ASKED = (("Answer every statement", "yyn\r"), *ANSWERS[1:])


def take_part(terminal: Terminal) -> None:
    """Take part from welcome to thanks."""
    end = time.monotonic() + LONGEST_S
    while terminal.pump(0.5):
        assert time.monotonic() < end, terminal.text
        assert TROUBLE not in terminal.text, terminal.text
        no_secrets(terminal)
        keys = "j" if in_game(terminal) else next((keys for text, keys in ASKED if text in terminal.text), "")
        terminal.press(keys)


@pytest.mark.thorough
def test_a_stranger_has_two_simulated_and_one_own_participant_recorded_checked_and_tabulated(
    tmp_path: Path,
) -> None:
    began, watched, printed = time.monotonic(), 0, ""
    for block in blocks_of(PAGE):
        command = shlex.split(block.text)[1:] if block.language == "sh" else []
        if "--watch" in command:
            with Terminal(*command, cwd=tmp_path) as monitor:
                monitor.wait_for("1 of 12 have finished")
                monitor.press("q")
                assert monitor.wait_for_exit() == 0
            watched += 1
        elif command[:2] == ["study", "run"]:
            with Terminal(*command, cwd=tmp_path) as terminal:
                take_part(terminal)
                assert b"finished the sitting." in terminal.received, terminal.text
        elif block.language == "sh":
            printed = run(in_shell(block.text), tmp_path)
        elif block.language == "python":
            run([sys.executable, "-c", block.text], tmp_path)
        else:
            assert block.text in printed, block.where
        print(f"{time.monotonic() - began:.0f} s: {block.where}", flush=True)
    assert watched == 1
    run(["arl", "export", "tidy", "data/studies/demo", "--out", "own"], tmp_path)
    for folder, origin, n in (("tables", "simulated", 4), ("own", "live", 2)):
        with (tmp_path / folder / "sessions.csv").open(newline="") as file:
            assert [row["origin"] for row in csv.DictReader(file)] == [origin] * n
