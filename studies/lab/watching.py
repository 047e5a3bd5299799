"""How running sittings are doing, from their append-only files alone: nothing is locked, asked or written.

A file is read once; afterwards only what has been added to it. A participant in a session notices nothing.
"""

import statistics
from collections import deque
from collections.abc import Iterator
from dataclasses import dataclass, field
from pathlib import Path

import msgspec

from core.events import (
    EpisodeStarted,
    Event,
    FocusLost,
    FocusRegained,
    FrameShown,
    KeyPressed,
    PressRetracted,
    ScreenCleared,
    SessionEnded,
    StepTaken,
    TimeGap,
)
from core.numerics.clock import NS_PER_S
from core.recording.schema import End, Header, Line
from studies.lab.blocks import SITTINGS
from studies.lab.config import Study, kind_of
from studies.lab.folder import participant_folder
from studies.lab.progress import Participant, Progress

SILENT_S = 10.0
"""A session that has written nothing for so long is pointed out: a frame is written several times per
second."""
NO_PRESS_S = 120.0
"""So long without a press that counts is pointed out."""
SLOW_MS = 100.0
"""A step that reaches the terminal later than this after it was decided is pointed out."""
REMEMBERED = 20
"""Steps over which the lag is taken."""
_CHAIN = b',"chain":"'
_decoder = msgspec.json.Decoder(Line)


class Tail:
    """The lines of a recording, as they come."""

    def __init__(self, path: Path) -> None:
        self.path = path
        self._read = 0

    def new_lines(self) -> Iterator[Header | Event | End]:
        """Yield the whole lines that have been added since the last call; chains are not checked here."""
        with self.path.open("rb") as file:
            file.seek(self._read)
            whole, newline, _ = file.read().rpartition(b"\n")
        self._read += len(whole) + len(newline)
        for line in whole.split(b"\n") if newline else ():
            payload, mark, _ = line.rpartition(_CHAIN)
            try:
                yield _decoder.decode(payload + b"}" if mark else line)
            except msgspec.MsgspecError:
                continue  # `arl study status` names damaged files


@dataclass(slots=True)
class SessionWatch:
    """One session, as far as its file tells."""

    tail: Tail
    header: Header | None = None
    games: int = 0
    presses: deque[int] = field(default_factory=deque)
    """Times of presses that count, nanoseconds."""
    first_ns: int = 0
    last_ns: int = 0
    over: bool = False
    gaps: int = 0
    out_of_focus: bool = False
    covered: bool = False
    _lags_ns: deque[int] = field(default_factory=lambda: deque(maxlen=REMEMBERED))
    _decided: dict[int, int] = field(default_factory=dict)
    _numbers: dict[int, int] = field(default_factory=dict)

    def look(self) -> None:
        """Take in what has been added to the file."""
        for line in self.tail.new_lines():
            if isinstance(line, Header):
                self.header, self.first_ns, self.last_ns = line, line.started_ns, line.started_ns
            elif not isinstance(line, End):
                self._take(line)

    def _take(self, event: Event) -> None:
        self.last_ns = max(self.last_ns, getattr(event, "time_ns", 0), getattr(event, "flushed_ns", 0))
        match event:
            case EpisodeStarted():
                self.games += 1
            case StepTaken(step=step, time_ns=time_ns):
                self._decided = {step: time_ns}
            case FrameShown(step=step, flushed_ns=flushed_ns):
                self.covered = False
                if (decided_ns := self._decided.pop(step, None)) is not None:
                    self._lags_ns.append(flushed_ns - decided_ns)
            case KeyPressed(verdict="accepted", time_ns=time_ns, press=press):
                self.presses.append(time_ns)
                self._numbers[press] = time_ns
            case PressRetracted(press=press) if press in self._numbers:
                self.presses.remove(self._numbers.pop(press))
            case ScreenCleared():
                self.covered = True
            case TimeGap(joint=False):
                self.gaps += 1
            case FocusLost():
                self.out_of_focus = True
            case FocusRegained():
                self.out_of_focus = False
            case SessionEnded():
                self.over = True
            case _:
                pass

    @property
    def presses_per_minute(self) -> float:
        """Presses that count, per minute since the session began."""
        minutes = (self.last_ns - self.first_ns) / NS_PER_S / 60
        return len(self.presses) / minutes if minutes > 0 else 0.0

    @property
    def lag_ms(self) -> float | None:
        """Median time from the decision of a step to its first frame, milliseconds; None before the first."""
        return statistics.median(self._lags_ns) / 1e6 if self._lags_ns else None

    def warnings(self) -> Iterator[str]:
        """Yield what is worth a look."""
        since_ns = self.last_ns - (self.presses[-1] if self.presses else self.first_ns)
        if since_ns > NO_PRESS_S * NS_PER_S:
            yield f"no press for {since_ns / NS_PER_S:.0f} s"
        if self.lag_ms is not None and self.lag_ms > SLOW_MS:
            yield f"steps appear {self.lag_ms:.0f} ms late"
        if self.gaps:
            yield f"the machine stood still {self.gaps} times"
        if self.out_of_focus:
            yield "the window does not have the keyboard"
        if self.covered:
            yield "paused"


