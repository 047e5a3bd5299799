"""What the demonstration says of its presses."""

from pathlib import Path

from core.events import PressRetracted
from core.recording.reader import Recording
from core.recording.summary import summarise_recording
from studies.demo import summarise
from tests.arl_tui.fakes import episode_ended, episode_started, session_ended
from tests.core.recording.test_recording import HEADER, press


def test_a_press_that_was_taken_back_did_not_count() -> None:
    back = PressRetracted(press=1, time_ns=5, reason="participant")
    events = (episode_started(), press(0), press(1), back, episode_ended(), session_ended())
    recording = Recording(Path("x.jsonl"), HEADER, events, complete=True)
    summary = summarise(recording)
    assert (summary.accepted, summary.praised, summary.other_presses) == (1, 1, 1)
    assert summary.accepted == summarise_recording(recording).presses_counted
