import msgspec
import pytest

from core.numerics.clock import NS_PER_MS, ManualClock
from studies.reaction_time.protocol import TaskConfig, TrialRecord
from studies.reaction_time.schedule import make_schedule
from studies.reaction_time.trial import Trial
from studies.reaction_time.trial_log import TrialFileError, TrialHeader, TrialWriter, read_trials
from tests.full_disk import files_end_at

SCHEDULE = make_schedule(TaskConfig(n_practice=2, n_trials=4, catch_rate=0.0), 1)
HEADER = TrialHeader(participant="P01", created_utc="2026-03-01T10:00:00+00:00", schedule=SCHEDULE)


def played(index: int, rt_ms: int = 300) -> TrialRecord:
    """Run a trial with a response after rt_ms."""
    clock = ManualClock()
    plan = SCHEDULE.trials[index]
    trial = Trial(plan, SCHEDULE.block_of(index), SCHEDULE, clock)
    clock.advance_ns(150 * NS_PER_MS)
    trial.poll()
    clock.advance_ns(round(plan.foreperiod_s * 1e9))
    trial.poll()
    trial.flushed(clock.now_ns())
    clock.advance_ns(rt_ms * NS_PER_MS)
    trial.pressed("space", clock.now_ns())
    return trial.record


def test_a_session_is_read_back_as_it_was_written(tmp_path):
    path = tmp_path / "P01.jsonl"
    records = tuple(played(i, 300 + i) for i in range(6))
    with TrialWriter.create(path, HEADER) as writer:
        for record in records:
            writer.write(record)
    session = read_trials(path)
    assert (session.header, session.trials, session.torn_line) == (HEADER, records, False)
    assert session.next_trial == 6


def test_each_trial_is_on_the_disk_when_write_returns(tmp_path):
    writer = TrialWriter.create(tmp_path / "a.jsonl", HEADER)
    writer.write(played(0))
    assert len(read_trials(tmp_path / "a.jsonl").trials) == 1
    writer.close()


def test_a_trial_that_the_disk_does_not_take_leaves_room_for_the_next(tmp_path):
    path = tmp_path / "a.jsonl"
    with TrialWriter.create(path, HEADER) as writer:
        with files_end_at(path.stat().st_size + 50), pytest.raises(OSError, match="too large"):
            writer.write(played(0))
        writer.write(played(0))
    assert read_trials(path).trials == (played(0),)
    with files_end_at(50), pytest.raises(OSError, match="too large"):
        TrialWriter.create(tmp_path / "none.jsonl", HEADER)
    assert not (tmp_path / "none.jsonl").exists()


def test_an_existing_file_is_never_overwritten(tmp_path):
    path = tmp_path / "a.jsonl"
    path.write_text("something")
    with pytest.raises(FileExistsError):
        TrialWriter.create(path, HEADER)
    assert path.read_text() == "something"


def start(tmp_path, n=3, tail=b""):
    path = tmp_path / "a.jsonl"
    with TrialWriter.create(path, HEADER) as writer:
        for i in range(n):
            writer.write(played(i))
    with path.open("ab") as file:
        file.write(tail)
    return path


def test_a_stopped_session_goes_on_where_it_stopped(tmp_path):
    path = start(tmp_path)
    writer, session = TrialWriter.resume(path, now_utc="2026-03-01T10:30:00+00:00")
    assert session.next_trial == 3
    with writer:
        writer.write(played(3))
    assert [record.trial for record in read_trials(path).trials] == [0, 1, 2, 3]


def test_a_line_cut_off_in_writing_is_told_and_its_trial_is_run_again(tmp_path):
    path = start(tmp_path, tail=b'{"trial":3,"blo')
    assert read_trials(path).torn_line
    writer, session = TrialWriter.resume(path, now_utc="2026-03-01T10:30:00+00:00")
    assert session.next_trial == 3
    with writer:
        writer.write(played(3))
    whole = read_trials(path)
    assert not whole.torn_line
    assert [record.trial for record in whole.trials] == [0, 1, 2, 3]


def test_a_day_old_half_session_is_not_resumed_silently(tmp_path):
    path = start(tmp_path)
    with pytest.raises(TrialFileError, match=r"began 25 hours ago .*say explicitly"):
        TrialWriter.resume(path, now_utc="2026-03-02T11:00:00+00:00")
    writer, session = TrialWriter.resume(path, now_utc="2026-03-02T11:00:00+00:00", despite_age=True)
    writer.close()
    assert session.next_trial == 3


def test_a_complete_session_is_not_resumed(tmp_path):
    with pytest.raises(TrialFileError, match="all 6 trials are done"):
        TrialWriter.resume(start(tmp_path, 6), now_utc="2026-03-01T10:30:00+00:00")


def test_an_abandoned_trial_is_run_again(tmp_path):
    path = tmp_path / "a.jsonl"
    with TrialWriter.create(path, HEADER) as writer:
        writer.write(played(0))
        writer.write(msgspec.structs.replace(played(1), comment="abandoned: stop key"))
    assert read_trials(path).next_trial == 1


@pytest.mark.parametrize(
    ("content", "message"),
    [
        (b"", "no complete header"),
        (b"{}\n", ":1: not a header"),
        (b"a,b\n1,2\n", ":1: not a header"),
        (msgspec.json.encode(HEADER) + b"\n{}\n", ":2: not a trial"),
        (msgspec.json.encode(msgspec.structs.replace(HEADER, version=9)) + b"\n", "version 9"),
    ],
)
def test_a_file_that_is_no_session_says_where_and_why(tmp_path, content, message):
    path = tmp_path / "a.jsonl"
    path.write_bytes(content)
    with pytest.raises(TrialFileError, match=message):
        read_trials(path)