@dataclass(frozen=True, slots=True)
class RunningRow:
    """A sitting that has begun and not ended."""

    code: str
    where: str
    """Sitting and step, in words."""
    silent_s: float
    """Since the last sign of life in any of the participant's files."""
    session: SessionWatch | None
    """The newest session; None where no session is running."""

    @property
    def warnings(self) -> tuple[str, ...]:
        """What is worth a look."""
        found = list(self.session.warnings()) if self.session is not None else []
        if self.session is not None and self.silent_s > SILENT_S:
            found.append(f"no sign of life for {self.silent_s:.0f} s: was the window closed?")
        return tuple(found)


class Watch:
    """Follows the running sittings of a study."""

    def __init__(self, study: Study, data: Path) -> None:
        """Begin to follow.

        Args:
            study: from its file.
            data: folder of its data.
        """
        self._study = study
        self._data = data
        self._sessions: dict[Path, SessionWatch] = {}

    def rows(self, so_far: Progress, now_s: float) -> tuple[RunningRow, ...]:
        """Return the sittings that are running, or were killed.

        Args:
            so_far: from the ledger.
            now_s: wall time, seconds since 1970, as files' times are.
        """
        people = so_far.participants.values()
        return tuple(self._row(person, now_s) for person in people if _sitting_of(person) is not None)

    def _row(self, person: Participant, now_s: float) -> RunningRow:
        number = _sitting_of(person)
        assert number is not None, "asked before"
        sitting = self._study.sittings[number]
        place = person.sittings[number].next_step(len(sitting.steps))
        step = "all steps done"
        if place < len(sitting.steps):
            step = f"step {place + 1} of {len(sitting.steps)} ({kind_of(sitting.steps[place])})"
        files = sorted(participant_folder(self._data, person.code).glob("*.jsonl"), key=_changed_s)
        silent_s = now_s - max(map(_changed_s, files), default=now_s)
        return RunningRow(person.code, f"{sitting.name}: {step}", max(0.0, silent_s), self._session(files))

    def _session(self, files: list[Path]) -> SessionWatch | None:
        newest = next((path for path in reversed(files) if not path.name.startswith(SITTINGS)), None)
        if newest is None:
            return None
        session = self._sessions.setdefault(newest, SessionWatch(Tail(newest)))
        try:
            session.look()
        except OSError:
            return None  # removed meanwhile: the participant has withdrawn
        return None if session.over else session


def _sitting_of(person: Participant) -> int | None:
    """Return the sitting that has begun and has no end; None where there is none."""
    if person.withdrawn or person.dropped_out is not None:
        return None
    return next((number for number, sitting in person.sittings.items() if sitting.ended is None), None)


def _changed_s(path: Path) -> float:
    try:
        return path.stat().st_mtime
    except FileNotFoundError:
        return 0.0
