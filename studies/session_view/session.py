"""A recorded session as the viewer asks about it: what was on screen when, and what a press was worth."""

from dataclasses import dataclass
from functools import cached_property
from pathlib import Path
from typing import Literal

import numpy as np
from numpy.typing import NDArray

from core.events import CreditGiven, EpisodeStarted, StepTaken
from core.feedback.credit import STILL_SHOWN_NS
from core.session.protocol import Protocol
from core.session.protocol_reading import protocol_from
from studies.session_view.building import (
    COVERED,
    FOCUS_LOST,
    FOCUS_REGAINED,
    GAP,
    REASONS,
    RESUMED,
    VERDICTS,
)
from studies.session_view.index import Index, OnProgress, first_part, open_index
from studies.session_view.tables import Rows

Kind = Literal["frame", "step", "press", "game"]
"""What the viewer goes to."""
PressKind = Literal["good", "bad", "neither", "taken back", "refused", "no feedback"]
"""What became of a press. `refused`: it meant something and did not count; `no feedback`: another key."""


@dataclass(frozen=True, slots=True)
class Press:
    """One press, as it is shown."""

    row: int
    """Row in the table of presses."""
    number: int
    time_ns: int
    value: float
    """> 0 good, < 0 bad, 0 neither, NaN for another key."""
    key: str
    verdict: str
    kind: PressKind
    step: int
    """Step on screen at the press; -1 where there was none."""
    person: int
    simulated: bool
    asked_wrong: bool

    @property
    def words(self) -> str:
        """Say in a few words what it was and what became of it."""
        grade = f" ({self.value:+g})" if abs(self.value) > 1 else ""
        said = f"{self.kind}{grade}" if self.kind in ("good", "bad", "neither") else None
        if said is None:
            meant = "" if np.isnan(self.value) else f"{_kind_of(self.value)}, "
            said = meant + (self.kind if self.kind == "taken back" else f"refused: {self.verdict}")
        return f"{said} (asked to be wrong)" if self.asked_wrong else said


def _kind_of(value: float) -> Literal["good", "bad", "neither"]:
    return "good" if value > 0 else "bad" if value < 0 else "neither"


@dataclass(frozen=True, slots=True)
class Moment:
    """What was on screen at a time."""

    time_ns: int
    frame: int
    """Row of the newest frame; -1 before the first."""
    step: int
    """Row of the step on screen; -1 where there was none."""
    game: int
    """Row of the newest game that had begun; -1 before the first."""
    visible_ns: int
    """How long this step, or the picture without a step, had been on screen, without pauses."""
    covered: str
    """Why the game was covered; "" where it was not."""


_FOUND_LATER = ("_mark_times", "_shown_times", "_press_times")
"""Columns that are worked out when they are asked for."""


