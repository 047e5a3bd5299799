"""Running sittings, from their files alone; notes of the experimenter."""

from datetime import UTC, datetime
from pathlib import Path

import msgspec
import pytest

from core.events import EpisodeStarted, FocusLost, KeyPressed, PressRetracted
from core.recording.reader import Recording, read_recording
from core.recording.recorder import LineWriter
from studies.lab.enrolment import NotNow, begin_sitting, enrol
from studies.lab.folder import participant_folder
from studies.lab.ledger import Ledger, SittingEnded
from studies.lab.notes import add_note, read_notes
from studies.lab.progress import progress
from studies.lab.running import only_sitting
from studies.lab.sealed import SealedFileError
from studies.lab.watching import Watch
from studies.lab.withdraw import withdraw
from tests.studies.lab.examples import study_of

MORNING = datetime(2026, 11, 28, 9, 0, tzinfo=UTC)
GOLDEN = Path(__file__).parents[3] / "recordings" / "reference" / "tetris-linear-equation-4.jsonl"


@pytest.fixture
def study():
    return study_of()


@pytest.fixture
def ledger(tmp_path, study):
    ledger = Ledger(tmp_path / "data", study=study.name, seed=study.seed)
    enrol(study, ledger, "A", now=MORNING)
    begin_sitting(study, ledger, "A", now=MORNING)
    return ledger


@pytest.fixture(scope="module")
def golden() -> Recording:
    return read_recording(GOLDEN)


def watched(watch, ledger, path, later_s=0.0):
    now_s = path.stat().st_mtime + later_s
    return watch.rows(progress(ledger.lines()), now_s)


def test_it_sees_what_is_added_to_a_file(study, ledger, golden):
    path = participant_folder(ledger.folder, "A") / "A-1.jsonl"
    writer = LineWriter(path, golden.header)
    watch = Watch(study, ledger.folder)
    for n_events in (0, len(golden.events) // 2, len(golden.events) - 1):
        for event in golden.events[writer._events : n_events]:
            writer.append(event)
        (row,) = watched(watch, ledger, path)
        so_far = golden.events[:n_events]
        taken_back = {event.press for event in so_far if isinstance(event, PressRetracted)}
        assert row.session.games == sum(isinstance(event, EpisodeStarted) for event in so_far)
        assert len(row.session.presses) == sum(
            isinstance(event, KeyPressed) and event.verdict == "accepted" and event.press not in taken_back
            for event in so_far
        )
        assert row.where == "day 1: step 1 of 4 (consent)"
    assert row.session.lag_ms is not None
    writer.append(FocusLost(time_ns=row.session.last_ns + 1))
    (row,) = watched(watch, ledger, path, later_s=30.0)
    assert "the window does not have the keyboard" in row.warnings
    assert any("no sign of life for 30 s" in warning for warning in row.warnings)
    before = path.read_bytes()
    watched(watch, ledger, path)
    assert path.read_bytes() == before
    writer.abandon()


def test_a_line_that_is_being_written_is_taken_when_it_is_whole(study, ledger, golden):
    path = participant_folder(ledger.folder, "A") / "A-1.jsonl"
    path.parent.mkdir(parents=True)
    writer = LineWriter(ledger.folder / "whole.jsonl", golden.header)
    for event in golden.events:
        writer.append(event)
    writer.close()
    content = writer.path.read_bytes()
    watch = Watch(study, ledger.folder)
    games = 0
    for end in (*range(1000, len(content), 997), len(content)):
        path.write_bytes(content[:end])
        (row,) = watched(watch, ledger, path)
        games = row.session.games if row.session is not None else games
    assert games == sum(isinstance(event, EpisodeStarted) for event in golden.events)
    assert row.session is None  # the session is over


def test_a_sitting_that_has_ended_is_not_running(study, ledger):
    ledger.append(SittingEnded(code="A", sitting=0, how="finished", at_utc=MORNING.isoformat()))
    assert Watch(study, ledger.folder).rows(progress(ledger.lines()), 0.0) == ()


def test_notes_are_kept_with_times_and_running_participants(tmp_path):
    assert read_notes(tmp_path) == ()
    add_note(tmp_path, "door opened", ("A",))
    add_note(tmp_path, "fire alarm")
    assert [(note.text, note.running) for note in read_notes(tmp_path)] == [
        ("door opened", ("A",)),
        ("fire alarm", ()),
    ]
    path = tmp_path / "notes.jsonl"
    path.write_bytes(path.read_bytes() + b'{"torn')  # its writer was killed
    add_note(tmp_path, "again")
    assert [note.text for note in read_notes(tmp_path)] == ["door opened", "fire alarm", "again"]
    path.write_bytes(path.read_bytes().replace(b"door", b"roof"))
    with pytest.raises(SealedFileError, match=r"notes\.jsonl:1: this line was changed"):
        read_notes(tmp_path)


def test_a_participant_who_withdraws_is_not_in_the_notes_any_more(ledger):
    add_note(ledger.folder, "SECRET fell asleep", ("A",))
    add_note(ledger.folder, "A asked twice", ("A",))
    withdraw(ledger, "A")
    assert [note.running for note in read_notes(ledger.folder)] == [("withdrawn-1",)] * 2
    assert read_notes(ledger.folder)[1].text == "withdrawn-1 asked twice"


def test_one_sitting_at_a_time(tmp_path):
    with (
        only_sitting(tmp_path, "A"),
        pytest.raises(NotNow, match="a sitting of A is running already"),
        only_sitting(tmp_path, "A"),
    ):
        pass
    with only_sitting(tmp_path, "A"):
        pass


def test_nobody_withdraws_during_their_sitting(ledger):
    with (
        only_sitting(participant_folder(ledger.folder, "A"), "A"),
        pytest.raises(NotNow, match="is running already"),
    ):
        withdraw(ledger, "A")
    assert msgspec.structs.asdict(ledger.lines()[-1])["code"] == "A"
