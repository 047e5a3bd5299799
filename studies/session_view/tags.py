"""Tags and notes on moments of a recording, kept in a file beside it (`FILE.jsonl.tags.json`)."""

import csv
from collections.abc import Callable
from pathlib import Path

import msgspec

from core.numerics.clock import NS_PER_S
from core.system.private_files import write_private
from core.system.whole_file import whole_file

SUFFIX = ".tags.json"
LONGEST_NOTE = 500


class Tag(msgspec.Struct, frozen=True, forbid_unknown_fields=True, order=True):
    """One moment that the viewer marked."""

    time_ns: int
    """On the recording's clock."""
    tag: str
    """A digit from 1 to 9, or any short word."""
    note: str = ""

    def __post_init__(self) -> None:
        if self.time_ns < 0 or not self.tag or len(self.note) > LONGEST_NOTE:
            raise ValueError(
                f"a tag has a time >= 0, a name and a note of at most {LONGEST_NOTE} characters, got {self}"
            )


class _File(msgspec.Struct, frozen=True, forbid_unknown_fields=True):
    tags: list[Tag]
    format: str = "arl-tags"
    version: int = 1


class TagsError(Exception):
    """A file of tags cannot be used."""


class Tags:
    """The tags of one recording; every change is on the disk when the call returns."""

    def __init__(self, recording: Path) -> None:
        """Read the tags of a recording, if there are any.

        Raises:
            TagsError: the file is damaged; it is left as it is.
        """
        self.path = recording.with_name(recording.name + SUFFIX)
        self.all: list[Tag] = []
        try:
            content = self.path.read_bytes()
        except FileNotFoundError:
            return
        try:
            self.all = sorted(msgspec.json.decode(content, type=_File).tags)
        except (msgspec.DecodeError, ValueError) as error:
            raise TagsError(
                f"{self.path}: these tags cannot be read: {error}. Mend the file, or move it away"
            ) from error

    def add(self, tag: Tag) -> None:
        """Add a tag.

        Raises:
            OSError: the file cannot be written; the tag is not added then.
        """
        self._write(sorted([*self.all, tag]))

    def remove(self, tag: Tag) -> None:
        """Remove a tag."""
        kept = list(self.all)
        kept.remove(tag)
        self._write(kept)

    def near(self, time_ns: int, within_ns: int) -> Tag | None:
        """Return the tag nearest to a time; None where none is within `within_ns`."""
        found = min(self.all, key=lambda tag: abs(tag.time_ns - time_ns), default=None)
        return found if found is not None and abs(found.time_ns - time_ns) <= within_ns else None

    def _write(self, tags: list[Tag]) -> None:
        write_private(self.path, msgspec.json.format(msgspec.json.encode(_File(tags)), indent=1) + b"\n")
        self.all = tags


def write_tags_csv(
    path: Path, tags: list[Tag], facts: Callable[[int], dict[str, object]], start_ns: int
) -> None:
    """Write tagged moments as a table.

    Args:
        path: of the new file.
        tags: in order.
        facts: what else is known of a time, the same columns for each.
        start_ns: of the recording; times are given in seconds after it.
    """
    names = list(facts(start_ns))
    with whole_file(path) as file:
        writer = csv.DictWriter(file, ["time_s", "time_ns", "tag", "note", *names], lineterminator="\n")
        writer.writeheader()
        for tag in tags:
            about = {
                "time_s": f"{(tag.time_ns - start_ns) / NS_PER_S:.6f}",
                "time_ns": tag.time_ns,
                "tag": tag.tag,
                "note": tag.note,
            }
            writer.writerow(about | facts(tag.time_ns))
