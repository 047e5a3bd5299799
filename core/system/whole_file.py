"""Files that a user asks for: written whole, or what was there before stays.

`core.system.private_files` writes files about participants.
"""

import os
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import TextIO


@contextmanager
def whole_file(path: Path, *, newline: str = "", errors: str = "strict") -> Iterator[TextIO]:
    """Open a text file for writing; it takes its name, or another file's place, when all has been written.

    Where an error ends the block, nothing is left of it. A device or a pipe (`/dev/stdout`) is written to
    directly; so is a file whose folder takes no new ones.

    Args:
        path: of the file.
        newline: as `open` takes it.
        errors: as `open` takes it.

    Raises:
        OSError: it cannot be written; `filename` is `path`.
    """
    target = path.resolve()
    part = None if target.exists() and not target.is_file() else _part_of(target)
    try:
        with (part or target).open("w", encoding="utf-8", newline=newline, errors=errors) as file:
            yield file
            if part is not None:
                file.flush()
                os.fsync(file.fileno())
        if part is not None:
            part.replace(target)
    except OSError as error:
        if error.filename in (None, str(part), str(target)):
            error.filename, error.filename2 = str(path), None
        raise
    finally:
        if part is not None:
            part.unlink(missing_ok=True)


def write_whole(path: Path, text: str) -> None:
    """Write a text file as `whole_file` does.

    Raises:
        OSError: it cannot be written; `filename` is `path`.
    """
    with whole_file(path, newline="\n") as file:
        file.write(text)


def _part_of(target: Path) -> Path | None:
    """Create the file that is written first; None where its folder takes no new files."""
    part = target.with_name(f".{target.name[:100]}.{os.getpid()}.part")
    mode = target.stat().st_mode & 0o777 if target.exists() else 0o666
    try:
        part.unlink(missing_ok=True)
        os.close(os.open(part, os.O_CREAT | os.O_EXCL | os.O_WRONLY, mode))
    except (PermissionError, FileNotFoundError, NotADirectoryError):
        return None  # `open` writes it directly, or says what is wrong
    return part
