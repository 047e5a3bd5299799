"""The index of a recording: where each game, step, frame and press stands in its file.

It is kept beside the recording (`FILE.jsonl.index`) and made again when the recording's file has changed.
Building it reads the whole file once and checks its chain. Memory does not grow with the recording.
"""

import hashlib
import tempfile
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path
from typing import Any, Final, get_args

import msgspec
import numpy as np

from core.events import (
    CoverReason,
    CreditGiven,
    EpisodeEnded,
    EpisodeStarted,
    FocusLost,
    FocusRegained,
    FrameShown,
    KeyPressed,
    PressRetracted,
    Resumed,
    ScreenCleared,
    SessionEnded,
    StepTaken,
    StopAsked,
    TimeGap,
    UnseenPlayed,
    Verdict,
    WrongPressAsked,
)
from core.recording.reader import CHAIN_MARK, RecordingError, line_of_file, read_recording
from core.recording.recorder import CHAIN_DIGITS, Chain, LineWriter
from core.recording.schema import VERSION, End, Header, Line
from core.recording.version_1 import with_schedules
from studies.session_view.tables import DTYPES, Contents, Growing, Rows, read_tables, write_tables

INDEX_VERSION: Final = 2
SUFFIX: Final = ".index"
VERDICTS: Final[tuple[str, ...]] = get_args(Verdict)
"""Verdicts of presses by their number in the index."""
COVERED, RESUMED, GAP, FOCUS_LOST, FOCUS_REGAINED, STOP, WRONG_ASKED = range(7)
"""Kinds of marks."""
REASONS: Final[tuple[str, ...]] = get_args(CoverReason)
"""Why a game was covered, by number."""
ENDS: Final = ("termination", "truncation")
_SEAL = len(CHAIN_MARK) + CHAIN_DIGITS + 2
_TELL_EVERY = 1 << 22
"""Bytes between two calls of `on_progress`."""
_decoder = msgspec.json.Decoder(Line)

OnProgress = Callable[[float], None]
"""Is told which fraction of the file has been read, in [0, 1]."""


@dataclass(frozen=True, slots=True, eq=False)
class Index:
    """An opened index; tables as `studies.session_view.tables.DTYPES` describes them."""

    path: Path
    """Of the file that offsets point into: the recording, or a copy that was put right."""
    header: Header
    version: int
    """Of the format of that file."""
    tables: dict[str, Rows]
    start_ns: int
    end_ns: int
    events: int
    complete: bool
    """The recording has its end line."""
    reason: str
    """Why the session ended, as its last event says; "" where there is none."""
    notes: tuple[str, ...] = ()
    """What is unusual about the file."""

    def line(self, offset: int) -> Line:
        """Return what stands at a byte of the file."""
        with self.path.open("rb") as file:
            file.seek(offset)
            return line_of_file(file.readline().rstrip(b"\n"), self.version)

    def lines(self, offset: int, last: int) -> "list[Line]":
        """Return all lines that begin from one byte of the file to another, both included."""
        found: list[Line] = []
        with self.path.open("rb") as file:
            file.seek(offset)
            while file.tell() <= last and (line := file.readline()):
                found.append(line_of_file(line.rstrip(b"\n"), self.version))
        return found


def open_index(path: Path, *, on_progress: OnProgress = lambda fraction: None) -> Index:
    """Open the index of a recording; build it where there is none, or where it is of another state of the
    file.

    Raises:
        RecordingError: the recording is damaged.
        OSError: it cannot be read.
    """
    if path.is_dir():
        read_recording(path)  # says what to do
    fingerprint = fingerprint_of(path)
    for place in _places(path):
        found = _opened(path, place, fingerprint)
        if found is not None:
            return found
    try:
        return _build(path, path, fingerprint, (), on_progress)
    except _UnusualFileError:
        # Compressed, or changed by an editor: the reader puts it right or says what is wrong.
        recording = read_recording(path)
        copy = _copy_place(path)
        copy.unlink(missing_ok=True)
        with_version = msgspec.structs.replace(recording.header, version=VERSION)
        writer = LineWriter(copy, with_version)
        for event in recording.events:
            writer.append(event)
        if recording.complete:
            writer.finish()
        writer.abandon()
        return _build(path, copy, fingerprint, recording.notes, on_progress)


def fingerprint_of(path: Path) -> str:
    """Return what tells one state of a file from another: size, time of its last change, first and last 4096
    bytes.
    """
    status = path.stat()
    with path.open("rb") as file:
        digest = hashlib.sha256(file.read(4096))
        file.seek(max(0, status.st_size - 4096))
        digest.update(file.read())
    return f"{status.st_size}-{status.st_mtime_ns}-{digest.hexdigest()[:32]}"


class _UnusualFileError(Exception):
    """The file is not as a recorder leaves it."""


