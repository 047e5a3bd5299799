"""The text of a table file: compressed or not, in whatever code page, within bounds.

The bound is on what a file holds when it is unpacked, because a few kilobytes can unpack to gigabytes.
"""

import codecs
import zlib
from dataclasses import dataclass
from pathlib import Path

from studies.reaction_time.tables.contract import ReadError, shown

MOST_BYTES = 64 * 2**20
"""Unpacked bytes of one file. Its cells take some ten times as much memory."""
_CHUNK = 2**20
_BINARY = {
    b"PK\x03\x04": (
        "an Excel or OpenDocument workbook (or another zip archive); save the sheet as CSV in UTF-8"
    ),
    b"\xd0\xcf\x11\xe0": "an old Excel workbook or an E-Prime .edat; export it as text (E-DataAid: Export)",
    b"PAR1": "a Parquet file; write it as CSV, e.g. with pandas",
    b"\x89HDF": "an HDF5 file; write the table as CSV",
    b"%PDF": "a PDF",
    b"$FL2": "an SPSS file; save it as CSV",
    b"BZh": "compressed with bzip2; unpack it first",
    b"\xfd7zXZ": "compressed with xz; unpack it first",
}


@dataclass(frozen=True, slots=True)
class Text:
    """The text of a file."""

    content: str
    notes: tuple[str, ...]
    """How it was read where that is worth saying."""


def read_text(path: Path, encoding: str | None = None) -> Text:
    """Return the text of a plain or gzipped file.

    Args:
        path: the file.
        encoding: its code page by Python's name; None takes UTF-8, UTF-16, and else Windows-1252 with a note.

    Raises:
        ReadError: the file cannot be read, is cut off or damaged as a gzip file, unpacks to more than
            `MOST_BYTES`, is no text, or is not in the stated encoding.
    """
    raw = _bytes_of(path)
    for mark, what in _BINARY.items():
        if raw.startswith(mark):
            raise ReadError(f"{path}: this is {what}")
    if encoding is not None:
        return Text(_decoded(path, raw, encoding), ())
    for bom, name in ((codecs.BOM_UTF8, "utf-8-sig"), *((bom, "utf-32") for bom in _UTF_32), *_UTF_16):
        if raw.startswith(bom):
            return Text(_decoded(path, raw, name), ())
    half = _utf_16_without_mark(raw)
    if half is not None:
        return Text(_decoded(path, raw, half), (f"read as {half.upper()}: every other byte is 0",))
    if b"\0" in raw:
        at = raw.index(b"\0")
        line = raw[:at].count(b"\n") + 1
        raise ReadError(
            f"{path}:{line}: a zero byte: this is no text file, or one damaged by a crash; export it as text"
            " again"
        )
    try:
        return Text(raw.decode("utf-8"), ())
    except UnicodeDecodeError as error:
        return _windows_text(path, raw, error)


_UTF_32 = (codecs.BOM_UTF32_LE, codecs.BOM_UTF32_BE)
_UTF_16 = ((codecs.BOM_UTF16_LE, "utf-16"), (codecs.BOM_UTF16_BE, "utf-16"))


def _bytes_of(path: Path) -> bytes:
    try:
        with path.open("rb") as file:
            raw = file.read(MOST_BYTES + 1)
    except OSError as error:
        raise ReadError(f"{path}: cannot be read ({error.strerror or error})") from error
    if raw.startswith(b"\x1f\x8b"):
        raw = _unpacked(path, raw)
    elif path.suffix == ".gz":
        raise ReadError(
            f"{path}: cannot be read as a gzip file: it does not begin like one. Is it unpacked already?"
        )
    if len(raw) > MOST_BYTES:
        raise ReadError(
            f"{path}: more than {MOST_BYTES // 2**20} MB of text; write the columns that are needed to a"
            " smaller table, or split it by participants (several files may be named)"
        )
    return raw


def _unpacked(path: Path, packed: bytes) -> bytes:
    """Unpack all members of a gzip file, and stop just above `MOST_BYTES`."""
    parts: list[bytes] = []
    size = 0
    rest = packed
    while rest.strip(b"\0"):  # gzip files may be padded with zeros
        member = zlib.decompressobj(wbits=31)
        try:
            while not member.eof and size <= MOST_BYTES:
                part = member.decompress(rest, _CHUNK)
                rest = member.unconsumed_tail
                parts.append(part)
                size += len(part)
                if not part and not rest:
                    break
        except zlib.error as error:
            raise ReadError(_cut(path, b"".join(parts), f"is damaged ({error})")) from error
        if size > MOST_BYTES:
            break
        if not member.eof:
            raise ReadError(_cut(path, b"".join(parts), "ends in the middle"))
        rest = member.unused_data
    return b"".join(parts)


def _cut(path: Path, got: bytes, how: str) -> str:
    lines = got.count(b"\n")
    return (
        f"{path}: cannot be read whole: the compressed file {how}, after line {lines} of the table. Was a"
        f" copy or a download cut off? Fetch it again, or take the {lines} whole lines that can be had: gzip"
        " -cd FILE > FILE.csv"
    )


def _decoded(path: Path, raw: bytes, encoding: str) -> str:
    try:
        return raw.decode(
            "utf-8-sig" if encoding.lower().replace("_", "-") in ("utf-8", "utf8") else encoding
        )
    except LookupError as error:
        raise ReadError(
            f"{path}: no encoding is called {shown(encoding)}; e.g. utf-8, cp1252, cp1250"
        ) from error
    except (UnicodeDecodeError, UnicodeError) as error:
        at = error.start if isinstance(error, UnicodeDecodeError) else 0
        line = raw[:at].count(b"\n") + 1
        raise ReadError(f"{path}:{line}: cannot be read as text in {encoding} ({error})") from error


def _utf_16_without_mark(raw: bytes) -> str | None:
    """Return the byte order of a text in UTF-16 that lacks its mark: in ASCII text every other byte is 0."""
    head = raw[:2000]
    if len(head) < 4:
        return None
    if head[1::2].count(0) > 0.8 * len(head[1::2]) and not head[::2].count(0):
        return "utf-16-le"
    if head[::2].count(0) > 0.8 * len(head[::2]) and not head[1::2].count(0):
        return "utf-16-be"
    return None


def _windows_text(path: Path, raw: bytes, error: UnicodeDecodeError) -> Text:
    line = raw[: error.start].count(b"\n") + 1
    try:
        content = raw.decode("cp1252")
    except UnicodeDecodeError:
        raise ReadError(
            f"{path}:{line}: cannot be read as text in UTF-8 (byte {raw[error.start]:#04x}), nor as"
            " Windows-1252; name its encoding (`arl fit --encoding cp1250`, mac_roman, shift_jis ...) or"
            " save it as UTF-8"
        ) from None
    words = content[max(0, error.start - 200) : error.start + 30]
    at = min(error.start, 200)
    begin = max((words.rfind(sign, 0, at) for sign in '\n\r\t;, "'), default=-1) + 1
    word = words[begin : at + 12].split("\n")[0].split(";")[0].split(",")[0].split("\t")[0].split("\r")[0]
    return Text(
        content,
        (
            (
                f"not UTF-8 (line {line}): read as Windows-1252, e.g. {shown(word)}. If letters are wrong,"
                " name the encoding (--encoding); digits are the same in all"
            ),
        ),
    )
