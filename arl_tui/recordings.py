"""The folder of recordings: names of new files, and what is there."""

import errno
import os
import tempfile
from collections.abc import Callable, Iterable, Iterator
from contextlib import suppress
from pathlib import Path
from typing import TYPE_CHECKING, TypeVar

from core.system.private_files import make_private_folder

if TYPE_CHECKING:
    from core.events import Event

ENDINGS = (".jsonl", ".jsonl.gz", ".jsonl.bz2", ".jsonl.xz", ".jsonl.zip", ".jsonl.zst")
"""Of recordings; of those that are packed in a way which is not read, too, so that none is passed over in
silence."""
CALIBRATION_FOLDER = "calibration"
"""Trials of the reaction-time study: files of another format, in a folder of their own."""

STUDIES = "studies"
"""Folder of studies (`studies.lab.folder`): recordings of participants, and records of other formats."""

Created = TypeVar("Created")


def new_path(folder: Path, participant: str, created_utc: str) -> Path:
    """Return a name that no file has: participant and time, e.g. `P01-20261122T071803Z.jsonl`.

    Another program may take the name before it is used; `create_new` goes on to the next one then.

    Args:
        folder: where recordings are kept.
        participant: pseudonym.
        created_utc: ISO 8601 in UTC with seconds.
    """
    stamp = created_utc.replace("+00:00", "Z").replace("-", "").replace(":", "")
    stem = f"{participant}-{stamp}"
    path = folder / f"{stem}.jsonl"
    number = 2
    while path.exists():
        path = folder / f"{stem}-{number}.jsonl"
        number += 1
    return path


def create_new(
    folder: Path, participant: str, created_utc: str, create: Callable[[Path], Created]
) -> Created:
    """Create a file under a name that no file has, also where several programs do so at once.

    Args:
        folder: where the file is to be; made if missing, readable by its owner only.
        participant: pseudonym.
        created_utc: ISO 8601 in UTC with seconds.
        create: creates the file exclusively; raises FileExistsError where the name has been taken meanwhile.

    Returns:
        What `create` returns.

    Raises:
        OSError: the folder or the file cannot be created.
    """
    make_private_folder(folder)
    while True:
        with suppress(FileExistsError):
            return create(new_path(folder, participant, created_utc))


def all_recordings(
    folder: Path, on_error: Callable[[OSError], object] = lambda error: None
) -> Iterator[Path]:
    """Yield the recordings of sessions in a folder and below, compressed ones too, sorted by name.

    Args:
        folder: where to look; it need not exist.
        on_error: told of every folder below it that cannot be read, and of what is no file.
    """
    if not folder.exists():
        return
    found: list[Path] = []
    for here, folders, names in os.walk(folder, onerror=on_error):
        if Path(here).name == CALIBRATION_FOLDER:
            continue
        found += [
            Path(here, name)
            for name in (*names, *folders)
            if name.endswith(ENDINGS) and not (STUDIES in Path(here).parts and is_study_record(name))
        ]
    for path in sorted(found):
        if path.exists() and not path.is_file() and not path.is_dir():
            # Opening a pipe or a device would wait for ever.
            on_error(OSError(errno.EINVAL, "a pipe or a device, not a file", str(path)))
        else:
            yield path


def is_study_record(name: str) -> bool:
    """Return whether a file in a study's folder is a record of another format: ledger, notes, or a
    sitting.
    """
    return name in ("ledger.jsonl", "notes.jsonl") or name.startswith("sitting-")


def rescue(unwritten: "Iterable[Event]", stem: str) -> Path:
    """Save events that the recording's disk did not take, one JSON object per line; return where.

    Args:
        unwritten: what is missing from the file, in order.
        stem: name of the recording.

    Raises:
        OSError: the folder for temporary files takes nothing either.
    """
    from core.recording.schema import encode  # Not for `arl --help`.

    return _rescued(b"".join(encode(event) + b"\n" for event in unwritten), f"{stem}-unwritten-")


def rescue_whole(content: bytes, stem: str) -> Path:
    """Save a recording whose own file was removed; return where.

    Args:
        content: of the file.
        stem: name of the recording.

    Raises:
        OSError: the folder for temporary files does not take it.
    """
    return _rescued(content, f"{stem}-rescued-")


def _rescued(content: bytes, prefix: str) -> Path:
    # mkstemp: readable by its owner only.
    with tempfile.NamedTemporaryFile(prefix=prefix, suffix=".jsonl", delete=False) as file:
        try:
            file.write(content)
            file.flush()
            os.fsync(file.fileno())
        except OSError:
            os.unlink(file.name)
            raise
    return Path(file.name)
