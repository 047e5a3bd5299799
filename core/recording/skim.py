"""Read of a long recording what a listing needs: a million events in less than a second.

The running hash over the whole file is checked at its end: no event was changed, lost or moved. Frames, steps
and credits are counted and not decoded; `core.recording.reader` does that, and names the line where something
is wrong.
"""

import hashlib
from pathlib import Path

import msgspec

from core.recording.reader import CHAIN_MARK, Recording, read_recording, record_of
from core.recording.recorder import CHAIN_DIGITS
from core.recording.schema import End, Header

WORTH_SKIMMING = 1 << 22
"""Bytes from which on a file is skimmed: 4 MB."""
_BEGIN = b'{"type":"'
_STEP = b'{"type":"step-taken"'
_COUNTED = (b'{"type":"frame-shown"', _STEP, b'{"type":"credit-given"')
_TAIL = len(CHAIN_MARK) + CHAIN_DIGITS + 2


def skim_recording(path: Path) -> Recording:
    """Return a recording for `core.recording.summary`: of a long one without frames, steps and credits.

    Args:
        path: as `core.recording.reader.read_recording` takes it.

    Raises:
        RecordingError: the file is not a recording, or a line is damaged.
        OSError: the file cannot be read.
    """
    if path.is_file() and path.stat().st_size >= WORTH_SKIMMING:
        skimmed = _skimmed(path, path.read_bytes())
        if skimmed is not None:
            return skimmed
    return read_recording(path)


def _skimmed(path: Path, content: bytes) -> Recording | None:
    """Return what a listing needs; None where anything is not as this program writes it: the reader tells."""
    if not content.startswith(_BEGIN) or not content.endswith(b'"}\n') or b"\r" in content:
        return None
    lines = content.split(b"\n")
    lines.pop()
    if content.count(CHAIN_MARK) != len(lines) or content.count(b"\n" + _BEGIN) != len(lines) - 1:
        return None
    del content
    digest = hashlib.sha256(b"}".join([line[:-_TAIL] for line in lines]) + b"}").hexdigest()
    if digest[:CHAIN_DIGITS].encode() != lines[-1][-CHAIN_DIGITS - 2 : -2]:
        return None
    steps = sum([line.startswith(_STEP) for line in lines])
    kept = [line for line in lines if not line.startswith(_COUNTED)]
    return _decoded(path, kept, len(lines), steps)


def _decoded(path: Path, kept: list[bytes], n_lines: int, steps: int) -> Recording | None:
    try:
        header = msgspec.json.decode(kept[0][:-_TAIL] + b"}", type=Header)
        records = [record_of(line[:-_TAIL] + b"}", header.version) for line in kept[1:]]
    except (msgspec.DecodeError, ValueError, RecursionError):
        return None
    last = records[-1] if records else None
    end = last if isinstance(last, End) else None
    events = tuple(record for record in records if not isinstance(record, Header | End))
    if len(events) != len(records) - (end is not None) or (end is not None and end.events != n_lines - 2):
        return None
    return Recording(path, header, events, end is not None, steps_left_out=steps)