class SessionView:
    """An opened recording. It reads the file only where it is asked to, and keeps little of it."""

    def __init__(self, index: Index) -> None:
        """Look at the recording of an index."""
        self.look_at(index)

    def look_at(self, index: Index) -> None:
        """Look at the recording of an index: the whole one, say, after that of the first part.

        Rows of the first part are rows of the whole one, too.
        """
        for name in ("protocol", "taken_back", "pauses", "unfocused", "gaps", *_FOUND_LATER):
            self.__dict__.pop(name, None)
        self.index = index
        self.frames: Rows = index.tables["frames"]
        self.steps: Rows = index.tables["steps"]
        self.games: Rows = index.tables["episodes"]
        self.presses: Rows = index.tables["presses"]
        self.marks: Rows = index.tables["marks"]
        self.unseen: Rows = index.tables["unseen"]
        self.start_ns, self.end_ns = index.start_ns, index.end_ns
        # Columns that are searched lie in one piece; a search in a table of rows would copy the column every
        # time.
        self._frame_times = np.ascontiguousarray(self.frames["time"])
        self._step_numbers = np.ascontiguousarray(self.steps["number"])
        self._game_starts = np.ascontiguousarray(self.games["start"])
        self._all_press_times = np.ascontiguousarray(self.presses["time"])
        self._credited = np.ascontiguousarray(index.tables["credits"]["press"])

    @property
    def imported(self) -> bool:
        """Whether another program made the log."""
        return self.index.header.origin == "imported"

    @cached_property
    def protocol(self) -> Protocol | None:
        """What was played; None where the recording holds presses without states.

        Raises:
            ValueError: the header's protocol cannot be used.
        """
        found = self.index.header.protocol
        return protocol_from(found) if found else None

    @property
    def people(self) -> list[str]:
        """Codes of several participants at one keyboard, in order; [] where one participated."""
        names = self.index.header.participants
        return names if isinstance(names, list) else []

    # --- what was on screen ---------------------------------------------------------------------------------

    def at(self, time_ns: int) -> Moment:
        """Return what was on screen at a time."""
        frame = int(np.searchsorted(self._frame_times, time_ns, side="right")) - 1
        game = int(np.searchsorted(self._game_starts, time_ns, side="right")) - 1
        covered, covered_ns = self._cover(time_ns)
        if frame < 0:
            return Moment(time_ns, -1, -1, game, 0, covered)
        number = int(self.frames["step"][frame])
        step = self.step_row(number) if number >= 0 else -1
        first = int(self.steps["frame"][step]) if step >= 0 else self._first_of_none(frame)
        since, covered_before = int(self.frames["time"][first]), int(self.frames["covered"][first])
        covered_now = int(self.frames["covered"][frame]) + covered_ns
        return Moment(
            time_ns, frame, step, game, max(0, time_ns - since - (covered_now - covered_before)), covered
        )

    def _first_of_none(self, frame: int) -> int:
        """Return the first of the frames without a step that end with this one."""
        while frame > 0 and self.frames["step"][frame - 1] < 0 and self.frames["nth"][frame] != 0:
            frame -= 1
        return frame

    def _cover(self, time_ns: int) -> tuple[str, int]:
        """Return why the game was covered at a time, and since how long since the newest frame; "" and 0 if
        it was not.
        """
        row = int(np.searchsorted(self._mark_times, time_ns, side="right")) - 1
        while row >= 0 and self.marks["kind"][row] not in (COVERED, RESUMED):
            row -= 1
        if row < 0 or self.marks["kind"][row] == RESUMED:
            return "", 0
        since = int(self.marks["time"][row])
        frame = int(np.searchsorted(self._frame_times, time_ns, side="right")) - 1
        if frame >= 0 and self.frames["time"][frame] >= since:
            return "", 0
        return REASONS[int(self.marks["detail"][row])], time_ns - since

    @cached_property
    def _mark_times(self) -> NDArray[np.int64]:
        return np.maximum.accumulate(self.marks["time"]) if len(self.marks) else np.zeros(0, dtype=np.int64)

    def step_row(self, number: int) -> int:
        """Return the row of a step by its number; -1 where there is none."""
        numbers = self._step_numbers
        if number < len(numbers) and numbers[number] == number:
            return number
        row = int(np.searchsorted(numbers, number))
        return row if row < len(numbers) and numbers[row] == number else -1

    def step_taken(self, row: int) -> StepTaken:
        """Return a step, read from the file."""
        line = self.index.line(int(self.steps["offset"][row]))
        assert isinstance(line, StepTaken), "the index says so"
        return line

    def steps_taken(self, first: int, last: int) -> list[StepTaken]:
        """Return the steps of rows `first` to `last`, both included."""
        offsets = self.steps["offset"]
        return self.index.steps(int(offsets[first]), int(offsets[last]))

    def game_started(self, row: int) -> EpisodeStarted:
        """Return the beginning of a game, read from the file."""
        line = self.index.line(int(self.games["offset"][row]))
        assert isinstance(line, EpisodeStarted), "the index says so"
        return line

    def frames_of(self, step: int) -> int:
        """Return how many different frames of a step (a row) were shown, up to the next step's."""
        first = int(self.steps["frame"][step])
        if first < 0:
            return 0
        end = first
        number, numbers = self.steps["number"][step], self.frames["step"]
        while end < len(numbers) and numbers[end] == number:
            end += 1
        return int((self.frames["nth"][first:end] >= 0).sum())

    # --- presses --------------------------------------------------------------------------------------------

    def press_at(self, row: int) -> Press:
        """Return a press by its row."""
        entry = self.presses[row]
        value, verdict = float(entry["value"]), VERDICTS[int(entry["verdict"])]
        number = int(entry["number"])
        kind: PressKind
        if verdict != "accepted":
            kind = "no feedback" if np.isnan(value) else "refused"
        elif number in self.taken_back:
            kind = "taken back"
        else:
            kind = _kind_of(value)
        return Press(
            row, number, int(entry["time"]), value, entry["key"].decode(errors="replace"), verdict, kind,
            int(entry["step"]), int(entry["person"]), bool(entry["simulated"]), bool(entry["asked_wrong"]),
        )  # fmt: skip

    @cached_property
    def taken_back(self) -> frozenset[int]:
        """Numbers of the presses that were taken back."""
        return frozenset(self.index.tables["retractions"]["press"].tolist())

    def press_near(self, time_ns: int) -> int:
        """Return the row of the newest press at or before a time, other keys left out; -1 where there is
        none.
        """
        row = int(np.searchsorted(self._all_press_times, time_ns, side="right")) - 1
        while row >= 0 and np.isnan(self.presses["value"][row]):
            row -= 1
        return row

    def credit_of(self, press: int) -> CreditGiven | None:
        """Return how a press, by its number, was credited; None where it was not."""
        table = self.index.tables["credits"]
        row = int(np.searchsorted(self._credited, press))
        if row >= len(table) or self._credited[row] != press:
            rows = np.flatnonzero(self._credited == press)
            if not len(rows):
                return None
            row = int(rows[0])
        line = self.index.line(int(table["offset"][row]))
        assert isinstance(line, CreditGiven), "the index says so"
        return line

    def on_screen(
        self, from_ns: int, to_ns: int
    ) -> tuple[NDArray[np.int64], NDArray[np.int64], NDArray[np.int64]]:
        """Return when which steps were on screen in a stretch of time, as `core.feedback.credit.credit` takes
        it.

        Returns:
            Begin and end of each interval, and the number of its step, shape (n,) each. The first interval
            begins at or before `from_ns` where there is one.
        """
        first = max(0, int(np.searchsorted(self._frame_times, from_ns, side="right")) - 1)
        while first > 0 and self.frames["nth"][first] != 0:
            first -= 1
        last = int(np.searchsorted(self._frame_times, to_ns, side="right"))
        changes: list[tuple[int, int]] = [
            (int(time), int(step))
            for time, step in zip(
                self.frames["time"][first:last], self.frames["step"][first:last], strict=True
            )
        ]
        for row in range(*np.searchsorted(self._mark_times, [changes[0][0] if changes else 0, to_ns])):
            kind = self.marks["kind"][row]
            if kind == COVERED:
                changes.append((int(self.marks["time"][row]), -1))
            elif kind == GAP:
                changes.append((int(self.marks["since"][row]), -1))
        shown: list[int] = []
        hidden: list[int] = []
        steps: list[int] = []
        on_screen = -1
        for time_ns, step in sorted(changes, key=lambda change: change[0]):
            if step == on_screen:
                continue
            if on_screen >= 0:
                hidden.append(time_ns)
            if step >= 0:
                shown.append(time_ns)
                steps.append(step)
            on_screen = step
        if len(hidden) < len(shown):
            hidden.append(STILL_SHOWN_NS)
        return (
            np.array(shown, dtype=np.int64),
            np.array(hidden, dtype=np.int64),
            np.array(steps, dtype=np.int64),
        )

    def last_gap_before(self, time_ns: int) -> int:
        """Return when the program last stood still before a time; -1 where it never did."""
        rows = np.flatnonzero((self.marks["kind"] == GAP) & (self.marks["time"] <= time_ns))
        return int(self.marks["since"][rows[-1]]) if len(rows) else -1

    # --- stretches of the timeline --------------------------------------------------------------------------

    @cached_property
    def pauses(self) -> list[tuple[int, int, str]]:
        """Stretches in which the game was covered: from, to, why."""
        return self._stretches(COVERED, RESUMED)

    @cached_property
    def unfocused(self) -> list[tuple[int, int, str]]:
        """Stretches in which the window did not receive keys."""
        return self._stretches(FOCUS_LOST, FOCUS_REGAINED)

    @cached_property
    def gaps(self) -> list[tuple[int, int, str]]:
        """Stretches in which the program did not run."""
        rows = self.marks[self.marks["kind"] == GAP]
        return [(int(row["since"]), int(row["time"]), "gap") for row in rows]

    def _stretches(self, begin: int, end: int) -> list[tuple[int, int, str]]:
        found: list[tuple[int, int, str]] = []
        since, why = -1, ""
        for row in self.marks[(self.marks["kind"] == begin) | (self.marks["kind"] == end)]:
            if row["kind"] == begin and since < 0:
                since, why = int(row["time"]), REASONS[int(row["detail"])] if begin == COVERED else ""
            elif row["kind"] == end and since >= 0:
                found.append((since, int(row["time"]), why))
                since = -1
        if since >= 0:
            found.append((since, self.end_ns, why))
        return found

    # --- where to go ----------------------------------------------------------------------------------------

    def times(self, kind: Kind) -> NDArray[np.int64]:
        """Return the times of all frames, steps (when they came on screen), presses or games, ascending."""
        if kind == "frame":
            return self._frame_times
        if kind == "game":
            return self._game_starts
        return self._shown_times if kind == "step" else self._press_times

    @cached_property
    def _shown_times(self) -> NDArray[np.int64]:
        shown = self.steps["shown"]
        return np.asarray(shown[shown >= 0])

    @cached_property
    def _press_times(self) -> NDArray[np.int64]:
        return np.sort(self.presses["time"][~np.isnan(self.presses["value"])])

    def following(self, kind: Kind, time_ns: int, by: int = 1) -> int:
        """Return the time of the next frame, step, press or game; with `by` < 0 of the one before; else
        `time_ns`.
        """
        times = self.times(kind)
        if by > 0:
            row = int(np.searchsorted(times, time_ns, side="right")) + by - 1
        else:
            row = int(np.searchsorted(times, time_ns, side="left")) + by
        if not len(times) or (by > 0 and row >= len(times)) or (by < 0 and row < 0):
            return time_ns
        return int(times[row])


def open_session(path: Path, *, on_progress: OnProgress = lambda fraction: None) -> SessionView:
    """Open a recording, with its index.

    Raises:
        RecordingError: the recording is damaged.
        OSError: it cannot be read.
    """
    return SessionView(open_index(path, on_progress=on_progress))


def open_at_once(path: Path, *, on_progress: OnProgress = lambda fraction: None) -> SessionView:
    """Open a recording: of a long one without an index, the first part (`SessionView.index.whole` tells).

    Raises:
        RecordingError: the recording is damaged.
        OSError: it cannot be read.
    """
    part = first_part(path)
    return open_session(path, on_progress=on_progress) if part is None else SessionView(part)
