"""The file of a reaction-time session: a header line, then one line per finished trial, each flushed to the
disk.

JSON lines, opened for creation only; a session that stopped goes on by appending. Nothing is ever rewritten.
"""

import os
from datetime import datetime, timedelta
from pathlib import Path
from types import TracebackType
from typing import BinaryIO, Literal, Self

import msgspec

from core.numerics.clock import wall_time_utc
from core.system.bounded_read import read_bounded
from core.system.private_files import create_private, write_all
from studies.reaction_time.protocol import Schedule, TrialRecord

FORMAT: Literal["arl-reaction-times"] = "arl-reaction-times"
VERSION = 1
LONGEST_PAUSE_H = 12.0
"""An older half session is not taken up again without asking: another day is another measurement."""


class TrialFileError(ValueError):
    """This file cannot be read or continued; the message says where and what to do."""


class TrialHeader(msgspec.Struct, frozen=True, kw_only=True):
    """First line: who, what, when, on which machine."""

    format: Literal["arl-reaction-times"] = FORMAT
    version: int = VERSION
    participant: str
    """Pseudonym; never a name."""
    created_utc: str
    """Wall time of the start, ISO 8601."""
    schedule: Schedule
    clock: str = "CLOCK_MONOTONIC"
    """Clock of all `_ns` fields."""
    facts: dict[str, str] = msgspec.field(default_factory=dict)
    """Versions, terminal, connection, result of the timing self-test."""


class TrialFile(msgspec.Struct, frozen=True, kw_only=True):
    """A session as read back."""

    header: TrialHeader
    trials: tuple[TrialRecord, ...]
    torn_line: bool = False
    """True where the last line was cut off in the middle of writing; it is not among `trials`."""

    @property
    def next_trial(self) -> int:
        """Index of the first trial that was not finished; the number of trials if all were."""
        done = {record.trial for record in self.trials if not record.comment.startswith("abandoned")}
        return next((plan.index for plan in self.header.schedule.trials if plan.index not in done), len(done))


class TrialWriter:
    """Appends records; each is on the disk when `write` returns. A context manager."""

    def __init__(self, path: Path, file: BinaryIO) -> None:
        self.path = path
        self._file = file

    @classmethod
    def create(cls, path: Path, header: TrialHeader) -> Self:
        """Start a new file; refuse to touch an existing one."""
        writer = cls(path, create_private(path))
        try:
            writer._append(msgspec.json.encode(header))
        except OSError:
            writer.close()
            path.unlink(missing_ok=True)
            raise
        return writer

    @classmethod
    def resume(
        cls, path: Path, *, now_utc: str | None = None, despite_age: bool = False
    ) -> tuple[Self, TrialFile]:
        """Go on with a session that stopped; return the writer and what was done so far.

        Raises:
            TrialFileError: where the session is complete, or older than `LONGEST_PAUSE_H` without
                `despite_age`.
        """
        session = read_trials(path)
        if session.next_trial >= len(session.header.schedule.trials):
            raise TrialFileError(f"{path}: all {session.next_trial} trials are done; start a new session")
        age_h = _age_h(session.header.created_utc, now_utc or wall_time_utc())
        if age_h > LONGEST_PAUSE_H and not despite_age:
            raise TrialFileError(
                f"{path}: this session began {age_h:.0f} hours ago (trial {session.next_trial} is next). "
                "Start a new one, or say explicitly that the old one goes on."
            )
        file = path.open("r+b", buffering=0)
        if session.torn_line:
            content = file.read()
            file.truncate(content.rfind(b"\n") + 1)
        file.seek(0, os.SEEK_END)
        return cls(path, file), session

    def write(self, record: TrialRecord) -> None:
        """Append one trial and force it to the disk."""
        self._append(msgspec.json.encode(record))

    def close(self) -> None:
        """Close the file."""
        self._file.close()

    def __enter__(self) -> Self:
        return self

    def __exit__(
        self, kind: type[BaseException] | None, value: BaseException | None, traceback: TracebackType | None
    ) -> None:
        self.close()

    def _append(self, line: bytes) -> None:
        end = self._file.tell()
        try:
            write_all(self._file, line + b"\n")
        except OSError:
            # A torn line would make the trials behind it unreadable. Cutting needs no room on the disk.
            self._file.truncate(end)
            self._file.seek(end)
            raise
        os.fsync(self._file.fileno())


def read_trials(path: Path) -> TrialFile:
    """Read a session; a last line cut off in writing is reported, any other fault is an error."""
    lines = read_bounded(path).split(b"\n")
    torn = lines.pop() != b""
    if not lines:
        raise TrialFileError(f"{path}: no complete header line; is this a reaction-time recording?")
    try:
        header = msgspec.json.decode(lines[0], type=TrialHeader)
    except msgspec.MsgspecError as error:
        raise TrialFileError(f"{path}:1: not a header of format {FORMAT!r}: {error}") from error
    if header.version != VERSION:
        raise TrialFileError(f"{path}: version {header.version} of the format, this program reads {VERSION}")
    records = []
    for number, line in enumerate(lines[1:], start=2):
        try:
            records.append(msgspec.json.decode(line, type=TrialRecord))
        except msgspec.MsgspecError as error:
            raise TrialFileError(f"{path}:{number}: not a trial: {error}") from error
    return TrialFile(header=header, trials=tuple(records), torn_line=torn)


def _age_h(then_utc: str, now_utc: str) -> float:
    age = datetime.fromisoformat(now_utc) - datetime.fromisoformat(then_utc)
    return age / timedelta(hours=1)
