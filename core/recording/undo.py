"""Undo what editors, version control and packers do to a recording's file, and say what was undone.

Nothing here is trusted: the recording's chain is checked afterwards, on the bytes as they were recorded.
"""

import bz2
import codecs
import lzma
import zlib
from collections.abc import Callable, Iterator
from dataclasses import dataclass
from pathlib import Path
from typing import Protocol

MOST_UNPACKED = 1 << 29
"""Bytes that are unpacked of a compressed file: two hours of a session are a tenth of it."""
PIECE = 1 << 24
"""Bytes that are unpacked at a time: of a file that holds too much, no more than the limit is in memory."""


class RecordingError(Exception):
    """A recording cannot be used; the message says where, what came, what was expected, what to do."""


@dataclass(frozen=True, slots=True)
class AsRecorded:
    """A file's content as it was recorded."""

    content: bytes
    notes: tuple[str, ...]
    """What was undone, in plain sentences."""
    packed_cut: bool = False
    """The file is compressed, and its end is missing."""


class _Unpacker(Protocol):
    @property
    def eof(self) -> bool: ...

    @property
    def unused_data(self) -> bytes: ...

    def decompress(self, data: bytes, max_length: int, /) -> bytes: ...


def _gzip() -> _Unpacker:
    return zlib.decompressobj(wbits=16 + zlib.MAX_WBITS)


_PACKED = (
    (b"\x1f\x8b", "gzip", _gzip),
    (b"BZh", "bzip2", bz2.BZ2Decompressor),
    (b"\xfd7zXZ\x00", "xz", lzma.LZMADecompressor),
)
_TO_UNPACK = {
    b"PK\x03\x04": "a zip archive: unpack it (`unzip`)",
    b"\x28\xb5\x2f\xfd": "compressed with zstd: unpack it (`zstd -d`)",
    b"7z\xbc\xaf\x27\x1c": "a 7z archive: unpack it (`7z x`)",
    b"Rar!": "a RAR archive: unpack it",
}
"""How files begin that this program does not unpack."""
_MANGLED_BOM = "\ufeff".encode().decode("cp1252").encode()
"""A byte-order mark that was read as Windows-1252 and written as UTF-8."""


def as_recorded(path: Path, content: bytes) -> AsRecorded:
    """Return the content of a recording's file as it was recorded.

    Undone are compression (gzip, bzip2, xz), UTF-16, byte-order marks, and line ends of Windows and of old
    Macs.

    Args:
        path: of the file, for messages.
        content: its bytes.

    Raises:
        RecordingError: the file is empty, an archive, or its compression is damaged.
    """
    if not content:
        raise RecordingError(
            f"{path}: the file is empty: 0 bytes. The copy failed, or the disk was full when the session "
            "began. "
            "Take the original again; if that is empty, too, nothing was recorded"
        )
    for magic, what in _TO_UNPACK.items():
        if content.startswith(magic):
            raise RecordingError(f"{path}: {what}, and name the recording in it")
    notes: list[str] = []
    packed_cut = False
    for magic, name, unpacker in _PACKED:
        if content.startswith(magic):
            content, packed_cut = _unpack(path, content, name, magic, unpacker)
            notes.append(f"the file is compressed ({name}); it was unpacked in memory")
            if packed_cut:
                notes.append(f"the {name} file is cut off: its end is missing. Take the original again")
            break
    content = _in_utf8(path, content, notes)
    return AsRecorded(_with_own_line_ends(content, notes), tuple(notes), packed_cut)


def _unpack(
    path: Path, content: bytes, name: str, magic: bytes, new_unpacker: Callable[[], _Unpacker]
) -> tuple[bytes, bool]:
    """Return what a compressed file holds, all of its parts, and whether its end is missing."""
    unpacker, pieces, n_bytes = new_unpacker(), list[bytes](), 0
    try:
        rest = content
        while rest.startswith(magic) and n_bytes <= MOST_UNPACKED:
            unpacker = new_unpacker()
            for piece in _pieces(unpacker, rest):
                pieces.append(piece)
                n_bytes += len(piece)
                if n_bytes > MOST_UNPACKED:
                    break
            rest = unpacker.unused_data if unpacker.eof else b""
    except (zlib.error, OSError, lzma.LZMAError) as error:
        raise RecordingError(
            f"{path}: the file is compressed ({name}) and damaged: {error}. Take the original again"
        ) from error
    if n_bytes > MOST_UNPACKED:
        raise RecordingError(
            f"{path}: the file is compressed ({name}) and holds more than {MOST_UNPACKED:,} bytes, more than "
            "any session records. If it is one, unpack it, and name the unpacked file"
        )
    if unpacker.eof and unpacker.unused_data.strip(b"\0"):
        raise RecordingError(
            f"{path}: behind the compressed recording ({name}) stand {len(unpacker.unused_data)} more bytes; "
            "was something appended? Take the original again"
        )
    if not n_bytes:
        raise RecordingError(
            f"{path}: the file is compressed ({name}) and holds nothing: it is empty, or cut off. Take "
            "the original again"
        )
    return b"".join(pieces), not unpacker.eof


def _pieces(unpacker: _Unpacker, packed: bytes) -> Iterator[bytes]:
    """Yield what one part of a compressed file holds, at most `PIECE` bytes at a time."""
    piece = unpacker.decompress(packed, PIECE)
    while piece:
        yield piece
        if unpacker.eof:
            return
        # What was not used: gzip hands it back, the others keep it.
        piece = unpacker.decompress(getattr(unpacker, "unconsumed_tail", b""), PIECE)


def _in_utf8(path: Path, content: bytes, notes: list[str]) -> bytes:
    """Return text of UTF-16 in UTF-8, and any text without its byte-order mark."""
    wide = ""
    if content.startswith((codecs.BOM_UTF16_LE, codecs.BOM_UTF16_BE)):
        wide = "utf-16"
    elif content[:2] in (b"{\0", b"\0{"):
        wide = "utf-16-le" if content[0] else "utf-16-be"
    if wide:
        try:
            content = content.decode(wide).encode()
        except UnicodeDecodeError as error:
            raise RecordingError(
                f"{path}: the file was rewritten as UTF-16 text and is damaged at byte {error.start}. Take "
                "the original again"
            ) from error
        notes.append("the file was rewritten as UTF-16 text (as PowerShell's > does); it was read as UTF-8")
    for mark in (codecs.BOM_UTF8, _MANGLED_BOM):
        if content.startswith(mark):
            content = content.removeprefix(mark)
            notes.append("the file begins with a byte-order mark, as some editors write; it was left out")
    return content


def _with_own_line_ends(content: bytes, notes: list[str]) -> bytes:
    n_windows = content.count(b"\r\n")
    if n_windows:
        which = "lines end" if n_windows == content.count(b"\n") else f"{n_windows} of the lines end"
        notes.append(f"the {which} as on Windows (CR LF), as git or an editor writes them; that was undone")
        return content.replace(b"\r\n", b"\n")
    if b"\r" in content and b"\n" not in content:
        notes.append("the lines end as on old Macs (CR); that was undone")
        return content.replace(b"\r", b"\n")
    return content
