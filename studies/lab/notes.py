"""Notes of the experimenter, with their times, in a file of their own."""

import os
import re
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

import msgspec

from core.numerics.clock import wall_time_utc
from core.recording.chain import Chain
from studies.lab.ledger import exclusive
from studies.lab.sealed import append_sealed, open_sealed_lines

NAME = "notes.jsonl"
ADVICE = "Nobody but `arl study` may write this file. What stands before that line is as it was written"


class Note(
    msgspec.Struct, frozen=True, kw_only=True, tag_field="type", tag="note", forbid_unknown_fields=True
):
    """What an experimenter has written down."""

    at_utc: str
    """Wall time, ISO 8601."""
    text: str
    running: tuple[str, ...] = ()
    """Codes of the participants whose sittings were running."""


_decoder = msgspec.json.Decoder(Note)


def add_note(data: Path, text: str, running: tuple[str, ...] = ()) -> Note:
    """Write a note down; it is on the disk when this returns.

    Args:
        data: folder of the study's data.
        text: of the note.
        running: codes of the participants whose sittings are running.

    Raises:
        SealedFileError: the notes were changed.
        OSError: the disk does not take it.
    """
    note = Note(at_utc=wall_time_utc(), text=text, running=running)
    with _opened(data) as handle:
        _, chain, size = open_sealed_lines(data / NAME, (data / NAME).read_bytes(), _decoder, advice=ADVICE)
        os.ftruncate(handle, size)
        os.lseek(handle, 0, os.SEEK_END)
        append_sealed(handle, chain, note)
    return note


def read_notes(data: Path) -> tuple[Note, ...]:
    """Return all notes; none where there is no file.

    Raises:
        SealedFileError: the notes were changed.
    """
    path = data / NAME
    if not path.exists():
        return ()
    return open_sealed_lines(path, path.read_bytes(), _decoder, advice=ADVICE)[0]


def forget(data: Path, code: str, by: str) -> None:
    """Write the notes anew with `by` in place of a participant's code.

    The new file takes the old one's name in one step, so that a kill leaves the old or the new one.
    """
    if not (data / NAME).exists():
        return
    with _opened(data):
        chain, new = Chain(), data / f"{NAME}.new"
        with os.fdopen(os.open(new, os.O_CREAT | os.O_TRUNC | os.O_WRONLY, 0o600), "wb") as file:
            for note in read_notes(data):
                running = tuple(by if one == code else one for one in note.running)
                changed = msgspec.structs.replace(note, text=_without(note.text, code, by), running=running)
                file.write(chain.seal(msgspec.json.encode(changed)))
            file.flush()
            os.fsync(file.fileno())
        os.replace(new, data / NAME)


@contextmanager
def _opened(data: Path) -> Iterator[int]:
    """Open the file while no other program writes to it."""
    with exclusive(data / "notes.lock"):
        handle = os.open(data / NAME, os.O_CREAT | os.O_RDWR, 0o600)
        try:
            yield handle
        finally:
            os.close(handle)


def _without(text: str, code: str, by: str) -> str:
    """Replace a code where it stands as a word of its own: codes are short."""
    return re.sub(rf"(?<![\w-]){re.escape(code)}(?![\w-])", by, text)
