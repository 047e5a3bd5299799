"""The record of a sitting: every line is on the disk, and a changed one is named."""

import hashlib

import pytest

from core.numerics.clock import ManualClock
from studies.lab.sealed import SealedFileError
from studies.lab.sitting_log import (
    ConsentAnswered,
    QuestionAnswered,
    SittingClosed,
    SittingHeader,
    SittingLog,
    read_sitting,
)
from tests.full_disk import files_end_at

HEADER = SittingHeader(
    study="small",
    study_version="1",
    study_sha256="0" * 64,
    participant="P7QX",
    simulated=False,
    place=0,
    order=("a", "b"),
    sitting=0,
    attempt=0,
    at_utc="2026-11-28T09:00:00+00:00",
    started_ns=0,
    software={},
)
CONSENT = ConsentAnswered(
    step=0,
    text="# Consent",
    text_version="1",
    text_sha256=hashlib.sha256(b"# Consent").hexdigest(),
    answers={"I agree": True},
    at_utc="2026-11-28T09:01:00+00:00",
    time_ns=60_000_000_000,
)


@pytest.fixture
def path(tmp_path):
    return tmp_path / "P7QX" / "sitting-1.jsonl"


def test_a_line_that_the_disk_does_not_take_leaves_room_for_the_next(path):
    with SittingLog(path, HEADER, clock=ManualClock()) as log:
        length = path.stat().st_size
        with files_end_at(length + 50), pytest.raises(OSError, match="too large"):
            log.write(CONSENT)
        assert path.stat().st_size == length
        log.write(CONSENT)
        log.close("failed")
    assert read_sitting(path)[1][0] == CONSENT
    assert len(read_sitting(path)[1]) == 2


def test_no_record_without_a_header_is_left(path):
    with files_end_at(50), pytest.raises(OSError, match="too large"):
        SittingLog(path, HEADER)
    assert list(path.parent.iterdir()) == []


def test_what_was_written_is_read_back(path):
    answers = [
        QuestionAnswered(
            step=1, questionnaire="q", question=f"q{k}", answer=answer, shown_ns=1, answered_ns=2
        )
        for k, answer in enumerate((3, 2.5, "yes", ("a", "b"), None))
    ]
    with SittingLog(path, HEADER, clock=ManualClock(5)) as log:
        for line in (CONSENT, *answers):
            log.write(line)
        log.close("finished")
    header, lines = read_sitting(path)
    assert header == HEADER
    assert lines[:-1] == (CONSENT, *answers)
    assert isinstance(lines[-1], SittingClosed)


def test_a_line_is_there_before_the_log_is_closed(path):
    log = SittingLog(path, HEADER)
    log.write(CONSENT)
    assert read_sitting(path)[1] == (CONSENT,)
    log.abandon()


def test_an_existing_file_is_never_touched(path):
    SittingLog(path, HEADER).abandon()
    before = path.read_bytes()
    with pytest.raises(FileExistsError):
        SittingLog(path, HEADER)
    assert path.read_bytes() == before


def test_a_changed_consent_is_named(path):
    with SittingLog(path, HEADER) as log:
        log.write(CONSENT)
    path.write_bytes(path.read_bytes().replace(b'"I agree":true', b'"I agree":fals'))
    with pytest.raises(SealedFileError, match=r"sitting-1\.jsonl:2: this line was changed"):
        read_sitting(path)


def test_only_the_owner_can_read_it(path):
    SittingLog(path, HEADER).abandon()
    assert path.stat().st_mode & 0o077 == 0
    assert path.parent.stat().st_mode & 0o077 == 0
