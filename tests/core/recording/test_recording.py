"""Recordings: what is written is read back; what is damaged is found."""

import errno
import hashlib
import json
import os
import signal
import subprocess
import sys
import threading
import time

import pytest
from hypothesis import given
from hypothesis import strategies as st

from core.events import EpisodeEnded, FrameShown, KeyPressed
from core.recording.reader import RecordingError, read_recording
from core.recording.recorder import Kept, LineWriter, Recorder
from core.recording.schema import VERSION, Header

HEADER = Header(
    origin="live",
    created_utc="2026-11-22T10:00:00+00:00",
    clock="monotonic",
    clock_resolution_ns=1,
    started_ns=17,
    participant="P01",
    root_seed=3,
    protocol={"name": "default"},
    software={"arl-tui": "0.1.0"},
)


def press(number: int, **changes) -> KeyPressed:
    settings = {
        "press": number,
        "time_ns": 10**9 * number,
        "key": "j",
        "value": 1.0,
        "frame": number,
        "step": number,
        "verdict": "accepted",
    }
    return KeyPressed(**settings | changes)


EVENTS = [FrameShown(frame=0, step=0, flushed_ns=5), press(0), press(1, key="x", value=None, verdict="other")]


@pytest.fixture
def path(tmp_path):
    path = tmp_path / "session.jsonl"
    with Recorder(path, HEADER) as recorder:
        for event in EVENTS:
            recorder.record(event)
    return path


def test_what_is_recorded_is_read_back(path):
    recording = read_recording(path)
    assert recording.header == HEADER
    assert list(recording.events) == EVENTS
    assert recording.complete
    assert recording.lost_tail == b""


def test_an_existing_recording_is_never_overwritten(path):
    before = path.read_bytes()
    with pytest.raises(FileExistsError):
        Recorder(path, HEADER)
    assert path.read_bytes() == before


def test_every_line_is_plain_json_whose_chain_anybody_can_recompute(path):
    running = hashlib.sha256()
    for line in path.read_text().splitlines():
        record = json.loads(line)
        payload = line[: line.rindex(',"chain"')] + "}"
        running.update(payload.encode())
        assert record["chain"] == running.hexdigest()[:16]


def test_inputs_and_outputs_are_told_apart(tmp_path):
    ended = EpisodeEnded(
        episode=0,
        time_ns=9,
        inputs=3,
        performance=2.0,
        steps=4,
        ended="termination",
        agreed=1,
        agreed_worst=0,
        trust=0.5,
        digest="ab",
    )
    writer = LineWriter(tmp_path / "a.jsonl", HEADER)
    for event in [*EVENTS, ended]:
        writer.write(event)
    writer.close()
    recording = read_recording(writer.path)
    assert recording.inputs == tuple(EVENTS)
    assert recording.outputs == (ended,)


def test_a_session_that_was_cut_off_is_read_up_to_its_last_whole_line(path):
    lines = path.read_bytes().splitlines(keepends=True)
    path.write_bytes(b"".join(lines[:3]) + lines[3][:20])
    recording = read_recording(path)
    assert not recording.complete
    assert list(recording.events) == EVENTS[:2]
    assert recording.lost_tail == lines[3][:20]


def test_a_session_that_was_cut_off_can_be_refused(path):
    path.write_bytes(b"".join(path.read_bytes().splitlines(keepends=True)[:3]))
    with pytest.raises(RecordingError, match=r"session.jsonl:3: no end line; .* after 2 events. Use"):
        read_recording(path, allow_truncated=False)


@given(line=st.integers(0, 4), data=st.data())
def test_a_changed_line_is_found_where_it_stands(tmp_path_factory, line, data):
    path = tmp_path_factory.mktemp("damage") / "session.jsonl"
    with Recorder(path, HEADER) as recorder:
        for event in EVENTS:
            recorder.record(event)
    lines = path.read_bytes().splitlines(keepends=True)
    position = data.draw(st.integers(0, len(lines[line]) - 2))
    old = lines[line][position]
    new = data.draw(st.integers(32, 126).filter(lambda byte: byte != old))
    lines[line] = lines[line][:position] + bytes([new]) + lines[line][position + 1 :]
    path.write_bytes(b"".join(lines))
    with pytest.raises(RecordingError, match=rf"session.jsonl:{line + 1}: "):
        read_recording(path)


