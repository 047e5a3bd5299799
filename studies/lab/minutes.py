"""How long a participant has taken part, from the times in their own files.

Each attempt at a sitting has its own clock: that of the computer, or that of a simulated session.
"""

from collections.abc import Iterator
from pathlib import Path
from typing import NamedTuple

from core.numerics.clock import NS_PER_S
from core.recording.reader import RecordingError, read_recording
from studies.lab.blocks import SITTINGS
from studies.lab.sealed import SealedFileError
from studies.lab.sitting_log import (
    FileRecorded,
    QuestionAnswered,
    SittingClosed,
    SittingHeader,
    SittingLine,
    read_sitting,
)

WORDS_PER_MINUTE = 200.0
"""Reading speed on a screen."""
SECONDS_PER_QUESTION = 8.0


class _Attempt(NamedTuple):
    at_utc: str
    duration_ns: int
    closed: bool
    """It did not break off."""
    files: tuple[str, ...]
    """Recordings that were over when its last line was written."""


def minutes_of(folder: Path) -> float | None:
    """Return how long a participant has taken part, minutes, over all attempts at all sittings.

    A sitting that broke off within a session lasts to the last line of the session's recording.

    Args:
        folder: of the participant.

    Returns:
        None where no record of a sitting can be read.
    """
    attempts = sorted(_attempts(folder))
    if not attempts:
        return None
    total_ns = sum(attempt.duration_ns for attempt in attempts)
    named = {name for attempt in attempts for name in attempt.files}
    ends = [later.at_utc for later in attempts[1:]] + ["9999"]
    broken = [(one.at_utc, end) for one, end in zip(attempts, ends, strict=True) if not one.closed]
    if broken:
        for created_utc, duration_ns in _sessions(folder, named):
            total_ns += duration_ns * any(begun <= created_utc < end for begun, end in broken)
    return total_ns / NS_PER_S / 60


def _attempts(folder: Path) -> Iterator[_Attempt]:
    for path in folder.glob(f"{SITTINGS}*.jsonl"):
        try:
            header, lines = read_sitting(path)
        except (SealedFileError, OSError):
            continue  # `arl study status` names damaged files
        # Consent comes before the header is written.
        times = [header.started_ns, *(time for line in lines if (time := _time_ns(line)) is not None)]
        files = tuple(line.file for line in lines if isinstance(line, FileRecorded))
        closed = bool(lines) and isinstance(lines[-1], SittingClosed)
        yield _Attempt(header.at_utc, max(times) - min(times), closed, files)


def _time_ns(line: SittingLine) -> int | None:
    match line:
        case SittingHeader() | FileRecorded():
            return None
        case QuestionAnswered(answered_ns=time_ns):
            return time_ns
        case _:
            return line.time_ns


def _sessions(folder: Path, named: set[str]) -> Iterator[tuple[str, int]]:
    """Yield when each session began that no record of a sitting names, and how long it lasted."""
    for path in folder.glob("*.jsonl"):
        if path.name.startswith(SITTINGS) or path.name in named:
            continue
        try:
            recording = read_recording(path)
        except (RecordingError, OSError):
            continue
        times = [getattr(event, "time_ns", 0) for event in recording.events]
        yield (
            recording.header.created_utc,
            max([*times, recording.header.started_ns]) - recording.header.started_ns,
        )
