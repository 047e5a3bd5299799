"""Copies of recordings without dates, for publication.

They are chained anew, so that they read and replay as the originals do.
"""

import re
from pathlib import Path
from typing import Any

import msgspec

from core.recording.reader import CHAIN_MARK, Recording, read_recording
from core.recording.recorder import Chain
from core.recording.schema import End, encode
from core.recording.undo import as_recorded

REMOVED = "(date removed)"
_DATE = re.compile(r"\d{4}-?[01]\d-?[0-3]\d([T ][\d:.]+(Z|[+-]\d\d:?\d\d)?)?")


def publish_copy(recording: Recording, target: Path) -> None:
    """Write a copy of a recording whose header names no date; its events are the same, byte by byte.

    Args:
        recording: as it was read.
        target: the new file; its folder is made where it is missing.

    Raises:
        FileExistsError: there is a file at `target` already.
        OSError: it cannot be written.
    """
    content = as_recorded(recording.path, recording.path.read_bytes()).content
    lines = [line for line in content.split(b"\n") if line.strip()]
    n_lines = 1 + len(recording.events) + recording.complete
    payloads = [line.rpartition(CHAIN_MARK)[0] + b"}" for line in lines[:n_lines]]
    payloads[0] = _without_dates(payloads[0])
    if recording.signature:
        # It was about the lines with their dates.
        payloads[-1] = encode(End(events=len(recording.events)))
    chain = Chain()
    target.parent.mkdir(parents=True, exist_ok=True)
    with target.open("xb") as file:
        for payload in payloads:
            file.write(chain.seal(payload))


def _without_dates(header: bytes) -> bytes:
    plain = _removed(msgspec.json.decode(header))
    plain["source"] = plain.get("source", {}) | {"published": "dates removed, chained anew"}
    return msgspec.json.encode(plain)


def _removed(value: Any) -> Any:
    """Return plain JSON with every date in a text replaced."""
    if isinstance(value, str):
        return _DATE.sub(REMOVED, value)
    if isinstance(value, dict):
        return {name: _removed(below) for name, below in value.items()}
    if isinstance(value, list):
        return [_removed(below) for below in value]
    return value


def publish_folder(paths: list[Path], into: Path) -> list[tuple[Path, Path]]:
    """Copy recordings into a folder under names without dates: code and number, oldest first.

    Args:
        paths: of the recordings.
        into: the folder.

    Returns:
        Pairs of a recording and its copy.

    Raises:
        RecordingError: one of them is damaged.
        FileExistsError: a name is taken: the folder is not new.
        OSError: the folder cannot be written.
    """
    recordings = sorted(map(read_recording, paths), key=lambda found: (found.header.created_utc, found.path))
    numbers: dict[str, int] = {}
    copies = []
    for recording in recordings:
        code = re.sub(r"[^\w-]", "_", recording.header.participant)[:40]
        numbers[code] = numbers.get(code, 0) + 1
        target = into / f"{code}-{numbers[code]}.jsonl"
        publish_copy(recording, target)
        copies.append((recording.path, target))
    return copies