def _places(path: Path) -> tuple[Path, Path]:
    """Return where an index may be: beside the recording, else in the folder for temporary files."""
    name = hashlib.sha256(str(path.resolve()).encode()).hexdigest()[:24]
    return path.with_name(path.name + SUFFIX), Path(tempfile.gettempdir()) / f"arl-{name}{SUFFIX}"


def _copy_place(path: Path) -> Path:
    return _places(path)[1].with_suffix(".jsonl")


def _opened(path: Path, place: Path, fingerprint: str) -> Index | None:
    """Return the index at a place; None where there is none that can be used."""
    try:
        contents, tables = read_tables(place)
    except (OSError, ValueError, msgspec.MsgspecError):
        return None
    file = Path(contents.facts.get("file", "")) if contents.facts.get("file") else path
    if contents.index != INDEX_VERSION or contents.of != fingerprint or not file.exists():
        return None
    facts = contents.facts
    with file.open("rb") as opened:
        header = line_of_file(opened.readline().rstrip(b"\n"), VERSION)
    assert isinstance(header, Header), "the first line was looked at when the index was built"
    version = header.version
    if version == 1:
        header = msgspec.structs.replace(header, protocol=with_schedules(header.protocol))
    return Index(
        file, header, version, tables, facts["start"], facts["end"], facts["events"], facts["complete"],
        facts["reason"], tuple(facts["notes"]),
    )  # fmt: skip


def _build(
    path: Path, file: Path, fingerprint: str, notes: tuple[str, ...], on_progress: OnProgress
) -> Index:
    building = _Building()
    try:
        _read(file, building, on_progress)
        facts = building.facts(file if file != path else None, notes)
        contents = Contents(INDEX_VERSION, fingerprint, facts, {})
        for place in _places(path):
            try:
                write_tables(place, building.tables, contents)
            except OSError:
                continue
            found = _opened(path, place, fingerprint)
            if found is not None:
                return found
    finally:
        for table in building.tables.values():
            table.close()
    raise RecordingError(
        f"{path}: its index can be written neither beside it nor in {tempfile.gettempdir()}: make room on "
        f"the disk"
    )


def _read(file: Path, building: "_Building", on_progress: OnProgress) -> None:
    chain, size, told = Chain(), max(1, file.stat().st_size), 0
    offset = 0
    version = VERSION
    with file.open("rb", buffering=1 << 20) as lines:
        for line in lines:
            if not line.endswith(b'"}\n') or line[-1 - _SEAL : -1 - _SEAL + len(CHAIN_MARK)] != CHAIN_MARK:
                if offset and not line.endswith(b"\n"):
                    building.cut_off = len(line)
                    break
                raise _UnusualFileError
            payload = line[: -1 - _SEAL] + b"}"
            if chain.advance(payload) != line[-3 - CHAIN_DIGITS : -3]:
                raise _UnusualFileError
            try:
                record = _decoder.decode(payload) if version == VERSION else line_of_file(line[:-1], version)
            except ValueError as error:
                raise _UnusualFileError from error
            if isinstance(record, Header):
                if offset:
                    raise _UnusualFileError
                version = record.version
            elif building.ended:
                raise _UnusualFileError
            else:
                building.take(record, offset)
            offset += len(line)
            if offset - told >= _TELL_EVERY:
                told = offset
                on_progress(offset / size)
    if not offset or (building.ended and building.said_events != building.events):
        raise _UnusualFileError
    on_progress(1.0)


