"""Read of a long recording what a listing needs: a million events in less than a second.

The running hash over the whole file is checked at its end: no event was changed, lost or moved. Frames, steps
and credits are counted and not decoded; `core.recording.reader` does that, and names the line where something
is wrong.
"""

from pathlib import Path

import msgspec

from core.recording.lines import record_of
from core.recording.reader import Recording, read_recording
from core.recording.schema import VERSION, End, Header, Line
from core.recording.sealed import SealedFile, UnusualFileError

WORTH_SKIMMING = 1 << 22
"""Bytes from which on a file is skimmed: 4 MB."""
STEP_BEGINS = b'{"type":"step-taken"'
_decoder: msgspec.json.Decoder[Line] = msgspec.json.Decoder(Line)
_COUNTED = (b'{"type":"frame-shown"', STEP_BEGINS, b'{"type":"credit-given"')


def skim_recording(path: Path) -> Recording:
    """Return a recording for `core.recording.summary`: of a long one without frames, steps and credits.

    Args:
        path: as `core.recording.reader.read_recording` takes it.

    Raises:
        RecordingError: the file is not a recording, or a line is damaged.
        OSError: the file cannot be read.
    """
    if path.is_file() and path.stat().st_size >= WORTH_SKIMMING:
        skimmed = _skimmed(path)
        if skimmed is not None:
            return skimmed
    return read_recording(path)


def _skimmed(path: Path) -> Recording | None:
    """Return what a listing needs; None where anything is not as this program writes it: the reader tells."""
    file = SealedFile(path)
    kept: list[bytes] = []
    n_lines = steps = 0
    try:
        for piece in file.pieces(every_line=False):
            n_lines += len(piece.payloads)
            steps += sum([payload.startswith(STEP_BEGINS) for payload in piece.payloads])
            kept += [payload for payload in piece.payloads if not payload.startswith(_COUNTED)]
    except UnusualFileError:
        return None
    return None if file.tail else _decoded(path, kept, n_lines, steps)


def _decoded(path: Path, kept: list[bytes], n_lines: int, steps: int) -> Recording | None:
    try:
        header = msgspec.json.decode(kept[0] + b"}", type=Header)
        wholes = [payload + b"}" for payload in kept[1:]]
        if header.version == VERSION:
            records = list(map(_decoder.decode, wholes))
        else:
            records = [record_of(whole, header.version) for whole in wholes]
    except (msgspec.DecodeError, ValueError, RecursionError):
        return None
    last = records[-1] if records else None
    end = last if isinstance(last, End) else None
    events = tuple(record for record in records if not isinstance(record, Header | End))
    if len(events) != len(records) - (end is not None) or (end is not None and end.events != n_lines - 2):
        return None
    return Recording(path, header, events, end is not None, steps_left_out=steps)
