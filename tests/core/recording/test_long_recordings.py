"""Recordings of hours: listed without decoding every line, replayed in a time that grows with their length
alone."""

import bz2
import gzip
import json
import lzma
import time
import tracemalloc
from pathlib import Path

import msgspec
import pytest

from core.events import Output
from core.recording import reader, sealed, skim, undo
from core.recording.chain import Chain
from core.recording.joined import read_session
from core.recording.reader import Recording, RecordingError, read_recording
from core.recording.recorder import write_recording
from core.recording.schema import Resumes
from core.recording.skim import skim_recording
from core.recording.summary import summarise_recording
from core.session.replay import replay_exactly
from tests.fuzz.mutate import resealed
from tests.studies.session_view.made import large

REFERENCE = Path(__file__).resolve().parents[3] / "recordings" / "reference"
FILES = sorted(REFERENCE.rglob("*.jsonl"))
ORIGINAL = FILES[-1]


class Again:
    """A session that says what was recorded, and takes in what was given."""

    def __init__(self, recording: Recording) -> None:
        self._recording = recording

    def run(self, source, clock):
        for output in self._recording.outputs:
            list(source.during(0))
            yield output


def long(recording: Recording, n_events: int) -> Recording:
    """A recording with so many more frames and credits that one pass is fast, and a pass per output is
    not."""
    events = list(recording.events)
    first = next(n for n, event in enumerate(events) if isinstance(event, Output) and event.inputs > 0)
    credit = next(event for event in events if event.__class__.__name__ == "CreditGiven")
    events[first:first] = [credit] * n_events
    return Recording(recording.path, recording.header, tuple(events), recording.complete)


def test_the_time_of_a_replay_grows_with_the_number_of_outputs():
    recording = long(read_recording(REFERENCE / "tetris-linear-equation-4.jsonl"), 200_000)
    told: list[int] = []
    before = time.process_time()
    result = replay_exactly(recording, Again(recording), on_progress=told.append)
    assert time.process_time() - before < 10.0  # copying the rest at each output took minutes
    assert result.difference is None
    assert result.outputs == len(recording.outputs)
    assert sum(told) == result.outputs // 1000 * 1000


def resumed(folder: Path) -> Path:
    """Write a session in two files, cut in the middle, and return the newer one."""
    recording = read_recording(ORIGINAL)
    cut = len(recording.events) // 2
    older, newer = folder / "older.jsonl", folder / "newer.jsonl"
    write_recording(older, recording.header, recording.events[:cut])
    before = read_recording(older)
    resumes = Resumes(
        file=older.name,
        chain=before.chain,
        inputs=len(before.inputs),
        outputs=len(before.outputs),
        shift_ns=-5,
    )
    header = msgspec.structs.replace(recording.header, resumes=resumes)
    write_recording(newer, header, recording.events[cut:])
    return newer


@pytest.fixture
def all_are_skimmed(monkeypatch):
    """Short recordings are skimmed, too, and only skimmed: the reader is not asked."""
    monkeypatch.setattr(skim, "WORTH_SKIMMING", 0)

    def not_asked(path):
        raise AssertionError(f"{path} was left to the reader")

    monkeypatch.setattr(skim, "read_recording", not_asked)


@pytest.mark.usefixtures("all_are_skimmed")
@pytest.mark.parametrize("path", FILES, ids=lambda path: str(path.relative_to(REFERENCE)))
def test_a_skimmed_recording_has_the_same_summary(path, monkeypatch):
    expected = summarise_recording(read_recording(path))
    assert expected.steps > 0
    for piece in (500, sealed.PIECE):
        monkeypatch.setattr(sealed, "PIECE", piece)
        assert skim_recording(path).summary == expected


def test_a_recording_that_was_cut_off_is_skimmed_to_the_same_summary(tmp_path, monkeypatch):
    monkeypatch.setattr(skim, "WORTH_SKIMMING", 0)
    lines = ORIGINAL.read_bytes().splitlines(keepends=True)
    path = tmp_path / "cut.jsonl"
    for kept in (1, 2, 9, len(lines) - 1):
        for tail in (b"", b'{"type":"fra'):
            path.write_bytes(b"".join(lines[:kept]) + tail)
            assert skim_recording(path).summary == summarise_recording(read_recording(path))