class _Building:
    """Takes the lines of a recording in, one by one."""

    def __init__(self) -> None:
        self.tables = {name: Growing(name) for name in DTYPES}
        self.events = 0
        self.ended = False
        self.said_events = 0
        self.cut_off = 0
        self._start = self._end = -1
        self._reason = ""
        self._covered_since = -1
        self._covered = 0
        self._shown_again = False
        self._step = -2
        self._nth = 0
        self._last_frame = -1
        # Steps that have not been shown yet: (offset, row of the episode, step).
        self._unshown: list[tuple[int, int, StepTaken]] = []
        self._n_steps = 0

    def facts(self, file: Path | None, notes: tuple[str, ...]) -> dict[str, Any]:
        """Return what the first line of the index says of the recording as a whole; nothing is taken in
        afterwards.
        """
        while self._unshown:
            self._add_step(-1, -1)
        if self.cut_off:
            notes = (*notes, f"the file ends within a line, {self.cut_off:,} bytes behind the last whole one")
        return {
            "start": max(self._start, 0),
            "end": max(self._end, self._start, 0),
            "events": self.events,
            "complete": self.ended,
            "reason": self._reason,
            "notes": list(notes),
            "file": "" if file is None else str(file),
        }

    def take(self, record: Line, offset: int) -> None:
        """Take in one line that begins at a byte of the file."""
        match record:
            case FrameShown():
                self._frame(record)
            case StepTaken():
                self._seen(record.time_ns)
                self._unshown.append((offset, self.tables["episodes"].n - 1, record))
                self._n_steps += 1
            case KeyPressed():
                self._press(record, offset)
            case CreditGiven():
                merged = -1 if record.merged_into is None else record.merged_into
                self.tables["credits"].add(offset, record.press, merged)
            case EpisodeStarted():
                self._begin(record, offset)
            case EpisodeEnded():
                self._finish(record)
            case End():
                self.ended, self.said_events = True, record.events
                return
            case _:
                self._other(record)
        self.events += 1

    def _seen(self, time_ns: int) -> None:
        if self._start < 0 or time_ns < self._start:
            self._start = time_ns
        self._end = max(self._end, time_ns)

    def _frame(self, record: FrameShown) -> None:
        self._seen(record.flushed_ns)
        time_ns = self._last_frame = max(record.flushed_ns, self._last_frame)
        if self._covered_since >= 0:
            self._uncover(time_ns)
        table = self.tables["frames"]
        if record.step != self._step:
            self._step, self._nth = record.step, 0
        else:
            self._nth += not self._shown_again
        first = False
        while self._unshown and self._unshown[0][2].step <= record.step:
            first = self._unshown[0][2].step == record.step
            self._add_step(time_ns if first else -1, table.n if first else -1)
        nth = -1 if self._shown_again and not first else self._nth
        table.add(time_ns, self._covered, record.step, nth, record.frame)
        self._shown_again = False

    def _add_step(self, shown_ns: int, frame: int) -> None:
        """Write the oldest of the steps that have not been shown yet."""
        offset, episode, step = self._unshown.pop(0)
        self.tables["steps"].add(
            offset, step.time_ns, shown_ns, self._covered, step.step, frame, episode, step.action,
            step.environment_action, step.human_action,
        )  # fmt: skip

    def _uncover(self, time_ns: int) -> None:
        self._covered += max(0, time_ns - self._covered_since)
        self._covered_since = -1
        self._shown_again = True

    def _press(self, record: KeyPressed, offset: int) -> None:
        self._seen(record.time_ns)
        self.tables["presses"].add(
            offset, record.time_ns, np.nan if record.value is None else record.value, record.press, record.frame,  # noqa: E501
            record.step, record.person, VERDICTS.index(record.verdict), record.source == "simulated",
            record.asked_wrong, record.key.encode()[:14],
        )  # fmt: skip

    def _begin(self, record: EpisodeStarted, offset: int) -> None:
        self._seen(record.time_ns)
        trust = np.nan if record.trust is None else record.trust
        self._step = -2
        self.tables["episodes"].add(
            offset, record.time_ns, -1, record.episode_seed, record.episode, self._n_steps, -1,
            record.policy, record.form, -1, record.w_r, trust, record.weight, record.handover, np.nan, np.nan, -1, -1,  # noqa: E501
        )  # fmt: skip

    def _finish(self, record: EpisodeEnded) -> None:
        self._seen(record.time_ns)
        table = self.tables["episodes"]
        for column, value in (
            ("end", record.time_ns),
            ("n_steps", record.steps),
            ("ended", ENDS.index(record.ended)),
            ("performance", record.performance),
            ("trust_after", record.trust),
            ("agreed", record.agreed),
            ("agreed_worst", record.agreed_worst),
        ):
            table.change(table.n - 1, column, value)

    def _other(self, record: Line) -> None:
        marks = self.tables["marks"]
        match record:
            case PressRetracted():
                self.tables["retractions"].add(record.time_ns, record.press, record.reason == "auto-repeat")
            case ScreenCleared(time_ns=time_ns, reason=reason):
                self._covered_since = time_ns if self._covered_since < 0 else self._covered_since
                marks.add(time_ns, -1, COVERED, REASONS.index(reason))
            case Resumed(time_ns=time_ns):
                if self._covered_since >= 0:
                    self._uncover(time_ns)
                marks.add(time_ns, -1, RESUMED, 0)
            case TimeGap(time_ns=time_ns, last_ns=last_ns):
                marks.add(time_ns, last_ns, GAP, 0)
            case FocusLost(time_ns=time_ns):
                marks.add(time_ns, -1, FOCUS_LOST, 0)
            case FocusRegained(time_ns=time_ns):
                marks.add(time_ns, -1, FOCUS_REGAINED, 0)
            case StopAsked(time_ns=time_ns, reason=reason):
                self._reason = reason
                marks.add(time_ns, -1, STOP, 0)
            case WrongPressAsked(time_ns=time_ns):
                marks.add(time_ns, -1, WRONG_ASKED, 0)
            case UnseenPlayed(time_ns=time_ns, performances=performances):
                mean = float(np.mean(performances)) if performances else np.nan
                self.tables["unseen"].add(
                    time_ns, mean, record.trust, record.first_episode, len(performances)
                )
            case SessionEnded(time_ns=time_ns, reason=reason):
                self._reason = self._reason or reason
            case _:
                return
        self._seen(record.time_ns)
