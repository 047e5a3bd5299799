"""What lies in a folder of data: recordings, reaction trials, sittings, told apart by their first lines."""

import os
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path
from typing import Literal

import msgspec

from core.recording.schema import FORMAT as RECORDING
from core.system.bounded_read import EndlessFileError
from studies.lab.sitting_log import FORMAT as SITTING
from studies.reaction_time.trial_log import FORMAT as TRIALS

PACKED = (".jsonl.gz", ".jsonl.bz2", ".jsonl.xz", ".jsonl.zip", ".jsonl.zst")
"""Ends of names of packed recordings. The last two are not read: reading them says so."""
LONGEST_HEADER = 1 << 22
"""Bytes of a first line that are looked at."""
_KINDS: dict[str, Literal["recording", "trials", "sitting"]] = {
    RECORDING: "recording",
    TRIALS: "trials",
    SITTING: "sitting",
}


@dataclass(frozen=True, slots=True)
class Source:
    """One file."""

    path: Path
    relative: Path
    """Below the folder that was named; of a single file, its name."""
    kind: Literal["recording", "trials", "sitting", "other"]
    format: str = ""
    """What a file of another kind says it is; empty where it does not say."""

    @property
    def session(self) -> str:
        """Name of the session in tables: unique, also where a file lies beside a packed copy of itself."""
        return self.relative.as_posix().removesuffix(".jsonl")


@dataclass(frozen=True, slots=True)
class Trouble:
    """A file that could not be used, or not as a whole."""

    path: Path
    reason: str

    def __str__(self) -> str:
        return self.reason if str(self.path) in self.reason else f"{self.path}: {self.reason}"


class _Said(msgspec.Struct):
    format: str = ""


def find_sources(place: Path) -> Iterator[Source]:
    """Yield the files of data in a folder and below, in the order of their names; or the one file.

    Args:
        place: a folder, or a file.

    Raises:
        OSError: a folder or a file cannot be read, or there is a pipe or a device.
    """
    if not place.is_dir():
        yield _source(place, Path(place.name))
        return

    def give_up(error: OSError) -> None:
        raise error

    for folder, below, names in os.walk(place, onerror=give_up):
        below.sort()
        for name in sorted(names):
            path = Path(folder, name)
            if name.endswith((".jsonl", *PACKED)):
                yield _source(path, path.relative_to(place))


def _source(path: Path, relative: Path) -> Source:
    if path.exists() and not path.is_file():
        # Opening a pipe would wait for a writer, and a device may have no end.
        raise EndlessFileError(path, "a pipe or a device, not a file")
    if path.name.endswith(PACKED):
        return Source(path, relative, "recording")
    with path.open("rb") as file:
        first = file.readline(LONGEST_HEADER)
    try:
        said = msgspec.json.decode(first.removeprefix(b"\xef\xbb\xbf"), type=_Said).format
    except (msgspec.DecodeError, UnicodeDecodeError):
        # A damaged recording must be named as one, and not passed over as a file of another kind.
        return Source(path, relative, "recording")
    return Source(path, relative, _KINDS.get(said, "other"), said)
