"""The index of a recording: where each game, step, frame and press stands in its file.

It is kept beside the recording (`FILE.jsonl.index`) and made again when the recording's file has changed.
Building it reads the whole file once and checks its chain. Memory does not grow with the recording.
"""

import hashlib
import struct
import tempfile
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Final

import msgspec

from core.events import StepTaken
from core.recording.lines import line_of_file, record_of
from core.recording.reader import Recording, RecordingError, read_recording
from core.recording.recorder import LineWriter
from core.recording.schema import VERSION, Header, Line
from core.recording.sealed import SealedFile, UnusualFileError
from core.recording.skim import STEP_BEGINS
from core.recording.version_1 import with_schedules
from core.system.temporary import (
    is_of_this_process,
    is_own,
    own_number,
    prefix_of,
    remove_at_end,
    remove_left_behind,
)
from studies.session_view.building import Building
from studies.session_view.tables import Contents, Rows, read_tables, write_tables

INDEX_VERSION: Final = 3
SUFFIX: Final = ".index"
STRETCH: Final = 1 << 20
"""Bytes of a recording that are looked at together."""
FIRST_PART = 1 << 22
"""Bytes of a long recording that are looked at first: 4 MB, which take a few tenths of a second."""
WORTH_PARTS = 1 << 24
"""Bytes from which on the first part is shown before the rest has been read: 16 MB."""
_decoder = msgspec.json.Decoder(Line)

OnProgress = Callable[[float], None]
"""Is told which fraction of the file has been read, in [0, 1]."""


@dataclass(frozen=True, slots=True, eq=False)
class Index:
    """An opened index; tables as `studies.session_view.tables.DTYPES` describes them."""

    path: Path
    """Of the file that offsets point into: the recording, or a copy that was put right."""
    header: Header
    version: int
    """Of the format of that file."""
    tables: dict[str, Rows]
    start_ns: int
    end_ns: int
    events: int
    complete: bool
    """The recording has its end line."""
    reason: str
    """Why the session ended, as its last event says; "" where there is none."""
    notes: tuple[str, ...] = ()
    """What is unusual about the file."""
    whole: bool = True
    """False: only the first part of the recording is in it (`first_part`)."""

    def line(self, offset: int) -> Line:
        """Return what stands at a byte of the file.

        Raises:
            RecordingError: the file has changed.
            OSError: it is not there any more.
        """
        with self.path.open("rb") as file:
            file.seek(offset)
            return self._decoded(file.readline())

    def steps(self, offset: int, last: int) -> list[StepTaken]:
        """Return the steps among the lines that begin from one byte of the file to another, both included.

        Other lines are not decoded: there are ten frames to a step.
        """
        found: list[StepTaken] = []
        with self.path.open("rb") as file:
            file.seek(offset)
            left = last - offset
            while left >= 0 and (lines := file.readlines(min(left + 1, STRETCH))):
                left -= sum(map(len, lines))
                for line in lines:
                    if line.startswith(STEP_BEGINS):
                        record = self._decoded(line)
                        assert isinstance(record, StepTaken), "its type says so"
                        found.append(record)
        return found

    def _decoded(self, line: bytes) -> Line:
        try:
            return line_of_file(line.rstrip(b"\n"), self.version)
        except (msgspec.DecodeError, ValueError) as error:  # each was whole when the index was made
            raise RecordingError(
                f"{self.path}: the file has changed while it was looked at: open it again"
            ) from error


def open_index(path: Path, *, on_progress: OnProgress = lambda fraction: None) -> Index:
    """Open the index of a recording; build it where there is none, or where it is of another state of the
    file.

    Raises:
        RecordingError: the recording is damaged.
        OSError: it cannot be read.
    """
    if path.is_dir():
        read_recording(path)  # says what to do
    fingerprint = fingerprint_of(path)
    for place in _places(path):
        found = _opened(path, place, fingerprint)
        if found is not None:
            return found
    try:
        return _build(path, path, fingerprint, (), on_progress)
    except UnusualFileError:
        # Compressed, or changed by an editor: the reader puts it right or says what is wrong.
        recording = read_recording(path)
        return _build(path, _copied(path, recording), fingerprint, recording.notes, on_progress)


def fingerprint_of(path: Path) -> str:
    """Return what tells one state of a file from another: size, time of its last change, first and last 4096
    bytes.
    """
    status = path.stat()
    with path.open("rb") as file:
        digest = hashlib.sha256(file.read(4096))
        file.seek(max(0, status.st_size - 4096))
        digest.update(file.read(4096))
    return f"{status.st_size}-{status.st_mtime_ns}-{digest.hexdigest()[:32]}"


def _places(path: Path) -> tuple[Path, Path]:
    """Return where an index may be: beside the recording, else in the folder for temporary files.

    There each user has their own.
    """
    name = hashlib.sha256(f"{own_number()} {path.resolve()}".encode()).hexdigest()[:24]
    return path.with_name(path.name + SUFFIX), Path(tempfile.gettempdir()) / f"arl-{name}{SUFFIX}"


