"""The record of one sitting: consent, pages, answers, breaks, and which recordings belong to it.

One sealed file per sitting, readable by its owner only. Each line is on the disk before the next page comes.
Times are nanoseconds of the machine's monotonic clock; `at_utc` is wall time.
"""

import os
from pathlib import Path
from types import TracebackType
from typing import Literal, Self

import msgspec

from core.numerics.clock import Clock, MonotonicClock, wall_time_utc
from core.recording.chain import Chain
from studies.lab.questions import Answer
from studies.lab.sealed import SealedFileError, append_sealed, open_sealed_lines

FORMAT: Literal["arl-study-sitting"] = "arl-study-sitting"
VERSION = 1
ADVICE = "Nobody but `arl study` may write this file. What stands before that line is as it was recorded"


class Record(msgspec.Struct, frozen=True, kw_only=True, tag_field="type", forbid_unknown_fields=True):
    """Base of all lines."""


class SittingHeader(Record, frozen=True, kw_only=True, tag="header"):
    """First line: whose sitting of which study this is."""

    format: Literal["arl-study-sitting"] = FORMAT
    version: int = VERSION
    study: str
    study_version: str
    study_sha256: str
    """Of the study file's bytes, hex."""
    participant: str
    """Pseudonym; never a name."""
    simulated: bool
    place: int
    order: tuple[str, ...]
    sitting: int
    attempt: int
    at_utc: str
    started_ns: int
    software: dict[str, str]


class StepBegun(Record, frozen=True, kw_only=True, tag="step-begun"):
    """A step of the timeline is on screen."""

    step: int
    kind: str
    time_ns: int


class ConsentAnswered(Record, frozen=True, kw_only=True, tag="consent-answered"):
    """The participant has answered every statement of the consent."""

    step: int
    text: str
    """The whole text as it was shown."""
    text_version: str
    text_sha256: str
    answers: dict[str, bool]
    """Statement to answer."""
    at_utc: str
    time_ns: int


class QuestionAnswered(Record, frozen=True, kw_only=True, tag="question-answered"):
    """An answer of a questionnaire, as it was confirmed."""

    step: int
    questionnaire: str
    question: str
    """Its id."""
    answer: Answer
    shown_ns: int
    answered_ns: int
    passed: bool | None = None
    """Of an attention check; None: the question is none."""


class FileRecorded(Record, frozen=True, kw_only=True, tag="file-recorded"):
    """A session, a practice or a calibration that belongs to this sitting."""

    step: int
    kind: Literal["block", "practice", "calibration"]
    file: str
    """Its name in the participant's folder."""
    condition: str
    """Empty where the step has none."""
    ended: str
    """How it ended, in the words of `arl recordings`."""


class StepEnded(Record, frozen=True, kw_only=True, tag="step-ended"):
    """A step of the timeline is over."""

    step: int
    time_ns: int
    how: Literal["finished", "stopped", "window-closed", "failed"]


class SittingClosed(Record, frozen=True, kw_only=True, tag="end"):
    """Last line of a sitting that did not break off."""

    how: Literal["finished", "stopped", "window-closed", "failed"]
    at_utc: str
    time_ns: int


SittingLine = (
    SittingHeader | StepBegun | ConsentAnswered | QuestionAnswered | FileRecorded | StepEnded | SittingClosed
)
_decoder: msgspec.json.Decoder[SittingLine] = msgspec.json.Decoder(SittingLine)


class SittingLog:
    """Appends lines to a new file; each is on the disk when `write` returns. A context manager."""

    def __init__(self, path: Path, header: SittingHeader, *, clock: Clock | None = None) -> None:
        """Create the file.

        Raises:
            FileExistsError: there is a file at `path` already; it is never touched.
            OSError: the disk does not take the header; no file is left.
        """
        path.parent.mkdir(mode=0o700, parents=True, exist_ok=True)
        self.path = path
        self.clock = clock or MonotonicClock()
        self._chain = Chain()
        self._handle = os.open(path, os.O_CREAT | os.O_EXCL | os.O_WRONLY, 0o600)
        try:
            self.write(header)
        except OSError:
            self.abandon()
            path.unlink(missing_ok=True)
            raise

    def write(self, line: SittingLine) -> None:
        """Add a line.

        Raises:
            OSError: the disk did not take it.
        """
        append_sealed(self._handle, self._chain, line)

    def close(self, how: Literal["finished", "stopped", "window-closed", "failed"]) -> None:
        """Add the last line and close the file."""
        self.write(SittingClosed(how=how, at_utc=wall_time_utc(), time_ns=self.clock.now_ns()))
        self.abandon()

    def abandon(self) -> None:
        """Close the file as it is."""
        if self._handle >= 0:
            os.close(self._handle)
            self._handle = -1

    def __enter__(self) -> Self:
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        self.abandon()


def read_sitting(path: Path) -> tuple[SittingHeader, tuple[SittingLine, ...]]:
    """Return a sitting's header and its other lines, checked.

    Raises:
        SealedFileError: the file is not a record of a sitting, or a line was changed.
        OSError: the file cannot be read.
    """
    lines, _, _ = open_sealed_lines(path, path.read_bytes(), _decoder, advice=ADVICE)
    if not lines or not isinstance(lines[0], SittingHeader):
        raise SealedFileError(f"{path}: not a record of a sitting: its first line is no header")
    return lines[0], lines[1:]
