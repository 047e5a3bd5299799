"""The experimenter's page beside a sitting, both in real terminals."""

import time
from pathlib import Path

import pytest

from studies.lab.notes import read_notes
from tests.e2e.terminal import PATIENCE_S, START, Terminal
from tests.e2e.test_study import Lab, consent, exact, kill


def both(monitor: Terminal, terminal: Terminal, text: str) -> None:
    """Read both terminals until the monitor shows a text: a terminal that nobody reads blocks its program."""
    end = time.monotonic() + PATIENCE_S
    while text not in monitor.text:
        assert time.monotonic() < end, f"{text} was not seen:\n{monitor.text}"
        terminal.pump(0.05)
        monitor.pump(0.05)


@pytest.mark.thorough
def test_the_experimenter_follows_a_sitting_and_takes_a_note(tmp_path: Path) -> None:
    lab = Lab(tmp_path)
    watching = ("study", "status", str(lab.folder / "study.toml"), "--watch")
    with Terminal(*watching, cwd=lab.folder) as monitor, lab.run("--participant", "P1") as terminal:
        monitor.wait_for("Nobody has taken part yet")
        consent(terminal)
        terminal.wait_for(START)
        both(monitor, terminal, "P1  day 1: step 3 of 7 (block)")
        terminal.begin("Game 1")
        terminal.pump(0.5)
        terminal.press("j")
        both(monitor, terminal, "game 1, ")
        assert "LINEARCONDITION" not in monitor.text
        assert "presses per minute, lag" in monitor.text
        terminal.pump(0.3)
        monitor.press("n")
        both(monitor, terminal, "Note, then Enter")
        monitor.press("P1 was interrupted by a phone\r")
        both(monitor, terminal, "Noted at ")
        terminal.wait_for("Thank you!")
        kill(terminal)
        monitor.press("q")
        assert monitor.wait_for_exit() == 0
    (note,) = read_notes(lab.data)
    assert (note.text, note.running) == ("P1 was interrupted by a phone", ("P1",))
    (found,) = lab.blocks()
    assert exact(found.recording)
