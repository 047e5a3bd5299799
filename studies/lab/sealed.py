"""Files of JSON lines that are sealed like recordings: each line ends with the running hash over all lines so
far.
"""

import contextlib
import os
from pathlib import Path
from typing import TypeVar

import msgspec

from core.recording.chain import CHAIN_DIGITS, Chain

_MARK = b',"chain":"'
Line = TypeVar("Line")


class SealedFileError(ValueError):
    """A sealed file cannot be used; the message says where, what is wrong and what to do."""


def open_sealed_lines(
    path: Path, content: bytes, decoder: "msgspec.json.Decoder[Line]", *, advice: str
) -> tuple[tuple[Line, ...], Chain, int]:
    """Check and decode sealed lines.

    A last line without its newline is left out: its writer was killed.

    Args:
        path: of the file, for messages.
        content: of the file.
        decoder: of one line without its seal.
        advice: what to do where a line was changed; ends the message.

    Returns:
        The lines, the chain after them, and how many bytes they take.

    Raises:
        SealedFileError: a line was changed, lost or moved, or is of an unknown kind.
    """
    whole, newline, _ = content.rpartition(b"\n")
    chain = Chain()
    lines: list[Line] = []
    for number, sealed in enumerate(whole.split(b"\n") if newline else [], start=1):
        payload, mark, rest = sealed.rpartition(_MARK)
        if not mark or chain.advance(payload + b"}") != rest[:CHAIN_DIGITS]:
            raise SealedFileError(f"{path}:{number}: this line was changed, or one before it. {advice}")
        try:
            lines.append(decoder.decode(payload + b"}"))
        except msgspec.MsgspecError as error:
            raise SealedFileError(f"{path}:{number}: {error}. Was it written by a newer version?") from error
    return tuple(lines), chain, len(whole) + len(newline)


def append_sealed(handle: int, chain: Chain, line: msgspec.Struct) -> None:
    """Write one line at the end of an open file; it is on the disk when this returns.

    Raises:
        OSError: the disk did not take the line. Nothing of it is in the file, so another one can follow.
    """
    before, end = chain.copy(), os.lseek(handle, 0, os.SEEK_END)
    rest = memoryview(chain.seal(msgspec.json.encode(line)))
    try:
        while rest:
            rest = rest[os.write(handle, rest) :]
        os.fsync(handle)
    except OSError:
        chain.go_back_to(before)
        with contextlib.suppress(OSError):  # cutting needs no room on the disk
            os.ftruncate(handle, end)
        raise
