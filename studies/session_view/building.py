"""What an index holds of each event of a recording: taken in line by line, in the order of the file."""

from collections import deque
from pathlib import Path
from typing import Any, Final, get_args

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
    QuestionAnswered,
    QuestionPosed,
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
from core.recording.reader import cut_note
from core.recording.schema import End, Line
from studies.session_view.tables import DTYPES, Growing

VERDICTS: Final[tuple[str, ...]] = get_args(Verdict)
"""Verdicts of presses by their number in the index."""
COVERED, RESUMED, GAP, FOCUS_LOST, FOCUS_REGAINED, STOP, WRONG_ASKED = range(7)
"""Kinds of marks."""
REASONS: Final[tuple[str, ...]] = get_args(CoverReason)
"""Why a game was covered, by number."""
ENDS: Final = ("termination", "truncation")


class Building:
    """Takes the lines of a recording in, one by one."""

    def __init__(self) -> None:
        self.tables = {name: Growing(name) for name in DTYPES}
        self.events = 0
        self.ended = False
        self.said_events = 0
        self.cut_off = b""
        """What stands behind the last whole line."""
        self._start = self._end = -1
        self._reason = ""
        self._covered_since = -1
        self._covered = 0
        self._shown_again = False
        self._step = -2
        self._nth = 0
        self._last_frame = -1
        # Steps that have not been shown yet: (offset, row of the episode, step).
        self._unshown: deque[tuple[int, int, StepTaken]] = deque()
        self._n_steps = 0
        self._question_rows: dict[int, int] = {}
        """Rows of the questions that are still open, by number."""

    def facts(self, file: Path | None, notes: tuple[str, ...]) -> dict[str, Any]:
        """Return what the first line of the index says of the recording as a whole; nothing is taken in
        afterwards.
        """
        while self._unshown:
            self._add_step(-1, -1)
        if self.cut_off.strip():
            notes = (*notes, cut_note(self.cut_off))
        return {
            "start": max(self._start, 0),
            "end": max(self._end, self._start, 0),
            "events": self.events,
            "complete": self.ended,
            "reason": self._reason,
            "notes": list(notes),
            "file": "" if file is None else str(file),
        }

    def close(self) -> None:
        """Give the temporary files up."""
        for table in self.tables.values():
            table.close()

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
            case QuestionPosed() | QuestionAnswered():
                self._question(record, offset)
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
        offset, episode, step = self._unshown.popleft()
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

    def _question(self, record: QuestionPosed | QuestionAnswered, offset: int) -> None:
        table = self.tables["questions"]
        self._seen(record.time_ns)
        if isinstance(record, QuestionPosed):
            self._question_rows[record.question] = table.n
            table.add(offset, record.time_ns, -1, -1, record.question)
        elif record.question in self._question_rows:
            row = self._question_rows.pop(record.question)
            table.change(row, "answer", offset)
            table.change(row, "end", record.time_ns)

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