@pytest.mark.parametrize("change", ["removed", "doubled", "exchanged"])
def test_a_lost_doubled_or_exchanged_line_is_found(path, change):
    lines = path.read_bytes().splitlines(keepends=True)
    lines[1:3] = {"removed": lines[2:3], "doubled": [lines[1], lines[1]], "exchanged": [lines[2], lines[1]]}[
        change
    ]
    path.write_bytes(b"".join(lines))
    with pytest.raises(RecordingError, match="does not follow from the lines before it"):
        read_recording(path)


def test_a_line_behind_the_end_is_found(path):
    with path.open("ab") as file:
        file.write(path.read_bytes().splitlines(keepends=True)[1])
    with pytest.raises(RecordingError, match="behind the end line"):
        read_recording(path)


@pytest.mark.parametrize("content", [b"", b"hello", b"hello\n", b'{"a":1}\n', b"\x00\xff\n"])
def test_another_file_is_not_taken_for_a_recording(tmp_path, content):
    path = tmp_path / "other.jsonl"
    path.write_bytes(content)
    with pytest.raises(RecordingError, match=r"other\.jsonl"):
        read_recording(path)


def test_a_newer_format_is_refused_with_both_versions(path):
    writer = LineWriter(path.with_name("new.jsonl"), HEADER)
    writer.close()
    now, later = f'"version":{VERSION}'.encode(), f'"version":{VERSION + 1}'.encode()
    payload = path.read_bytes().splitlines()[0].replace(now, later)
    payload = payload[: payload.rindex(b',"chain"')] + b"}"
    chain = hashlib.sha256(payload).hexdigest()[:16].encode()
    path.write_bytes(payload[:-1] + b',"chain":"' + chain + b'"}\n')
    both = (
        f"version {VERSION + 1} of the format, newer than this program, which reads up to version {VERSION}"
    )
    with pytest.raises(RecordingError, match=both):
        read_recording(path)


def test_a_full_disk_is_reported_and_no_event_is_lost(tmp_path, monkeypatch):
    recorder = Recorder(tmp_path / "session.jsonl", HEADER)

    def full(event):
        raise OSError(errno.ENOSPC, "No space left on device")

    monkeypatch.setattr(recorder._writer, "append", full)
    for event in EVENTS:
        recorder.record(event)
    with pytest.raises(OSError, match="No space left"):
        recorder.close()
    assert recorder.unwritten == EVENTS
    assert not read_recording(recorder.path).complete


WRITE_FOREVER = """
import sys
import threading
from pathlib import Path
from core.recording.recorder import Recorder
from tests.core.recording.test_recording import HEADER, press
recorder = Recorder(Path(sys.argv[1]), HEADER)
number = 0
while True:
    recorder.record(press(number))
    number += 1
"""


def test_a_killed_writer_leaves_whole_lines(tmp_path):
    path = tmp_path / "session.jsonl"
    writer = subprocess.Popen([sys.executable, "-c", WRITE_FOREVER, str(path)])
    deadline = time.monotonic() + 600
    while time.monotonic() < deadline and (not path.exists() or path.stat().st_size < 20_000):
        time.sleep(0.01)
    os.kill(writer.pid, signal.SIGKILL)
    writer.wait()
    recording = read_recording(path)
    assert not recording.complete
    assert [event.press for event in recording.events] == list(range(len(recording.events)))
    assert len(recording.events) > 50


class FullAfter:
    """A file on a disk that takes so many bytes more, the last write only in part."""

    def __init__(self, file, room):
        self.file, self.room = file, room

    def write(self, part):
        if not self.room:
            self.fail()
        taken = self.file.write(part[: self.room])
        self.room -= taken
        return taken

    def fail(self):
        raise OSError(errno.ENOSPC, "No space left on device")

    def __getattr__(self, name):
        return getattr(self.file, name)


@pytest.mark.parametrize("room", [0, 1, 100, 300])
def test_a_line_that_fits_in_part_is_taken_out_again_and_kept_elsewhere(tmp_path, room):
    recorder = Recorder(tmp_path / "session.jsonl", HEADER)
    recorder._writer._file = FullAfter(recorder._writer._file, room)
    for event in EVENTS:
        recorder.record(event)
    with pytest.raises(OSError, match="No space left"):
        recorder.close()
    recording = read_recording(recorder.path)
    assert recording.lost_tail == b""
    assert [*recording.events, *recorder.unwritten] == EVENTS
    assert recorder.kept.written == len(recording.events)


