"""A long recording that stays on the disk: its events are read whenever they are asked for.

Exact replay goes over the events in their order and needs no two far from each other, so a session of any
length replays in the same memory.
"""

from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path

import msgspec

from core.events import Event, Output
from core.recording import version_1
from core.recording.lines import record_of
from core.recording.reader import Recording, RecordingError, cut_note
from core.recording.schema import VERSION, End, Header, Line
from core.recording.sealed import SealedFile, UnusualFileError
from core.recording.summary import RecordingSummary, Summarising

WORTH_STORING = 1 << 23
"""Bytes from which on a recording stays on the disk: 8 MB, a session of two hours."""

_decoder = msgspec.json.Decoder(Line)


@dataclass(frozen=True, slots=True)
class StoredRecording:
    """A recording whose events are read from its file, checked, each time they are gone over."""

    path: Path
    header: Header
    """As `core.recording.reader.Recording` has it."""
    complete: bool
    notes: tuple[str, ...]
    n_events: int
    n_outputs: int
    last_output: Output | None
    summary: RecordingSummary
    chain: str
    """Of the last whole line, hex."""
    older: tuple[Path, ...] = ()
    """Empty: a session that goes on with an older recording is read whole."""

    @property
    def events(self) -> Iterator[Event]:
        """Yield the events from the first one, read anew.

        Raises:
            RecordingError: the file is not what it was any more.
            OSError: it cannot be read.
        """
        file = SealedFile(self.path)
        try:
            for record in _records(file, every_line=False):  # each line's chain was compared before
                if not isinstance(record, Header | End):
                    yield record
        except UnusualFileError as error:
            raise RecordingError(f"{self.path}: the file has changed while it was read") from error
        if file.chain != self.chain:
            raise RecordingError(f"{self.path}: the file has changed while it was read")

    def line_of(self, index: int) -> int:
        """Return the number of the line, from 1, on which event number `index`, from 0, stands."""
        return index + 2


AnyRecording = Recording | StoredRecording
"""What can be gone over from the first event to the last."""


def stored_recording(path: Path, *, from_bytes: int | None = None) -> StoredRecording | None:
    """Check a long recording line by line, and leave its events on the disk.

    Args:
        path: of the file.
        from_bytes: size from which on a recording is long; left out, `WORTH_STORING`.

    Returns:
        None where the file is short, goes on with another recording, or is not exactly as a recorder leaves
        it: `core.recording.reader.read_recording` reads it, or says what is wrong.

    Raises:
        OSError: the file cannot be read.
    """
    least = WORTH_STORING if from_bytes is None else from_bytes
    if not path.is_file() or path.stat().st_size < least:
        return None
    file = SealedFile(path)
    try:
        return _gone_over(path, file)
    except UnusualFileError:
        return None


def _gone_over(path: Path, file: SealedFile) -> StoredRecording:
    records = _records(file, every_line=True)
    header = next(records)
    if not isinstance(header, Header) or header.resumes is not None:
        raise UnusualFileError
    if header.version == 1:
        header = msgspec.structs.replace(header, protocol=version_1.with_schedules(header.protocol))
    summarising, n_events, n_outputs = Summarising(), 0, 0
    last_output: Output | None = None
    end: End | None = None
    for record in records:
        if isinstance(record, Header) or end is not None:
            raise UnusualFileError
        if isinstance(record, End):
            end = record
            continue
        n_events += 1
        summarising.take(record)
        if isinstance(record, Output):
            n_outputs += 1
            last_output = record
    if end is not None and (end.events != n_events or file.tail):
        raise UnusualFileError
    complete = end is not None
    return StoredRecording(
        path,
        header,
        complete,
        (cut_note(file.tail),) if file.tail.strip() else (),
        n_events,
        n_outputs,
        last_output,
        summarising.summary(header, complete=complete, lost_tail=bool(file.tail.strip())),
        file.chain,
    )


def _records(file: SealedFile, *, every_line: bool) -> Iterator[Line]:
    """Yield what the lines say, the header first; `every_line` as in `SealedFile.pieces`."""
    version = VERSION
    first = True
    for piece in file.pieces(every_line=every_line):
        for payload in piece.payloads:
            whole = payload + b"}"
            try:
                record = _decoder.decode(whole) if version == VERSION else record_of(whole, version)
            except (ValueError, RecursionError) as error:
                raise UnusualFileError from error
            if first and isinstance(record, Header):
                version = record.version
            first = False
            yield record
