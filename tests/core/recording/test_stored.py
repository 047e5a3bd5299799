"""A long recording that stays on the disk says what one in memory says, and replays in the same memory."""

import gzip
import time
import tracemalloc
from collections.abc import Iterator
from pathlib import Path

import msgspec
import pytest

from core.events import Event, FrameShown, KeyPressed, Output, StepTaken
from core.recording import sealed, stored
from core.recording.reader import RecordingError, read_recording
from core.recording.recorder import write_recording
from core.recording.stored import stored_recording
from core.recording.summary import summarise_recording
from core.session.protocol_reading import protocol_from
from core.session.replay import replay_exactly
from core.session.session import build_session

MS = 1_000_000
REFERENCE = Path(__file__).resolve().parents[3] / "recordings" / "reference"
FILES = sorted(REFERENCE.rglob("*.jsonl"))
ORIGINAL = REFERENCE / "version-2" / "tetris-linear-equation-4.jsonl"


@pytest.fixture(autouse=True)
def _short_ones_too(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(stored, "WORTH_STORING", 0)
    monkeypatch.setattr(sealed, "PIECE", 5000)


@pytest.mark.parametrize("path", FILES, ids=lambda path: str(path.relative_to(REFERENCE)))
def test_it_says_what_a_recording_in_memory_says(path: Path) -> None:
    on_disk, in_memory = stored_recording(path), read_recording(path)
    assert on_disk is not None
    assert on_disk.header == in_memory.header
    assert tuple(on_disk.events) == in_memory.events
    assert tuple(on_disk.events) == in_memory.events  # again from the beginning
    assert (on_disk.complete, on_disk.chain) == (in_memory.complete, in_memory.chain)
    assert (on_disk.n_outputs, on_disk.last_output) == (in_memory.n_outputs, in_memory.last_output)
    assert on_disk.summary == summarise_recording(in_memory)
    assert on_disk.line_of(7) == in_memory.line_of(7)


def test_it_replays_exactly_and_a_forged_press_is_refused_with_its_line(tmp_path: Path) -> None:
    on_disk, in_memory = stored_recording(ORIGINAL), read_recording(ORIGINAL)
    assert on_disk is not None
    protocol = protocol_from(on_disk.header.protocol)
    result = replay_exactly(on_disk, build_session(protocol, on_disk.header.root_seed))
    assert result.difference is None
    assert result.outputs == in_memory.n_outputs
    events = list(in_memory.events)
    at = next(n for n, event in enumerate(events) if isinstance(event, KeyPressed))
    events[at] = msgspec.structs.replace(events[at], key="j" if events[at].key == "f" else "f")
    write_recording(tmp_path / "forged.jsonl", in_memory.header, events)
    forged = stored_recording(tmp_path / "forged.jsonl")
    assert forged is not None
    with pytest.raises(RecordingError, match=f"forged.jsonl:{at + 2}: press "):
        replay_exactly(forged, build_session(protocol, on_disk.header.root_seed))


def test_one_that_was_cut_off_says_so(tmp_path: Path) -> None:
    lines = ORIGINAL.read_bytes().splitlines(keepends=True)
    path = tmp_path / "cut.jsonl"
    for kept in (1, 2, 9, len(lines) - 1):
        for tail in (b"", b'{"type":"fra'):
            path.write_bytes(b"".join(lines[:kept]) + tail)
            on_disk, in_memory = stored_recording(path), read_recording(path)
            assert on_disk is not None
            assert not on_disk.complete
            assert on_disk.notes == in_memory.notes
            assert on_disk.summary == summarise_recording(in_memory)
            assert tuple(on_disk.events) == in_memory.events


def test_what_is_damaged_is_left_to_the_reader(tmp_path: Path) -> None:
    content = ORIGINAL.read_bytes()
    path = tmp_path / "damaged.jsonl"
    for at in range(0, len(content), 977):
        path.write_bytes(content[:at] + bytes([content[at] ^ 1]) + content[at + 1 :])
        assert stored_recording(path) is None


def test_a_field_that_is_called_as_the_chain_is_no_damage(tmp_path: Path) -> None:
    recording = read_recording(ORIGINAL)
    header = msgspec.structs.replace(recording.header, source={"file": "x", "chain": "0123456789abcdef"})
    write_recording(tmp_path / "a.jsonl", header, recording.events)
    on_disk = stored_recording(tmp_path / "a.jsonl")
    assert on_disk is not None
    assert tuple(on_disk.events) == recording.events


def test_what_was_changed_by_other_programs_is_left_to_the_reader(tmp_path: Path) -> None:
    content = ORIGINAL.read_bytes()
    for changed in (
        content.replace(b"\n", b"\r\n"),
        content.replace(b"\n", b"\n\n"),
        content[:-1],
        content + content,
        content + b"x",
        gzip.compress(content),
        b"\xef\xbb\xbf" + content,
        b"",
    ):
        path = tmp_path / "changed.jsonl"
        path.write_bytes(changed)
        assert stored_recording(path) is None


def test_a_file_that_changes_while_it_is_replayed_is_named(tmp_path: Path) -> None:
    path = tmp_path / "changing.jsonl"
    path.write_bytes(ORIGINAL.read_bytes())
    on_disk = stored_recording(path)
    assert on_disk is not None
    lines = ORIGINAL.read_bytes().splitlines(keepends=True)
    for changed in (b"".join(lines[:-4]), b"".join([*lines[:9], *lines[10:]])):
        path.write_bytes(changed)
        with pytest.raises(RecordingError, match="has changed while it was read"):
            list(on_disk.events)


# --- a million events ---------------------------------------------------------------------------------------


class Again:
    """A session that says what was recorded, and takes in what was given."""

    def __init__(self, header_of: Path, n_steps: int) -> None:
        self._n_steps = n_steps

    def run(self, source, clock) -> Iterator[Output]:
        for event in events_of(self._n_steps):
            if isinstance(event, Output):
                list(source.during(0))
                yield event


def events_of(n_steps: int) -> Iterator[Event]:
    """Yield steps, each with two frames: three events a step."""
    step_taken = next(event for event in read_recording(ORIGINAL).events if isinstance(event, StepTaken))
    for step in range(n_steps):
        now_ns = (step + 1) * 100 * MS
        yield msgspec.structs.replace(step_taken, step=step, time_ns=now_ns, inputs=2 * step)
        for nth in range(2):
            yield FrameShown(frame=2 * step + nth, step=step, flushed_ns=now_ns + (1 + nth) * MS)


def peak_of_a_replay(folder: Path, n_steps: int) -> tuple[int, float]:
    """Return the most bytes that a replay of so many steps holds at once, and how long it takes, s."""
    path = folder / f"{n_steps}.jsonl"
    write_recording(path, read_recording(ORIGINAL).header, events_of(n_steps))
    began = time.process_time()
    recording = stored_recording(path)
    assert recording is not None
    replay_exactly(recording, Again(path, n_steps))  # type: ignore[arg-type]
    took_s = time.process_time() - began
    tracemalloc.start()
    try:
        recording = stored_recording(path)
        assert recording is not None
        told: list[int] = []
        # type: ignore[arg-type]
        result = replay_exactly(recording, Again(path, n_steps), on_progress=told.append)
        peak = tracemalloc.get_traced_memory()[1]
    finally:
        tracemalloc.stop()
    assert result.difference is None
    assert result.outputs == n_steps
    assert sum(told) == n_steps // 1000 * 1000
    return peak, took_s


def test_a_longer_recording_replays_in_the_same_memory(tmp_path: Path) -> None:
    short, _ = peak_of_a_replay(tmp_path, 1000)
    long, _ = peak_of_a_replay(tmp_path, 4000)
    assert long < 1.2 * short


@pytest.mark.slow
def test_a_million_events_replay_in_the_same_memory_and_in_proportion(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.undo()
    monkeypatch.setattr(stored, "WORTH_STORING", 0)
    short, short_s = peak_of_a_replay(tmp_path, 33_400)
    long, long_s = peak_of_a_replay(tmp_path, 334_000)
    print(f"100,000 events: {short / 1e6:.1f} MB, {short_s:.1f} s")
    print(f"1,000,000 events: {long / 1e6:.1f} MB, {long_s:.1f} s")
    assert long < 1.2 * short
    assert long_s < 15 * short_s
