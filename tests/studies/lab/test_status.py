"""What an experimenter sees, and what withdrawing removes."""

import os
from datetime import UTC, datetime, timedelta
from pathlib import Path

import msgspec
import pytest

from core.events import KeyPressed, WrongPressAsked
from core.numerics.clock import NS_PER_S, ManualClock
from core.recording.reader import read_recording
from core.recording.recorder import LineWriter
from studies.lab.enrolment import NotNow, begin_sitting, enrol
from studies.lab.folder import exports_folder, participant_folder, sitting_path
from studies.lab.ledger import Declined, Ledger, SittingEnded, StepDone
from studies.lab.minutes import minutes_of
from studies.lab.sitting_log import FileRecorded, QuestionAnswered, SittingLog, StepBegun
from studies.lab.status import _Recordings, instructed_presses, status
from studies.lab.withdraw import drop_out, withdraw
from tests.studies.lab.examples import study_of
from tests.studies.lab.test_sitting_log import HEADER

MORNING = datetime(2026, 11, 28, 9, 0, tzinfo=UTC)
GOLDEN = Path(__file__).parents[3] / "recordings" / "reference" / "tetris-linear-equation-4.jsonl"


@pytest.fixture
def study():
    return study_of()


@pytest.fixture
def ledger(tmp_path, study):
    return Ledger(tmp_path / "data", study=study.name, seed=study.seed)


def begin(study, ledger, code="A", minutes=0):
    enrol(study, ledger, code, now=MORNING)
    begin_sitting(study, ledger, code, now=MORNING)
    later = (MORNING + timedelta(minutes=minutes)).isoformat()
    ledger.append(StepDone(code=code, sitting=0, step=0, at_utc=later))


def sitting_file(ledger, *lines, code="A"):
    with SittingLog(sitting_path(ledger.folder, code, 0, 0), HEADER, clock=ManualClock()) as log:
        for line in lines:
            log.write(line)


def row_of(study, ledger):
    return status(study, ledger.folder, MORNING).rows[0]


def test_a_running_participant_is_shown_with_step_and_minutes(study, ledger):
    begin(study, ledger, minutes=7)
    row = row_of(study, ledger)
    assert (row.state, row.where, row.minutes) == ("active", "day 1: step 2 of 4 (block)", 7.0)


def test_a_sitting_that_broke_off_is_pointed_out(study, ledger):
    begin(study, ledger)
    sitting_file(ledger)
    path = sitting_path(ledger.folder, "A", 0, 0)
    os.utime(path, (MORNING.timestamp(),) * 2)
    row = status(study, ledger.folder, MORNING + timedelta(minutes=42)).rows[0]
    assert row.flags == ("no sign of life for 42 minutes: did the sitting break off?",)
    ledger.append(SittingEnded(code="A", sitting=0, how="window-closed", at_utc=MORNING.isoformat()))
    row = status(study, ledger.folder, MORNING + timedelta(minutes=42)).rows[0]
    assert (row.where, row.flags) == ("day 1: step 2 of 4 (block), window closed", ())


def test_minutes_are_those_of_every_attempt_and_of_a_session_that_broke_off(study, ledger):
    """Two attempts: 3 minutes and a session of the golden recording, and 4 minutes to a proper end."""
    begin(study, ledger)
    folder, minute = participant_folder(ledger.folder, "A"), 60 * NS_PER_S
    first = msgspec.structs.replace(HEADER, at_utc="2026-11-28T09:00:00+00:00", started_ns=7)
    with SittingLog(sitting_path(ledger.folder, "A", 0, 0), first, clock=ManualClock()) as log:
        log.write(StepBegun(step=1, kind="block", time_ns=7 + 3 * minute))
    golden = read_recording(GOLDEN)
    header = msgspec.structs.replace(
        golden.header, created_utc="2026-11-28T09:03:00+00:00", study={"kind": "block"}
    )
    writer = LineWriter(folder / GOLDEN.name, header)
    for event in golden.events:
        writer.append(event)
    writer.close()
    second = msgspec.structs.replace(first, at_utc="2026-11-28T10:00:00+00:00", attempt=1)
    with SittingLog(sitting_path(ledger.folder, "A", 0, 1), second, clock=ManualClock(7 + 4 * minute)) as log:
        log.close("finished")
    session = (golden.events[-1].time_ns - header.started_ns) / minute
    assert minutes_of(folder) == pytest.approx(7 + session)
    assert row_of(study, ledger).minutes == pytest.approx(7 + session)


def test_finishers_are_counted_by_order_and_decliners_only_counted(study, ledger):
    begin(study, ledger)
    ledger.append(SittingEnded(code="A", sitting=0, how="finished", at_utc=MORNING.isoformat()))
    ledger.append(Declined())
    found = status(study, ledger.folder, MORNING)
    assert (found.finished, found.declined) == (1, 1)
    assert dict(found.orders)[found.rows[0].order] == 1
    assert sum(count for _, count in found.orders) == 1


