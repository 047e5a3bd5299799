"""Participants who mash all keys, hold them down, resize, pause again and again, or answer nothing.

Whatever they do, the session goes to its end, everything is recorded, and a replay is exact.
"""

import itertools
import random
import time
from collections.abc import Callable
from pathlib import Path

import pytest

from core.events import EpisodeEnded, KeyPressed, Resumed, ScreenCleared, SessionEnded
from core.recording.reader import Recording
from tests.e2e.terminal import PATIENCE_S, Terminal
from tests.e2e.test_play import play, replayed, start, the_recording

LETTERS = "abcdefghijklmnoprstuvwxyz0123456789.,-+ "
"""All but q, which asks whether to stop."""
OTHERS = ("\x1b[A", "\x1b[B", "\x1b[C", "\x1b[D", "\x1bOP", "\x1b[5~", "\t", "\x7f", "\x01", "ä", "\x1b")
"""Arrows, F1, Page Up, Tab, Backspace, Ctrl+A, another alphabet, Escape."""
MOST_PRESSES = 5
"""Of the protocol, in each game."""


def rough(tmp_path: Path, protocol_file: Path, act: Callable[[Terminal, int], None]) -> Recording:
    """Run a session in which `act` is called again and again until the last page; return its recording."""
    with play(tmp_path, protocol_file) as terminal:
        start(terminal)
        end = time.monotonic() + PATIENCE_S
        for turn in itertools.count():
            if "Thank you" in terminal.text:
                break
            assert time.monotonic() < end, terminal.text
            assert "had to end early" not in terminal.text, terminal.text
            act(terminal, turn)
            assert terminal.pump(0.03), terminal.text
        terminal.resize(80, 24)
        terminal.pump(0.5)
        terminal.press("\r")
        assert terminal.wait_for_exit() == 0
    return the_recording(tmp_path)


def check(recording: Recording) -> list[KeyPressed]:
    """Hold that the session is complete and exact, and that no game took more presses than it had."""
    assert recording.complete
    assert isinstance(recording.outputs[-1], SessionEnded)
    assert recording.outputs[-1].reason == "finished"
    accepted = 0
    for event in recording.events:
        if isinstance(event, KeyPressed):
            accepted += event.verdict == "accepted"
        elif isinstance(event, EpisodeEnded):
            accepted = 0
        assert accepted <= MOST_PRESSES + sum(_taken_back(recording))
    covers = [event for event in recording.events if isinstance(event, ScreenCleared | Resumed)]
    for one, other in itertools.pairwise(covers):
        assert type(one) is not type(other), f"covered twice in a row: {one}, {other}"
    replayed(recording)
    return [event for event in recording.events if isinstance(event, KeyPressed)]


def _taken_back(recording: Recording) -> list[bool]:
    return [type(event).__name__ == "PressRetracted" for event in recording.events]


@pytest.mark.thorough
def test_a_participant_who_mashes_all_keys_and_resizes(tmp_path: Path, protocol_file: Path) -> None:
    chance = random.Random(7)
    windows = itertools.cycle([(200, 60), (120, 40), (70, 20), (80, 24)])

    def mash(terminal: Terminal, turn: int) -> None:
        if turn % 25 == 24:
            terminal.resize(*next(windows))
        elif turn % 5 == 0:
            terminal.press(chance.choice(OTHERS))
        else:
            terminal.press("".join(chance.choices(LETTERS, k=3)))

    presses = check(rough(tmp_path, protocol_file, mash))
    assert len({press.key for press in presses}) > 15
    assert {"other", "accepted"} <= {press.verdict for press in presses}


@pytest.mark.thorough
def test_a_participant_who_answers_nothing(tmp_path: Path, protocol_file: Path) -> None:
    assert check(rough(tmp_path, protocol_file, lambda terminal, turn: None)) == []


@pytest.mark.slow
def test_a_participant_who_holds_a_key_down(tmp_path: Path, protocol_file: Path) -> None:
    presses = check(rough(tmp_path, protocol_file, lambda terminal, turn: terminal.press("j") and None))
    verdicts = [press.verdict for press in presses]
    # A key that is held down counts once, or once more after a pause of its repeats on a busy machine.
    assert verdicts.count("repeat") > 10 * verdicts.count("accepted")


@pytest.mark.slow
def test_a_participant_who_pauses_again_and_again(tmp_path: Path, protocol_file: Path) -> None:
    def pause(terminal: Terminal, turn: int) -> None:
        if turn % 8 == 0:
            terminal.press("p" if turn % 16 == 0 else " ")

    recording = rough(tmp_path, protocol_file, pause)
    check(recording)
    pauses = [event for event in recording.events if isinstance(event, ScreenCleared)]
    assert len(pauses) > 3


@pytest.mark.slow
def test_a_participant_who_mashes_even_the_keys_that_stop(tmp_path: Path, protocol_file: Path) -> None:
    chance = random.Random(3)

    def mash(terminal: Terminal, turn: int) -> None:
        terminal.press("".join(chance.choices("jfuqnyph ", k=2)))

    with play(tmp_path, protocol_file) as terminal:
        start(terminal)
        end = time.monotonic() + PATIENCE_S
        while terminal.pump(0.05):
            assert time.monotonic() < end, terminal.text
            mash(terminal, 0)
        assert terminal.wait_for_exit() == 0
    recording = the_recording(tmp_path)
    assert recording.complete
    replayed(recording)
