"""The ledger of a study: an append-only file that says who has which place, and how far each participant is.

Several computers may share it in one folder. A writer holds a lock on the file, reads what others have
written meanwhile, and forces the line to the disk. Every line is sealed like those of a recording.

A place and a code are claimed by creating a file that must not exist yet. So they stay unique on file
systems whose locks do not work.
"""

import hashlib
import os
import sys
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Literal

import msgspec

from core.numerics.clock import wall_time_utc
from core.recording.chain import Chain
from studies.lab.folder import PARTICIPANTS
from studies.lab.sealed import SealedFileError, append_sealed, open_sealed_lines

if sys.platform != "win32":
    import fcntl

FORMAT: Literal["arl-study-ledger"] = "arl-study-ledger"
VERSION = 1
ADVICE = (
    "Nobody but `arl study` may write this file. Take the newest copy from a backup; recordings are not "
    "affected"
)


class LedgerError(SealedFileError):
    """The ledger cannot be used; the message says where and what to do."""


class Entry(
    msgspec.Struct,
    frozen=True,
    kw_only=True,
    tag_field="type",
    forbid_unknown_fields=True,
    omit_defaults=True,
):
    """Base of all lines."""

    at_utc: str = ""
    """When the line was written, ISO 8601; filled in by `Ledger.append`."""


class Opened(Entry, frozen=True, kw_only=True, tag="opened", omit_defaults=False):
    """First line: which study this is."""

    format: Literal["arl-study-ledger"] = FORMAT
    version: int = VERSION
    study: str
    """Name of the study."""
    seed: int


class Enrolled(Entry, frozen=True, kw_only=True, tag="enrolled"):
    """A participant has got a place."""

    code: str
    place: int
    """From 0."""
    order: tuple[str, ...]
    """Conditions, first to last."""
    simulated: bool = False


class Declined(Entry, frozen=True, kw_only=True, tag="declined"):
    """A participant did not consent. Nothing else is kept."""


class SittingStarted(Entry, frozen=True, kw_only=True, tag="sitting-started"):
    """A participant has begun a sitting, or goes on with one."""

    code: str
    sitting: int
    """From 0."""
    attempt: int
    """From 0; one more for every time it was begun."""
    run: int = 0
    """From 0; one more where the sitting begins anew instead of going on."""
    first_step: int = 0
    """Step at which this attempt begins."""
    decided: Literal["resume", "restart"] | None = None
    """What the experimenter decided about a sitting that broke off; None: the study's rule was followed."""


class StepDone(Entry, frozen=True, kw_only=True, tag="step-done"):
    """A step of the timeline is over."""

    code: str
    sitting: int
    step: int
    """Place of the step in its sitting, from 0."""


class SittingEnded(Entry, frozen=True, kw_only=True, tag="sitting-ended"):
    """A sitting has ended."""

    code: str
    sitting: int
    how: Literal["finished", "stopped", "window-closed", "failed"]


class DroppedOut(Entry, frozen=True, kw_only=True, tag="dropped-out"):
    """The experimenter, or the study's rule, counts a participant as dropped out."""

    code: str
    reason: str


class Withdrawn(Entry, frozen=True, kw_only=True, tag="withdrawn"):
    """A participant has withdrawn. Their lines carry a number in place of the code from now on."""

    code: str
    """The number, such as "withdrawn-1"."""
    files_removed: int


Line = Opened | Enrolled | Declined | SittingStarted | StepDone | SittingEnded | DroppedOut | Withdrawn
_decoder: msgspec.json.Decoder[Line] = msgspec.json.Decoder(Line)


def read_ledger(path: Path) -> tuple[Line, ...]:
    """Return the lines of a ledger, checked.

    A last line that was cut off in the middle is left out: its writer was killed, and the next one to
    append removes it.

    Raises:
        LedgerError: the file is not a ledger, or a line was changed.
        OSError: the file cannot be read.
    """
    return _checked(path, path.read_bytes())[0]


def _checked(path: Path, content: bytes) -> tuple[tuple[Line, ...], Chain, int]:
    try:
        lines, chain, size = open_sealed_lines(path, content, _decoder, advice=ADVICE)
    except SealedFileError as error:
        raise LedgerError(str(error)) from error
    if lines and not isinstance(lines[0], Opened):
        raise LedgerError(f"{path}:1: not a ledger: the first line is of type {type(lines[0]).__name__}")
    return lines, chain, size