def _copied(path: Path, recording: Recording) -> Path:
    """Write a recording as its recorder would, for as long as this program runs; return where.

    Offsets of an index point into such a copy where the file itself is compressed or was changed.
    """
    remove_left_behind()
    name = _places(path)[1].stem.removeprefix("arl-")
    copy = Path(tempfile.gettempdir()) / f"{prefix_of('copy')}{name}.jsonl"
    copy.unlink(missing_ok=True)
    remove_at_end(copy)
    writer = LineWriter(copy, recording.header)
    for event in recording.events:
        writer.append(event)
    if recording.complete:
        writer.finish()
    writer.abandon()
    return copy


def _opened(path: Path, place: Path, fingerprint: str) -> Index | None:
    """Return the index at a place; None where there is none that can be used."""
    try:
        if place.parent != path.parent and not is_own(place):
            return None  # anybody can leave a file in the folder for temporary files
        contents, tables = read_tables(place)
    except (OSError, ValueError, msgspec.MsgspecError):
        return None
    file = Path(contents.facts.get("file", "")) if contents.facts.get("file") else path
    if contents.index != INDEX_VERSION or contents.of != fingerprint or not file.exists():
        return None
    if file != path and not is_of_this_process(file):
        return None  # a copy that goes when another program ends
    facts = contents.facts
    with file.open("rb") as opened:
        header = line_of_file(opened.readline().rstrip(b"\n"), VERSION)
    assert isinstance(header, Header), "the first line was looked at when the index was built"
    version = header.version
    if version == 1:
        header = msgspec.structs.replace(header, protocol=with_schedules(header.protocol))
    return Index(
        file, header, version, tables, facts["start"], facts["end"], facts["events"], facts["complete"],
        facts["reason"], tuple(facts["notes"]),
    )  # fmt: skip


def _build(
    path: Path, file: Path, fingerprint: str, notes: tuple[str, ...], on_progress: OnProgress
) -> Index:
    building = Building()
    try:
        _read(file, building, on_progress)
        with _possible(file, 0):
            facts = building.facts(file if file != path else None, notes)
        contents = Contents(INDEX_VERSION, fingerprint, facts, {})
        for place in _places(path):
            try:
                write_tables(place, building.tables, contents)
            except OSError:
                continue
            found = _opened(path, place, fingerprint)
            if found is not None:
                return found
    finally:
        building.close()
    raise RecordingError(
        f"{path}: its index can be written neither beside it nor in {tempfile.gettempdir()}: make room on "
        f"the disk"
    )


@contextmanager
def _possible(file: Path, offset: int) -> Iterator[None]:
    """Refuse what no table can hold: numbers beyond 64 bits, the end of a game that never began."""
    try:
        yield
    except (struct.error, ValueError, OverflowError) as error:
        raise RecordingError(
            f"{file}: no session records what stands at byte {offset}: {error}. The file was changed after "
            f"it was recorded, or another program wrote it"
        ) from error


def _read(file: Path, building: Building, on_progress: OnProgress, *, up_to: int | None = None) -> None:
    """Take in the lines of a file: all, or those of the pieces that begin before byte `up_to`."""
    sealed, size = SealedFile(file), max(1, file.stat().st_size)
    version, begun = VERSION, False
    for piece in sealed.pieces(every_line=False):
        if up_to is not None and piece.offset >= up_to:
            return
        offset = piece.offset
        for line, payload in zip(piece.lines, piece.payloads, strict=True):
            whole = payload + b"}"
            try:
                record = _decoder.decode(whole) if version == VERSION else record_of(whole, version)
            except (ValueError, RecursionError) as error:
                raise UnusualFileError from error
            if isinstance(record, Header) == begun or building.ended:
                raise UnusualFileError  # the header is the first line, and no other; nothing follows the end
            if isinstance(record, Header):
                version, begun = record.version, True
            else:
                with _possible(file, offset):
                    building.take(record, offset)
            offset += len(line) + 1
        on_progress(offset / size)
    if sealed.tail:
        building.cut_off = sealed.tail
    if building.ended and (sealed.tail or building.said_events != building.events):
        raise UnusualFileError
    on_progress(1.0)


def first_part(path: Path) -> Index | None:
    """Return an index of the beginning of a long recording, for the time until the whole one is there.

    Its file is gone from the disk when this returns; its tables stay readable.

    Returns:
        None where the recording is short, has its index already, or is not as a recorder leaves it.

    Raises:
        OSError: the recording cannot be read, or there is no room for the tables.
    """
    if not path.is_file() or path.stat().st_size < WORTH_PARTS:
        return None
    fingerprint = fingerprint_of(path)
    if any(_opened(path, place, fingerprint) is not None for place in _places(path)):
        return None
    building = Building()
    try:
        _read(path, building, lambda fraction: None, up_to=FIRST_PART)
        with _possible(path, 0):
            facts = building.facts(None, ())
        with tempfile.TemporaryDirectory(prefix=prefix_of("watch")) as folder:
            place = Path(folder) / f"first{SUFFIX}"
            write_tables(place, building.tables, Contents(INDEX_VERSION, fingerprint, facts, {}))
            found = _opened(path, place, fingerprint)
    except UnusualFileError:
        return None
    finally:
        building.close()
    return None if found is None else replace(found, whole=False)
