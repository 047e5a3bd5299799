"""Simulated people by name at a real keyboard: they read the growing recording, and write keys to the
terminal."""

import time
from collections.abc import Iterator
from pathlib import Path

import msgspec
import pytest

from arl_tui.app.demo_participant import DemoParticipant
from arl_tui.app.link import PressSuggested
from core.events import EpisodeStarted, Event, FrameShown, KeyPressed, SessionEnded, StepTaken
from core.feedback.simulated_participants import person
from core.recording.reader import read_recording
from core.session.protocol_reading import protocol_from
from core.session.session import build_session
from tests.e2e.terminal import Terminal
from tests.e2e.test_play import play, replayed, start, the_recording

MS = 1_000_000
STEP_NS = 14 * 70 * MS
"""How long a step of the short protocol is on screen: 14 ticks of 70 ms."""


class AtTheKeyboard:
    """One simulated person, who is told of steps by the recording and presses when they are due."""

    def __init__(self, name: str, recording: Path) -> None:
        header = read_recording(recording).header
        # Talkative: a short session must do.
        trainer = msgspec.structs.replace(person(name), press_probability=1.0, mean_presses=None)
        protocol = msgspec.structs.replace(protocol_from(header.protocol), trainer=trainer)
        self._demo_participant = DemoParticipant(build_session(protocol, 11), protocol, root_seed=7)
        self._recording = recording
        self._read = 0
        self._steps: dict[int, StepTaken] = {}
        self._due: list[PressSuggested] = []
        self.written: list[tuple[str, int]] = []

    def look_and_press(self, terminal: Terminal) -> None:
        """Read what is new, and press what is due."""
        for event in self._news():
            if isinstance(event, EpisodeStarted):
                self._demo_participant.begin(event)
            elif isinstance(event, StepTaken):
                self._steps[event.step] = event
            elif isinstance(event, FrameShown) and event.step in self._steps:
                shown_ns = event.flushed_ns
                self._due += self._demo_participant.watch(
                    self._steps.pop(event.step), shown_ns=shown_ns, hidden_ns=shown_ns + STEP_NS
                )
        while self._due and self._due[0].time_ns <= time.monotonic_ns():
            press = self._due.pop(0)
            self.written.append((press.key, terminal.press(press.key)))

    def _news(self) -> Iterator[Event]:
        events = read_recording(self._recording).events
        yield from events[self._read :]
        self._read = len(events)


def go_on_after_a_gap(terminal: Terminal) -> None:
    """Leave the page that says that the machine was held up: it waits for the participant."""
    if "held up" in terminal.text:
        terminal.press(" ")
        terminal.pump(0.2)


@pytest.mark.thorough
def test_an_adversary_at_the_keyboard_is_recorded_as_they_pressed_and_learned_from(
    tmp_path: Path, protocol_file: Path
) -> None:
    with play(tmp_path, protocol_file) as terminal:
        start(terminal)
        (path,) = (tmp_path / "r").glob("*.jsonl")
        somebody = AtTheKeyboard("adversary", path)
        while "Thank you" not in terminal.text:
            assert terminal.pump(0.01), terminal.text
            go_on_after_a_gap(terminal)
            somebody.look_and_press(terminal)
        terminal.press("\r")
        assert terminal.wait_for_exit() == 0
    recording = the_recording(tmp_path)
    presses = [
        event for event in recording.events if isinstance(event, KeyPressed) and event.key in ("f", "j")
    ]
    assert len(presses) >= 4
    assert [press.key for press in presses] == [key for key, _ in somebody.written][: len(presses)]
    accepted = [press for press in presses if press.verdict == "accepted"]
    good = recording.header.protocol["keys"]["good"]
    assert [press.value for press in accepted] == [1.0 if press.key == good else -1.0 for press in accepted]
    ended = recording.outputs[-1]
    assert isinstance(ended, SessionEnded)
    assert any(any(vector) for vector in ended.weights.values())
    replayed(recording)
