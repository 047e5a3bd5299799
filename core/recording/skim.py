"""Read of a long recording what a listing needs: a million events in less than a second.

The running hash over the whole file is checked at its end: no event was changed, lost or moved. Frames, steps
and credits are counted and not decoded; `core.recording.reader` does that, and names the line where something
is wrong. Of a recording, only the numbers of its accepted presses are kept while it is read, and nothing
afterwards: a folder may hold any number of recordings.
"""

from dataclasses import dataclass
from pathlib import Path

import msgspec

from core.recording.joined import joined
from core.recording.lines import record_of
from core.recording.reader import Recording, RecordingError, read_recording
from core.recording.schema import VERSION, End, Header, Line
from core.recording.sealed import SealedFile, UnusualFileError
from core.recording.summary import RecordingSummary, Summarising, summarise_recording
from core.system.in_use import is_held

WORTH_SKIMMING = 1 << 22
"""Bytes from which on a file is skimmed: 4 MB."""
STEP_BEGINS = b'{"type":"step-taken"'
_FRAME_BEGINS = b'{"type":"frame-shown"'
_CREDIT_BEGINS = b'{"type":"credit-given"'
_END_BEGINS = b'{"type":"end"'
_decoder: msgspec.json.Decoder[Line] = msgspec.json.Decoder(Line)


@dataclass(frozen=True, slots=True)
class Skimmed:
    """What a listing says about a recording that was checked."""

    header: Header
    notes: tuple[str, ...]
    """As `core.recording.reader.Recording` has them."""
    older: tuple[Path, ...]
    """Older recordings that the session began with; they are counted in the summary."""
    summary: RecordingSummary


def skim_recording(path: Path, *, whole_session: bool = True) -> Skimmed:
    """Return what a listing needs.

    Args:
        path: as `core.recording.reader.read_recording` takes it.
        whole_session: read the older recordings that this one goes on with, too.

    Raises:
        RecordingError: the file is not a recording, a line is damaged, or an older recording is missing or
            not the one that was recorded.
        OSError: a file cannot be read.
    """
    if path.is_file() and path.stat().st_size >= WORTH_SKIMMING:
        try:
            return _skimmed(path, whole_session=whole_session)
        except (UnusualFileError, RecordingError, msgspec.DecodeError, ValueError, RecursionError, OSError):
            pass  # not as this program writes it: the reader puts it right, or says what is wrong
    recording = read_recording(path)
    if whole_session:
        recording = joined(recording)
    return Skimmed(recording.header, recording.notes, recording.older, summarise_recording(recording))


def _skimmed(path: Path, *, whole_session: bool) -> Skimmed:
    file = SealedFile(path)
    summarising = Summarising()
    recording: Recording | None = None
    n_lines, last = 0, b""
    end: End | None = None
    for piece in file.pieces(every_line=False):
        lines = piece.payloads
        n_lines += len(lines)
        last = lines[-1]
        if recording is None:
            header = msgspec.json.decode(lines.pop(0) + b"}", type=Header)
            recording = Recording(path, header, (), complete=True)
            recording = joined(recording) if whole_session else recording
            for event in recording.events:  # of older recordings
                summarising.take(event)
        lines = [line for line in lines if not line.startswith(_FRAME_BEGINS)]
        others = [line for line in lines if not line.startswith(STEP_BEGINS)]
        summarising.add_steps(len(lines) - len(others))
        others = [line for line in others if not line.startswith(_CREDIT_BEGINS)]
        for record in _decoded(others, recording.header):
            if end is not None or isinstance(record, Header):
                raise UnusualFileError
            if isinstance(record, End):
                end = record
            else:
                summarising.take(record)
    if recording is None or file.tail:
        raise UnusualFileError
    if end is not None and (not last.startswith(_END_BEGINS) or end.events != n_lines - 2):
        raise UnusualFileError
    summary = summarising.summary(
        recording.header,
        complete=end is not None,
        lost_tail=False,
        being_written=end is None and is_held(path),
    )
    return Skimmed(recording.header, recording.notes, recording.older, summary)


def _decoded(payloads: list[bytes], header: Header) -> list[Line]:
    """Return what these lines say.

    Raises:
        msgspec.DecodeError, ValueError, RecursionError: one of them is none of the header's version.
        UnusualFileError: several of them make one line of JSON.
    """
    if header.version != VERSION:
        return [record_of(payload + b"}", header.version) for payload in payloads]
    if not payloads:
        return []
    records = _decoder.decode_lines(b"}\n".join(payloads) + b"}")
    if len(records) != len(payloads):  # each takes one line at least
        raise UnusualFileError
    return records
