"""How a session ended and what a recording holds, in the words of every command."""

from pathlib import Path

import msgspec
import pytest

from core.events import (
    EpisodeEnded,
    Event,
    FocusLost,
    FocusRegained,
    KeyPressed,
    PressRetracted,
    SessionEnded,
    StopAsked,
    StopReason,
    TimeGap,
)
from core.recording import skim
from core.recording.reader import Recording
from core.recording.recorder import LineWriter
from core.recording.summary import HAS_REASONS, ending_of, summarise_recording
from tests.arl_tui.fakes import episode_ended, episode_started, session_ended, step_taken
from tests.core.recording.test_recording import HEADER, press

PLANNED = msgspec.structs.replace(HEADER, protocol={"name": "pilot", "session": {"episodes": 5}})


def recording(*events: Event, complete: bool = True, tail: bytes = b"", **header: object) -> Recording:
    changed = msgspec.structs.replace(PLANNED, **header)
    return Recording(Path("x.jsonl"), changed, events, complete, tail)


GAME = (episode_started(), step_taken(0), episode_ended())


@pytest.mark.parametrize(
    ("reason", "words"),
    [
        ("participant", "stopped by the participant"),
        ("window-closed", "window closed"),
        ("signal", "stopped by a signal"),
        ("worker-died", "worker died"),
        ("time-limit", "time limit reached"),
        ("disk-failed", "disk failed"),
    ],
)
def test_each_reason_to_stop_has_words_of_its_own(reason: StopReason, words: str) -> None:
    ending = ending_of(recording(*GAME, StopAsked(time_ns=9, reason=reason), session_ended(reason)))
    assert ending.kind == reason
    assert ending.words.startswith(words)


def test_the_first_version_of_the_format_does_not_tell_a_closed_window_from_a_stop() -> None:
    events = (*GAME, StopAsked(time_ns=9, reason="participant"), session_ended("participant"))
    words = ending_of(recording(*events)).words
    assert ("version 1 does not tell" in words) == (HEADER.version < HAS_REASONS)


@pytest.mark.parametrize(
    ("made", "kind", "words"),
    [
        (recording(*GAME, session_ended()), "finished", "finished"),
        (recording(*GAME, session_ended(), complete=False), "finished", "the end of the file is missing"),
        (recording(*GAME, complete=False), "killed", "killed, or the copy is not whole: the file has no end"),
        (recording(complete=False), "killed", "killed before the first game"),
        (recording(*GAME, complete=False, tail=b"{"), "cut", "the file ends within a line"),
        (recording(*GAME), "closed", "closed before its end"),
        (recording(*GAME, origin="imported"), "imported", "imported"),
        (
            recording(*GAME, StopAsked(time_ns=9, reason="signal")),
            "signal",
            "stopped by a signal, and the worker gave no answer",
        ),
    ],
)
def test_other_endings_are_told_apart(made: Recording, kind: str, words: str) -> None:
    ending = ending_of(made)
    assert ending.kind == kind
    assert words in ending.words


def test_a_game_that_the_stop_broke_off_is_not_finished() -> None:
    broken_off = msgspec.structs.replace(episode_ended(1), ended="truncation")
    at_its_end = msgspec.structs.replace(episode_ended(1), ended="termination")
    stop = StopAsked(time_ns=9, reason="participant")
    for last, finished in ((broken_off, 1), (at_its_end, 2)):
        held = summarise_recording(recording(*GAME, episode_started(1), stop, last, session_ended()))
        assert (held.games_finished, held.games_begun, held.games_planned) == (finished, 2, 5)


def test_a_game_that_reached_its_longest_time_is_finished() -> None:
    longest: EpisodeEnded = msgspec.structs.replace(episode_ended(), ended="truncation")
    assert summarise_recording(recording(episode_started(), longest, session_ended())).games_finished == 1


def test_presses_that_were_taken_back_do_not_count_and_are_counted_apart() -> None:
    presses: list[KeyPressed] = [press(0), press(1, value=-1.0), press(2, verdict="covered"), press(3)]
    presses[3] = msgspec.structs.replace(presses[3], source="simulated")
    back = PressRetracted(press=1, time_ns=5, reason="participant")
    held = summarise_recording(recording(episode_started(), *presses, back, session_ended()))
    assert (held.presses_counted, held.presses_simulated, held.presses_taken_back) == (2, 1, 1)
    assert "2 presses counted (1 simulated, 1 more taken back)" in held.words


def test_gaps_and_lost_focus_are_counted() -> None:
    events = [TimeGap(last_ns=1, time_ns=9), FocusLost(time_ns=9), FocusRegained(time_ns=10)]
    held = summarise_recording(recording(episode_started(), *events, session_ended()))
    assert (held.gaps, held.focus_lost) == (1, 1)
    assert "the machine stood still 1 time" in held.words


def test_the_line_says_game_protocol_condition_games_presses_and_ending() -> None:
    made = recording(*GAME, session_ended(), source={"condition": "linear"})
    assert summarise_recording(made).words == (
        "tetris, protocol pilot, condition linear; 1 of 5 games finished; 0 presses counted; ended: finished"
    )


def test_an_imported_log_planned_nothing() -> None:
    made = recording(
        *GAME, SessionEnded(time_ns=1, inputs=0, reason="", weights={}, digest=""), origin="imported"
    )
    held = summarise_recording(made)
    assert held.games_planned is None
    assert "; 1 game; " in held.words


@pytest.mark.parametrize("worth_skimming", [0, skim.WORTH_SKIMMING], ids=["skimmed", "read"])
def test_a_session_that_is_being_recorded_was_not_killed(
    worth_skimming: int, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(skim, "WORTH_SKIMMING", worth_skimming)
    writer = LineWriter(tmp_path / "P01.jsonl", HEADER)
    for event in GAME:
        writer.append(event)
    ending = skim.skim_recording(writer.path).summary.ending
    assert (ending.kind, ending.words) == ("running", "not yet, it is being recorded now")
    writer.abandon()
    assert skim.skim_recording(writer.path).summary.ending.kind == "killed"
