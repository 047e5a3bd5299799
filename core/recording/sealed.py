"""Read a recording's file in pieces, as its recorder left it: memory does not grow with its length.

The chain is checked on the way. What is not exactly as a recorder writes it (compressed, changed by an
editor, damaged, several recordings in one file) is left to `core.recording.reader`, which puts it right or
names the line.
"""

import hashlib
from collections.abc import Iterator
from dataclasses import dataclass
from operator import itemgetter
from pathlib import Path

from core.recording.chain import CHAIN_DIGITS
from core.recording.lines import CHAIN_MARK
from core.recording.reader import LONGEST_LINE

PIECE = 1 << 18
"""Bytes that are read at once: 256 kB, whose lines stay in the processor's cache while they are gone over
several times."""
LINE_BEGINS = b'{"type":"'
SEAL = len(CHAIN_MARK) + CHAIN_DIGITS + 2
"""Bytes at the end of a line that are its chain: `,"chain":"0123456789abcdef"}`."""
_beginning = itemgetter(slice(len(LINE_BEGINS)))
_payload = itemgetter(slice(-SEAL))
_mark = itemgetter(slice(-SEAL, len(CHAIN_MARK) - SEAL))


class UnusualFileError(Exception):
    """The file is not as a recorder leaves it."""


@dataclass(frozen=True, slots=True)
class Piece:
    """Whole lines that follow each other."""

    offset: int
    """Byte of the file at which the first one begins."""
    lines: list[bytes]
    """Without line ends."""
    payloads: list[bytes]
    """What is sealed, each without the brace that closes it."""


class SealedFile:
    """A recording's file as it is read once from its beginning to its end."""

    def __init__(self, path: Path) -> None:
        """Prepare; nothing is read yet."""
        self._path = path
        self._hash = hashlib.sha256()
        self.chain = ""
        """Of the last line that was read, hex."""
        self.tail = b""
        """After all was read: what stands behind the last whole line."""

    def pieces(self, *, every_line: bool) -> Iterator[Piece]:
        """Yield the lines, checked.

        Args:
            every_line: compare every line's digits with what follows from the lines up to it; otherwise those
                at the end of each piece, which depend on all contents before, but not on earlier digits.

        Raises:
            UnusualFileError: a line is not as a recorder writes it, or its chain does not follow.
            OSError: the file cannot be read.
        """
        offset, length = 0, 0
        begun: list[bytes] = []  # of a line whose end has not been read yet, `length` bytes in all
        with self._path.open("rb") as file:
            while part := file.read(PIECE):
                end = part.rfind(b"\n") + 1
                if end:
                    content = b"".join((*begun, part[:end]))
                    yield self._checked(offset, content, every_line=every_line)
                    offset += len(content)
                    begun, length = [], 0
                begun.append(part[end:])
                length += len(part) - end
                if length > LONGEST_LINE:
                    raise UnusualFileError
        rest = b"".join(begun)
        if not offset or (rest.endswith(b'"}') and CHAIN_MARK in rest[-SEAL:]):
            raise UnusualFileError
        self.tail = rest

    def _checked(self, offset: int, content: bytes, *, every_line: bool) -> Piece:
        if b"\r" in content:
            raise UnusualFileError
        lines = content.split(b"\n")
        lines.pop()
        if b"".join(map(_beginning, lines)) != LINE_BEGINS * len(lines):
            raise UnusualFileError
        if b"".join(map(_mark, lines)) != CHAIN_MARK * len(lines):
            raise UnusualFileError
        payloads = list(map(_payload, lines))
        if every_line:
            for line, payload in zip(lines, payloads, strict=True):
                self._hash.update(payload + b"}")
                if line[-SEAL:] != CHAIN_MARK + self._digits() + b'"}':
                    raise UnusualFileError
        else:
            self._hash.update(b"}".join(payloads) + b"}")
            if lines[-1][-SEAL:] != CHAIN_MARK + self._digits() + b'"}':
                raise UnusualFileError
        self.chain = lines[-1][-CHAIN_DIGITS - 2 : -2].decode()
        return Piece(offset, lines, payloads)

    def _digits(self) -> bytes:
        return self._hash.hexdigest()[:CHAIN_DIGITS].encode()