def test_presses_are_counted_from_the_recordings(study, ledger):
    begin(study, ledger)
    sitting_file(
        ledger, FileRecorded(step=1, kind="block", file=GOLDEN.name, condition="c0", ended="finished")
    )
    golden = read_recording(GOLDEN)
    header = msgspec.structs.replace(golden.header, study={"kind": "block", "condition": "c0"})
    writer = LineWriter(participant_folder(ledger.folder, "A") / GOLDEN.name, header)
    for event in golden.events:
        writer.append(event)
    writer.close()
    row = row_of(study, ledger)
    assert row.games > 0
    assert row.presses_per_game > 0
    assert row.flags == ()


def test_a_damaged_file_and_a_failed_attention_check_are_pointed_out(study, ledger):
    begin(study, ledger)
    failed = QuestionAnswered(
        step=2, questionnaire="q", question="check", answer=1, shown_ns=0, answered_ns=1, passed=False
    )
    sitting_file(
        ledger,
        failed,
        FileRecorded(step=1, kind="block", file="gone.jsonl", condition="c0", ended="finished"),
    )
    flags = row_of(study, ledger).flags
    assert any(flag.startswith("damaged file: gone.jsonl") for flag in flags)
    assert "failed attention checks: 1" in flags


def test_withdrawing_removes_every_file_and_leaves_a_number(study, ledger):
    begin(study, ledger, "SECRET")
    begin(study, ledger, "B")
    sitting_file(ledger, code="SECRET")
    sitting_file(ledger, code="B")
    exports_folder(ledger.folder).mkdir()
    (exports_folder(ledger.folder) / "presses.csv").write_text("participant\nSECRET\nB\n")
    tombstone = withdraw(ledger, "SECRET")
    assert (tombstone.code, tombstone.files_removed) == ("withdrawn-1", 2)
    left = [path for path in ledger.folder.rglob("*") if path.is_file()]
    assert not any("SECRET" in str(path) or b"SECRET" in path.read_bytes() for path in left)
    assert participant_folder(ledger.folder, "B").exists()
    assert [row.state for row in status(study, ledger.folder, MORNING).rows] == ["withdrawn", "active"]


def test_a_withdrawal_that_was_interrupted_can_be_finished(study, ledger, monkeypatch):
    begin(study, ledger, "SECRET")
    sitting_file(ledger, code="SECRET")
    with monkeypatch.context() as patch:
        patch.setattr(
            Ledger, "replace_code", lambda *args, **kwargs: (_ for _ in ()).throw(KeyboardInterrupt)
        )
        with pytest.raises(KeyboardInterrupt):
            withdraw(ledger, "SECRET")
    assert withdraw(ledger, "SECRET").code == "withdrawn-1"


def test_nobody_withdraws_twice(study, ledger):
    begin(study, ledger)
    withdraw(ledger, "A")
    with pytest.raises(NotNow, match="nobody with the code A"):
        withdraw(ledger, "A")


def test_instructed_presses_are_counted_and_too_few_pointed_out():
    pressed = {
        "press": 0,
        "time_ns": 5,
        "frame": 0,
        "step": 0,
        "key": "f",
        "verdict": "accepted",
        "value": -1.0,
    }
    asked = [WrongPressAsked(time_ns=k, step=k) for k in range(4)]
    followed, own = KeyPressed(**pressed, asked_wrong=True), KeyPressed(**pressed)
    assert instructed_presses([*asked, followed, own]) == (4, 1)
    looked_at = _Recordings(Path("nowhere"))
    looked_at.wrong_asked, looked_at.wrong_given = 4, 1
    assert "instructed presses: 1 of 4 were given" in list(looked_at.flags())
    looked_at.wrong_given = 2
    assert not any("instructed" in flag for flag in looked_at.flags())


def test_a_sitting_whose_record_is_gone_is_pointed_out(study, ledger):
    begin(study, ledger)
    assert status(study, ledger.folder, MORNING).rows[0].flags == (
        "the record of sitting 1 is gone: is there a copy of A's folder?",
    )
    sitting_file(ledger)
    assert status(study, ledger.folder, MORNING).rows[0].flags == ()


def test_only_who_is_still_expected_drops_out(study, ledger):
    with pytest.raises(NotNow, match="nobody with the code A"):
        drop_out(study, ledger, "A", "ill")
    begin(study, ledger)
    drop_out(study, ledger, "A", "ill")
    with pytest.raises(NotNow, match=r"A counts as dropped out already \(ill\)"):
        drop_out(study, ledger, "A", "ill")
    begin(study, ledger, "B")
    ledger.append(SittingEnded(code="B", sitting=0, how="finished"))
    with pytest.raises(NotNow, match="B has finished and keeps the place"):
        drop_out(study, ledger, "B", "ill")


def test_sittings_that_another_study_file_has_led_are_pointed_out(study, ledger):
    begin(study, ledger)
    sitting_file(ledger)

    def flags(sha256: str) -> tuple[str, ...]:
        return status(study, ledger.folder, MORNING, sha256=sha256).rows[0].flags

    assert flags(HEADER.study_sha256) == ()
    (flag,) = flags("1" * 64)
    assert "another study file, of version 1 (now 1)" in flag
