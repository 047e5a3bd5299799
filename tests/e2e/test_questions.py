"""The agent's questions in a pseudo-terminal: seen, answered by a key, recorded and replayed."""

import time
from pathlib import Path

import pytest

from core.events import KeyPressed, QuestionAnswered, QuestionPosed
from tests.e2e.terminal import Terminal
from tests.e2e.test_play import play, replayed, the_recording

MS = 1_000_000
PROTOCOL = """
name = "asking"

[session]
episodes = 2
unseen_before = 150
unseen_between = 4
unseen_steps = 200
watched_steps = 8

[screen]
tick_ms = 70
count_down_s = 0
pause_between_episodes_s = 0.3

[agent.asking]
per_episode = 2
share = 0.5
minimum_decisions = 1
limit_s = 6
settle_s = 0.2
"""
READ_S = 0.3


def start(terminal: Terminal) -> None:
    """Start the session; press again where getting ready took so long that nobody may be there any more."""
    terminal.wait_for("Enter  to start, ")
    terminal.press("\r")
    if terminal.wait_for("Game 1", "Ready. ") == "Ready. ":
        terminal.press("\r")
        terminal.wait_for("Game 1")


def answer(terminal: Terminal, key: str) -> int:
    """Answer the question that is on screen; return when the key was written."""
    terminal.wait_for("A question for you")
    time.sleep(READ_S)
    written_ns = terminal.press(key)
    terminal.wait_for("the computer learns from your answer", "that is fine")
    return written_ns


@pytest.mark.thorough
def test_questions_are_answered_by_keys_recorded_and_replayed(tmp_path: Path) -> None:
    file = tmp_path / "asking.toml"
    file.write_text(PROTOCOL)
    with play(tmp_path, file) as terminal:
        start(terminal)
        written = [(key, answer(terminal, key)) for key in "20"]
        terminal.wait_for("Thank you!")
        terminal.press("\r")
        assert terminal.wait_for_exit() == 0
    recording = the_recording(tmp_path)
    posed = [event for event in recording.events if isinstance(event, QuestionPosed)]
    answered = [event for event in recording.events if isinstance(event, QuestionAnswered)]
    assert len(posed) == len(answered) >= 2
    assert [each.answer for each in answered[:2]] == ["chosen", "none"]
    assert answered[0].chosen == posed[0].options[1]
    assert all(each.answer == "time-limit" for each in answered[2:])
    presses = {event.press: event for event in recording.events if isinstance(event, KeyPressed)}
    for given, (key, written_ns) in zip(answered, written, strict=False):
        assert presses[given.press].key == key
        assert presses[given.press].time_ns == given.time_ns
        assert 0 <= given.time_ns - written_ns < 500 * MS
        assert given.time_ns - given.shown_ns > READ_S / 2 * 1e9
    replayed(recording)
