"""Recordings of an earlier version of the format, written again in the present one."""

import hashlib
from pathlib import Path

import msgspec

from core.recording.chain import Chain
from core.recording.reader import Recording
from core.recording.schema import VERSION, End, Header, encode

UPGRADED_FROM = "upgraded_from_version"
"""Fact in `Header.source` of an upgraded file: the version in which the session was recorded."""


def recorded_version(header: Header) -> int:
    """Return the version of the format in which a session was recorded: it says what the file cannot tell."""
    return int(header.source.get(UPGRADED_FROM, header.version))


def upgraded(recording: Recording) -> bytes:
    """Return the content of a recording in the present version of the format.

    What the old version did not record is null. The header says from which version and file the copy was
    made.

    Args:
        recording: as it was read, of an earlier version.

    Raises:
        ValueError: it is of the present version already.
        OSError: its file cannot be read again.
    """
    if recording.header.version == VERSION:
        raise ValueError(f"{recording.path}: of version {VERSION} already, nothing to upgrade")
    about = {
        UPGRADED_FROM: str(recording.header.version),
        "upgraded_from_sha256": hashlib.sha256(recording.path.read_bytes()).hexdigest(),
    }
    header = msgspec.structs.replace(
        recording.header, version=VERSION, source=recording.header.source | about
    )
    chain = Chain()
    lines = [header, *recording.events]
    end = [End(events=len(recording.events))] if recording.complete else []
    return b"".join(chain.seal(encode(line)) for line in (*lines, *end))


def upgraded_path(path: Path) -> Path:
    """Return a path without the ending of a packed file: upgraded files are plain text."""
    return path if path.suffix == ".jsonl" else path.with_suffix("")
