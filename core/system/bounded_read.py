"""Files that others name: a pipe or a device may have no end."""

import errno
from pathlib import Path

MOST_OF_A_DEVICE = 1 << 28
"""Bytes that are taken from a pipe or a device: five times what two hours of a session are."""
PIECE = 1 << 20


class EndlessFileError(OSError):
    """A pipe or a device cannot be read to its end, or need not have one; the message names it."""

    def __init__(self, path: Path, reason: str) -> None:
        """Name the file and the reason; the message says both."""
        super().__init__(errno.EINVAL, f"{reason}: copy what you mean to a file, and name that", str(path))

    def __str__(self) -> str:
        return f"{self.filename}: {self.strerror}"


def read_bounded(path: Path) -> bytes:
    """Return what a file holds.

    Raises:
        EndlessFileError: it is a pipe or a device that gives more than `MOST_OF_A_DEVICE`.
        OSError: it cannot be read.
    """
    if path.is_file():
        return path.read_bytes()
    content = bytearray()
    with path.open("rb") as file:
        while part := file.read(PIECE):
            content += part
            if len(content) > MOST_OF_A_DEVICE:
                raise EndlessFileError(
                    path, f"a pipe or a device that gives more than {MOST_OF_A_DEVICE:,} bytes"
                )
    return bytes(content)
