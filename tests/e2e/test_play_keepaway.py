"""Keepaway in a pseudo-terminal: watched, judged, recorded, replayed; killed in the middle."""

import itertools
import os
import signal
from pathlib import Path

from core.events import CreditGiven, EpisodeEnded, FrameShown, KeyPressed, SessionEnded, StepTaken
from core.keepaway.pitch import CYCLE_NS
from tests.e2e.terminal import TROUBLE, Terminal
from tests.e2e.test_play import replayed, the_recording

PROTOCOL = """
name = "short"

[domain]
type = "keepaway"
exact_state = true

[session]
episodes = 2
unseen_between = 2
unseen_steps = 60
watched_steps = 25

[screen]
speed = 1.0
count_down_s = 0
pause_between_episodes_s = 1.5
"""


def play(tmp_path: Path) -> Terminal:
    path = tmp_path / "short.toml"
    path.write_text(PROTOCOL)
    return Terminal(
        "play", "keepaway", "--protocol", str(path), "--seed", "11", "--recordings", "r", cwd=tmp_path
    )


def start(terminal: Terminal) -> None:
    terminal.begin("2 of 2 presses left")


def test_a_person_watches_keepaway_and_is_heard(tmp_path: Path) -> None:
    with play(tmp_path) as terminal:
        start(terminal)
        written_ns = terminal.press("j")
        terminal.wait_for("1 of 2 presses left")
        assert terminal.wait_for("Thank you", TROUBLE) == "Thank you"
        terminal.press("\r")
        assert terminal.wait_for_exit() == 0
    recording = the_recording(tmp_path)
    assert recording.complete
    assert isinstance(recording.outputs[-1], SessionEnded)
    (press,) = [event for event in recording.events if isinstance(event, KeyPressed) and event.key == "j"]
    assert press.verdict == "accepted"
    assert press.time_ns >= written_ns
    assert [event.press for event in recording.events if isinstance(event, CreditGiven)] == [press.press]
    assert sum(isinstance(event, EpisodeEnded) for event in recording.events) == 2
    check_intervals(recording.events)
    replayed(recording)


def check_intervals(events) -> None:
    """Hold that steps were seen in order, each after its decision, and that simulated time is not faster than
    ours."""
    shown: dict[int, int] = {}
    for event in events:
        if isinstance(event, FrameShown) and event.step >= 0:
            shown.setdefault(event.step, event.flushed_ns)
    steps = [event for event in events if isinstance(event, StepTaken) and event.step in shown]
    for one, other in itertools.pairwise(steps):
        assert one.time_ns < shown[one.step] < shown[other.step]
    for episode in {step.episode for step in steps}:
        of_episode = [step for step in steps if step.episode == episode]
        first, last = of_episode[0], of_episode[-1]
        cycles = last.detail["cycle"] - first.detail["cycle"]
        # A busy machine may decide the first step up to a cycle late; what was lost is never made up by
        # hurrying.
        assert last.time_ns - first.time_ns >= (cycles - 1) * CYCLE_NS


def test_a_killed_session_of_keepaway_is_replayed_up_to_there(tmp_path: Path) -> None:
    with play(tmp_path) as terminal:
        start(terminal)
        terminal.press("f")
        terminal.wait_for("1 of 2 presses left")
        os.kill(terminal.child.pid, signal.SIGKILL)
        terminal.child.wait()
    recording = the_recording(tmp_path)
    assert not recording.complete
    assert [event.key for event in recording.events if isinstance(event, KeyPressed)] == ["f"]
    replayed(recording)
