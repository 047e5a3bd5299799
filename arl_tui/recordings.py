"""The folder of recordings: names of new files, and what is there."""

import os
import tempfile
from collections.abc import Callable, Iterable, Iterator
from pathlib import Path
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from core.episode import Event

ENDINGS = (".jsonl", ".jsonl.gz", ".jsonl.bz2", ".jsonl.xz", ".jsonl.zip", ".jsonl.zst")
"""Of recordings; of those that are packed in a way which is not read, too, so that none is passed over in silence."""
CALIBRATION_FOLDER = "calibration"
"""Trials of the reaction-time study: files of another format, in a folder of their own."""


def new_path(folder: Path, participant: str, created_utc: str) -> Path:
    """Return a name that no file has: participant and time, e.g. `P01-20261122T071803Z.jsonl`.

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


def all_recordings(
    folder: Path, on_error: Callable[[OSError], object] = lambda error: None
) -> Iterator[Path]:
    """Yield the recordings of sessions in a folder and below, compressed ones too, sorted by name.

    Args:
        folder: where to look; it need not exist.
        on_error: told of every folder below it that cannot be read.
    """
    if not folder.exists():
        return
    found: list[Path] = []
    for here, folders, names in os.walk(folder, onerror=on_error):
        if Path(here).name == CALIBRATION_FOLDER:
            continue
        found += [Path(here, name) for name in (*names, *folders) if name.endswith(ENDINGS)]
    yield from sorted(found)


def rescue(unwritten: "Iterable[Event]", stem: str) -> Path:
    """Save events that the recording's disk did not take, one JSON object per line; return where.

    Args:
        unwritten: what is missing from the file, in order.
        stem: name of the recording.

    Raises:
        OSError: the folder for temporary files takes nothing either.
    """
    from core.recording.schema import encode  # Not for `arl --help`.

    with tempfile.NamedTemporaryFile(prefix=f"{stem}-unwritten-", suffix=".jsonl", delete=False) as file:
        for event in unwritten:
            file.write(encode(event) + b"\n")
    return Path(file.name)