@pytest.mark.usefixtures("all_are_skimmed")
def test_the_older_part_of_a_session_is_counted_and_may_be_left_out(tmp_path):
    newer = resumed(tmp_path)
    whole = skim_recording(newer)
    assert whole.summary == summarise_recording(read_session(newer))
    assert whole.older == (tmp_path / "older.jsonl",)
    alone = skim_recording(newer, whole_session=False)
    assert alone.summary == summarise_recording(read_recording(newer)) != whole.summary
    assert alone.older == ()


def test_a_skimmed_session_whose_older_part_is_missing_is_refused(tmp_path, monkeypatch):
    monkeypatch.setattr(skim, "WORTH_SKIMMING", 0)
    newer = resumed(tmp_path)
    (tmp_path / "older.jsonl").unlink()
    with pytest.raises(RecordingError, match=r"goes on with older\.jsonl, which is not in its folder"):
        skim_recording(newer)
    assert skim_recording(newer, whole_session=False).header.resumes is not None


@pytest.mark.parametrize("forgery", ["end before a frame", "header second", "two records in a line"])
def test_forgeries_that_are_sealed_anew_are_refused_by_skimming_as_by_the_reader(
    tmp_path, monkeypatch, forgery
):
    monkeypatch.setattr(skim, "WORTH_SKIMMING", 0)
    lines = ORIGINAL.read_bytes().splitlines(keepends=True)
    frame = next(n for n, line in enumerate(lines) if line.startswith(b'{"type":"frame-shown"'))
    match forgery:
        case "end before a frame":
            lines.append(lines.pop(frame))
        case "header second":
            lines.insert(0, lines.pop(frame))
        case _:
            both = b'{"type":"resumed","time_ns":1} {"type":"resumed","time_ns":2,"chain":"0"}\n'
            lines.insert(frame, both)
    path = tmp_path / "forged.jsonl"
    path.write_bytes(resealed(b"".join(lines)))
    with pytest.raises(RecordingError) as by_reader:
        read_recording(path)
    with pytest.raises(RecordingError) as by_skimming:
        skim_recording(path)
    assert str(by_skimming.value) == str(by_reader.value)


def test_a_listing_keeps_nothing_of_what_it_has_read(tmp_path, monkeypatch):
    monkeypatch.setattr(skim, "WORTH_SKIMMING", 0)
    path = large(tmp_path / "presses.jsonl", 10_000)
    skim_recording(path)
    tracemalloc.start()
    try:
        kept = skim_recording(path)
        held, peak = tracemalloc.get_traced_memory()
    finally:
        tracemalloc.stop()
    assert kept.summary.presses_counted == 10_000
    assert held < 100_000
    assert peak < path.stat().st_size  # 5 MB; as decoded events it takes thrice as much


@pytest.mark.parametrize("step", [37, 101])
def test_damage_is_found_by_skimming_too(tmp_path, monkeypatch, step):
    monkeypatch.setattr(skim, "WORTH_SKIMMING", 0)
    content = ORIGINAL.read_bytes()
    path = tmp_path / "damaged.jsonl"
    for at in range(0, len(content), step * 7):
        if b',"chain":"' in content[max(0, at - 28) : at + 12]:
            continue  # in the hash itself: events are whole, and the reader names the line
        path.write_bytes(content[:at] + bytes([content[at] ^ 1]) + content[at + 1 :])
        with pytest.raises(RecordingError):
            skim_recording(path)


def header_with(**fields) -> bytes:
    header = msgspec.json.decode(ORIGINAL.read_bytes().splitlines()[0])
    header.pop("chain")
    return Chain().seal(json.dumps(header | fields, separators=(",", ":")).encode())


