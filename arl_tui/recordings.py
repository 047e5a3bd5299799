"""The folder of recordings: names of new files, and what is there."""

from collections.abc import Iterator
from pathlib import Path

DEFAULT_FOLDER = Path("recordings")


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


def all_recordings(folder: Path) -> Iterator[Path]:
    """Yield the recordings in a folder and below, sorted by name."""
    yield from sorted(folder.rglob("*.jsonl"))
