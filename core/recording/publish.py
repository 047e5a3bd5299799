"""Copies of recordings without dates, for publication.

They are chained anew, so that they read and replay as the originals do.
"""

import re
from pathlib import Path

import msgspec

from core.recording.anonymise import last_chain, resealed, without_dates
from core.recording.joined import older_path
from core.recording.reader import Recording, read_recording
from core.recording.schema import Resumes


def publish_copy(recording: Recording, target: Path, *, resumes: Resumes | None = None) -> str:
    """Write a copy of a recording whose header names no date; its events are the same, byte by byte.

    `core.recording.anonymise` removes more than dates.

    Args:
        recording: as it was read.
        target: the new file; its folder is made where it is missing.
        resumes: what the copy says that it goes on with: the copy of the older recording.

    Returns:
        The copy's last chain.

    Raises:
        FileExistsError: there is a file at `target` already.
        OSError: it cannot be written.
    """
    about = {"published": "dates removed, chained anew"}
    content = resealed(recording, without_dates, lambda event: event, about, resumes=resumes)
    target.parent.mkdir(parents=True, exist_ok=True)
    with target.open("xb") as file:
        try:
            file.write(content)
            file.flush()
        except OSError as error:
            target.unlink()
            raise OSError(error.errno, error.strerror, str(target)) from error
    return last_chain(content)


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
    # Read twice: first all headers, then one recording after the other, so that any number fits into memory.
    ordered = sorted(paths, key=lambda path: (read_recording(path).header.created_utc, path))
    numbers: dict[str, int] = {}
    copies = []
    published: dict[Path, tuple[str, str]] = {}
    for recording in map(read_recording, ordered):
        code = re.sub(r"[^\w-]", "_", recording.header.participant)[:40]
        numbers[code] = numbers.get(code, 0) + 1
        target = into / f"{code}-{numbers[code]}.jsonl"
        resumes = recording.header.resumes
        if resumes is not None and (older := older_path(recording.path, resumes)) in published:
            name, chain = published[older]
            resumes = msgspec.structs.replace(resumes, file=name, chain=chain)
        published[recording.path] = target.name, publish_copy(recording, target, resumes=resumes)
        copies.append((recording.path, target))
    return copies
