"""Files about participants: readable by their owner only, in folders that only their owner can open.

On systems without POSIX permissions (Windows) the modes have no effect; the folder's own rights hold there.
"""

import os
from pathlib import Path
from typing import BinaryIO

FILE_MODE = 0o600
FOLDER_MODE = 0o700


def make_private_folder(folder: Path) -> None:
    """Make a folder, and those above it that are missing, with mode 0700. An existing folder keeps its mode.

    Raises:
        OSError: it cannot be made, or there is a file of that name.
    """
    if folder.is_dir():
        return
    if folder.parent != folder:
        make_private_folder(folder.parent)
    folder.mkdir(mode=FOLDER_MODE, exist_ok=True)


def create_private(path: Path) -> BinaryIO:
    """Create a file with mode 0600 and open it for reading and writing, unbuffered.

    Raises:
        FileExistsError: there is a file at `path` already; it is not touched.
        OSError: the file cannot be created.
    """
    descriptor = os.open(path, os.O_RDWR | os.O_CREAT | os.O_EXCL | getattr(os, "O_BINARY", 0), FILE_MODE)
    return os.fdopen(descriptor, "r+b", buffering=0)


def write_private(path: Path, content: bytes) -> None:
    """Write a file with mode 0600 so that it is there completely or not at all, also after a crash.

    Raises:
        OSError: the disk does not take it; what was at `path` before is still there. `filename` is `path`.
    """
    new = path.with_name(f".{path.name}.{os.getpid()}.new")
    new.unlink(missing_ok=True)
    try:
        with create_private(new) as file:
            write_all(file, content)
            os.fsync(file.fileno())
        new.replace(path)
    except OSError as error:
        if error.filename in (None, str(new)):
            error.filename, error.filename2 = str(path), None
        raise
    finally:
        new.unlink(missing_ok=True)


def write_all(file: BinaryIO, content: bytes) -> None:
    """Write every byte to an unbuffered file: the system may take fewer than it is offered.

    Raises:
        OSError: the disk took only a part, and then no more; the part stands in the file.
    """
    left = memoryview(content)
    while left:
        taken = file.write(left)
        if not taken:
            raise OSError(
                5, f"the disk took {len(content) - len(left)} of {len(content)} bytes, and then none"
            )
        left = left[taken:]


def sync_folder(folder: Path) -> None:
    """Force the names in a folder to the disk, where the system can do that."""
    try:
        descriptor = os.open(folder, os.O_RDONLY)
    except OSError:
        return  # Windows opens no folders.
    try:
        os.fsync(descriptor)
    except OSError:
        return  # Some network file systems sync no folders.
    finally:
        os.close(descriptor)