@pytest.mark.parametrize(
    ("content", "said"),
    [
        (b"[" * 2000, "not a recording"),
        (
            b'{"type":"header","format":"arl-recording","a":' + b"[" * 2000 + b"]" * 2000 + b"}\n",
            "not a recording|the header was changed",  # Python 3.13 reads so deep a nesting
        ),
        (header_with(root_seed=-1), "root_seed is >= 0, got -1"),
        (
            resealed(
                header_with() + b'{"type":"end","events":' + b"[" * 2000 + b"]" * 2000 + b',"chain":"0"}'
            ),
            ":2: ",
        ),
    ],
    ids=["nested", "nested header", "negative seed", "nested event"],
)
def test_what_cannot_be_read_is_refused(tmp_path, content, said):
    path = tmp_path / "bad.jsonl"
    path.write_bytes(content)
    with pytest.raises(RecordingError, match=said):
        read_recording(path)


def test_a_line_that_no_session_writes_is_refused_before_it_is_copied(tmp_path, monkeypatch):
    monkeypatch.setattr(reader, "LONGEST_LINE", 40_000)
    path = tmp_path / "wide.jsonl"
    path.write_bytes(header_with() + b'{"type":"resumed","time_ns":' + b"1" * 50_000 + b"}\n")
    with pytest.raises(
        RecordingError, match=r":2: a line of 50,029 bytes; a session writes none of more than 40,000"
    ):
        read_recording(path)


def test_a_bomb_is_not_unpacked(tmp_path, monkeypatch):
    monkeypatch.setattr(undo, "MOST_UNPACKED", 1 << 20)
    path = tmp_path / "bomb.jsonl.gz"
    path.write_bytes(gzip.compress(b"\0" * (1 << 22)))
    with pytest.raises(RecordingError, match="holds more than 1,048,576 bytes"):
        read_recording(path)
    path.write_bytes(gzip.compress(b"\0" * (1 << 19)) * 8)
    with pytest.raises(RecordingError, match="holds more than 1,048,576 bytes"):
        read_recording(path)


@pytest.mark.parametrize("pack", [gzip.compress, bz2.compress, lzma.compress])
def test_a_bomb_takes_no_more_memory_than_the_limit(tmp_path, monkeypatch, pack):
    monkeypatch.setattr(undo, "MOST_UNPACKED", 1 << 22)
    monkeypatch.setattr(undo, "PIECE", 1 << 18)
    bomb = pack(b"\0" * (1 << 26))
    tracemalloc.start()
    try:
        with pytest.raises(RecordingError, match="holds more than 4,194,304 bytes"):
            undo.as_recorded(tmp_path / "bomb", bomb)
        peak = tracemalloc.get_traced_memory()[1]
    finally:
        tracemalloc.stop()
    # The limit, and what the unpacker keeps for itself (lzma: a window of 8 MiB); joining would double it.
    assert peak < (1 << 22) + (1 << 21) + (9 << 20 if pack is lzma.compress else 0)


@pytest.mark.parametrize("pack", [gzip.compress, bz2.compress, lzma.compress])
def test_a_packed_recording_is_unpacked_piece_by_piece(monkeypatch, pack):
    content = ORIGINAL.read_bytes()
    monkeypatch.setattr(undo, "PIECE", 1000)
    parts = pack(content[:5000]) + pack(content[5000:])
    for packed in (pack(content), parts):
        found = undo.as_recorded(ORIGINAL, packed)
        assert found.content == content
        assert not found.packed_cut
    assert undo.as_recorded(ORIGINAL, pack(content)[:-9]).packed_cut


def test_a_recording_is_written_whole_or_not_at_all(tmp_path):
    recording = read_recording(ORIGINAL)

    def failing():
        yield recording.events[0]
        raise RuntimeError("cut")

    with pytest.raises(RuntimeError, match="cut"):
        write_recording(tmp_path / "a.jsonl", recording.header, failing())
    with pytest.raises(UnicodeEncodeError):
        write_recording(
            tmp_path / "a.jsonl", msgspec.structs.replace(recording.header, participant="\udc80"), ()
        )
    assert list(tmp_path.iterdir()) == []
    write_recording(tmp_path / "a.jsonl", recording.header, recording.events)
    assert read_recording(tmp_path / "a.jsonl").events == recording.events
    with pytest.raises(FileExistsError):
        write_recording(tmp_path / "a.jsonl", recording.header, failing())
    assert read_recording(tmp_path / "a.jsonl").events == recording.events
