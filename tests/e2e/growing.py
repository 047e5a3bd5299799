"""A recording that is being written, read along."""

from typing import BinaryIO


class Growing:
    """The new presses of a recording, each once and whole.

    A line is written at once, but where it crosses a page of memory its beginning can be read before its end.
    """

    def __init__(self, file: BinaryIO) -> None:
        """Read along.

        Args:
            file: the recording; what lies before its position is not looked at.
        """
        self._file = file
        self._begun = b""
        """Of a line whose end has not been read."""

    def new_presses(self) -> list[bytes]:
        """Return the lines of presses that have been written since it was last asked."""
        *lines, self._begun = (self._begun + self._file.read()).split(b"\n")
        return [line for line in lines if line.startswith(b'{"type":"key-pressed"')]

    def close(self) -> None:
        """Read no further."""
        self._file.close()