FAULTS = ["EROFS", "EDQUOT", "ENOSPC", "EIO", "ESTALE"]
"""Made read-only, quota, full, broken, a server that has forgotten the file."""


@pytest.mark.parametrize("fault", FAULTS)
@pytest.mark.parametrize("where", ["write", "write and cut", "sync"])
def test_whatever_a_disk_fails_with_is_told_at_once_and_no_event_is_lost(tmp_path, monkeypatch, fault, where):
    def fail(*_):
        raise OSError(getattr(errno, fault), os.strerror(getattr(errno, fault)))

    recorder = Recorder(tmp_path / "session.jsonl", HEADER)
    for number in range(3):
        recorder.record(press(number))
    deadline = time.monotonic() + 60
    while recorder.kept.synced < 3 and time.monotonic() < deadline:
        time.sleep(0.01)
    told = threading.Event()
    recorder._on_news = lambda: told.set() if recorder.failure else None
    if where == "sync":
        monkeypatch.setattr(recorder._writer, "sync", fail)
    else:
        recorder._writer._file = FullAfter(recorder._writer._file, room=100)
        recorder._writer._file.fail = fail
    if where == "write and cut":
        monkeypatch.setattr(os, "ftruncate", fail)
    recorder.record(press(3))
    assert told.wait(timeout=1.0)
    confirmed = recorder.written
    recorder.record(press(4))
    with pytest.raises(OSError, match=os.strerror(getattr(errno, fault))):
        recorder.close()
    assert recorder.written == confirmed == (4 if where == "sync" else 3)
    assert recorder.kept.synced == 3
    assert recorder.unwritten == [press(3), press(4)]
    assert list(read_recording(recorder.path).events)[:3] == [press(number) for number in range(3)]


@pytest.mark.parametrize("moved", [False, True])
def test_a_file_that_is_removed_is_noticed_and_its_content_is_not_lost(tmp_path, moved):
    recorder = Recorder(tmp_path / "session.jsonl", HEADER)
    recorder.record(EVENTS[0])
    if moved:
        recorder.path.rename(tmp_path / "elsewhere.jsonl")
    else:
        recorder.path.unlink()
    deadline = time.monotonic() + 60
    while recorder.failure is None and time.monotonic() < deadline:
        time.sleep(0.01)
    recorder.record(EVENTS[1])
    with pytest.raises(FileNotFoundError, match="removed or moved during the session"):
        recorder.close()
    (tmp_path / "saved.jsonl").write_bytes(recorder.content())
    recording = read_recording(tmp_path / "saved.jsonl")
    assert recording.complete
    assert list(recording.events) == EVENTS[:2]


def test_events_are_written_while_the_disk_is_still_syncing_earlier_ones(tmp_path, monkeypatch):
    may_go_on = threading.Event()
    news = threading.Semaphore(0)
    recorder = Recorder(tmp_path / "session.jsonl", HEADER, on_news=news.release)
    sync = recorder._writer.sync
    monkeypatch.setattr(recorder._writer, "sync", lambda: (may_go_on.wait(60), sync()))
    for number in range(5):
        recorder.record(press(number))
    for _ in range(5):
        assert news.acquire(timeout=60)
    assert recorder.kept == Kept(recorded=5, written=5, synced=0)
    assert len(read_recording(recorder.path).events) == 5
    with pytest.raises(TimeoutError, match="did not confirm"):
        recorder.close(timeout_s=0.05)
    assert recorder.unwritten == []
    assert recorder.unsynced_s() > 0
    may_go_on.set()
    recorder._sync_thread.join(60)
    assert recorder.kept.synced == 5
    recorder._writer.abandon()


def test_what_a_disk_that_hangs_in_a_write_has_not_taken_is_handed_back(tmp_path, monkeypatch):
    may_go_on = threading.Event()
    recorder = Recorder(tmp_path / "session.jsonl", HEADER)
    append = recorder._writer.append
    monkeypatch.setattr(recorder._writer, "append", lambda event: (may_go_on.wait(60), append(event)))
    for event in EVENTS:
        recorder.record(event)
    with pytest.raises(TimeoutError, match="did not take"):
        recorder.close(timeout_s=0.05)
    assert recorder.unwritten == EVENTS
    may_go_on.set()
    recorder._write_thread.join(60)
    recorder._sync_thread.join(60)
    recorder._writer.abandon()
