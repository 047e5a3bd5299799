"""Copies of recordings without dates, for publication.

They are chained anew, so that they read and replay as the originals do.
"""

import re
from pathlib import Path

from core.recording.anonymise import resealed, without_dates
from core.recording.reader import Recording, read_recording


def publish_copy(recording: Recording, target: Path) -> None:
    """Write a copy of a recording whose header names no date; its events are the same, byte by byte.

    `core.recording.anonymise` removes more than dates.

    Args:
        recording: as it was read.
        target: the new file; its folder is made where it is missing.

    Raises:
        FileExistsError: there is a file at `target` already.
        OSError: it cannot be written.
    """
    about = {"published": "dates removed, chained anew"}
    content = resealed(recording, without_dates, lambda event: event, about)
    target.parent.mkdir(parents=True, exist_ok=True)
    with target.open("xb") as file:
        file.write(content)


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