class Ledger:
    """A study's ledger in its folder of data.

    Args:
        folder: of the study's data; made where it is missing.
        study: name of the study.
        seed: of the study.

    Raises:
        LedgerError: the folder holds the ledger of another study, or of another seed, or participants and no
            ledger.
    """

    def __init__(self, folder: Path, *, study: str, seed: int) -> None:
        folder.mkdir(mode=0o700, parents=True, exist_ok=True)
        self.folder = folder
        self.study = study
        self.seed = seed
        self.path = folder / "ledger.jsonl"
        check_not_lost(folder)
        with self._locked() as lines:
            if not lines:
                self._append_line(Opened(study=study, seed=seed))
                return
            first = lines[0]
            assert isinstance(first, Opened), "checked while reading"
            if (first.study, first.seed) != (study, seed):
                raise LedgerError(
                    f"{self.path} belongs to the study {first.study!r} with seed {first.seed}, not to "
                    f"{study!r} with seed {seed}. "
                    "A running study keeps its name and its seed: change them back, or use another folder"
                )

    def lines(self) -> tuple[Line, ...]:
        """Return what has been written so far, by all computers."""
        return read_ledger(self.path)

    def append(self, entry: Line) -> None:
        """Add a line; it is on the disk when this returns."""
        with self._locked():
            self._append_line(entry)

    def decide(self, choose: Callable[[tuple[Line, ...]], Line]) -> Line:
        """Let `choose` make a line from all lines so far, and add it, while nobody else can write.

        Returns:
            The line as it was written.
        """
        with self._locked() as lines:
            return self._append_line(choose(lines))

    def claim(self, kind: str, name: str) -> bool:
        """Return whether `name` is claimed now, and was not claimed before on any computer.

        The file's name is a hash, so that it does not say who has withdrawn.
        """
        claims = self.folder / "claims"
        claims.mkdir(mode=0o700, exist_ok=True)
        hashed = hashlib.sha256(f"{self.study}/{self.seed}/{kind}/{name}".encode()).hexdigest()[:24]
        try:
            os.close(os.open(claims / f"{kind}-{hashed}", os.O_CREAT | os.O_EXCL | os.O_WRONLY, 0o600))
        except FileExistsError:
            return False
        return True

    def replace_code(self, code: str, by: str, *, last: Withdrawn) -> None:
        """Write the ledger anew with `by` in place of a participant's code, and add `last`.

        The new file takes the old one's name in one step, so that a kill leaves the old or the new one.
        """
        with self._locked() as lines:
            chain = Chain()
            renamed = [
                msgspec.structs.replace(line, code=by) if getattr(line, "code", None) == code else line
                for line in (*lines, _dated(last))
            ]
            new = self.path.with_suffix(".new")
            with os.fdopen(os.open(new, os.O_CREAT | os.O_TRUNC | os.O_WRONLY, 0o600), "wb") as file:
                for line in renamed:
                    file.write(chain.seal(msgspec.json.encode(line)))
                file.flush()
                os.fsync(file.fileno())
            os.replace(new, self.path)

    @contextmanager
    def _locked(self) -> Iterator[tuple[Line, ...]]:
        # A lock of its own: the ledger may be replaced by another file while a program waits.
        with exclusive(self.folder / "ledger.lock"):
            self._handle = os.open(self.path, os.O_CREAT | os.O_RDWR, 0o600)
            try:
                content = self._read_all()
                lines, self._chain, size = _checked(self.path, content)
                if size < len(content):
                    os.ftruncate(self._handle, size)
                os.lseek(self._handle, 0, os.SEEK_END)
                yield lines
            finally:
                os.close(self._handle)

    def _read_all(self) -> bytes:
        with os.fdopen(os.dup(self._handle), "rb") as file:
            file.seek(0)
            return file.read()

    def _append_line(self, entry: Line) -> Line:
        entry = _dated(entry)
        append_sealed(self._handle, self._chain, entry)
        return entry


def check_not_lost(folder: Path) -> None:
    """Check that a study's ledger is there if there are participants.

    A new ledger would give their places to others, and nobody could go on.

    Args:
        folder: of the study's data.

    Raises:
        LedgerError: there are participants' files, and the ledger is missing or empty.
    """
    path = folder / "ledger.jsonl"
    if path.exists() and path.stat().st_size:
        return
    participants = folder / PARTICIPANTS
    held = sum(one.is_dir() for one in participants.iterdir()) if participants.is_dir() else 0
    if held:
        raise LedgerError(
            f"{path} is {'empty' if path.exists() else 'missing'}, and {participants} holds the files of "
            f"{held} {'participant' if held == 1 else 'participants'}: without it nobody knows who has which "
            "place. Take the newest copy from a backup. To begin anew, move the whole folder "
            f"{folder} elsewhere first"
        )


@contextmanager
def exclusive(path: Path) -> Iterator[None]:
    """Hold a lock while the block runs; wait while another process holds it.

    Args:
        path: of the lock's file, which stays empty.

    Raises:
        LedgerError: the file system has no locks.
    """
    with os.fdopen(os.open(path, os.O_CREAT | os.O_RDWR, 0o600), "wb") as lock:
        if sys.platform != "win32":
            try:
                fcntl.flock(lock, fcntl.LOCK_EX)
            except OSError as error:
                raise LedgerError(
                    f"{path}: this folder does not take locks ({error.strerror}), so two computers could "
                    "write at the same time. Use a local disk, or a share with locks "
                    "(docs/how-to/several-computers.md)"
                ) from error
        yield


def _dated(entry: Line) -> Line:
    return entry if entry.at_utc else msgspec.structs.replace(entry, at_utc=wall_time_utc())
