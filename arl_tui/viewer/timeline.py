"""The timeline of a session: games, presses, pauses, performance, trust, weight, and where the viewer is."""

import math
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from rich.style import Style
from textual import events
from textual.message import Message

from arl_tui.viewer.rows import (
    BAD,
    BOLD,
    DIFFERS,
    DIM,
    GOOD,
    OTHER,
    SCORE,
    SHADES,
    TAG,
    TRUST,
    WEIGHT,
    Rows,
    Run,
    cells_to_runs,
    level,
)
from core.numerics.clock import NS_PER_S
from studies.session_view.session import SessionView
from studies.session_view.tags import Tag

LABEL = 8
"""Columns of the names on the left."""
ZOOM = 2.0
CLOSEST_NS = NS_PER_S
"""The shortest stretch that is shown."""
Cell = tuple[str, Style | None]
Times = NDArray[np.int64]


@dataclass(frozen=True, slots=True)
class Stretch:
    """The part of a session that is on the timeline."""

    begin_ns: int
    end_ns: int

    @property
    def length_ns(self) -> int:
        """Nanoseconds, >= 1."""
        return max(1, self.end_ns - self.begin_ns)

    def column(self, time_ns: int, width: int) -> int:
        """Return the column of a time among `width`."""
        return min(max(int((time_ns - self.begin_ns) / self.length_ns * width), 0), width - 1)

    def time(self, column: float, width: int) -> int:
        """Return the time in the middle of a column."""
        return self.begin_ns + round((column + 0.5) / width * self.length_ns)

    def edges(self, width: int) -> Times:
        """Return where columns begin and the last one ends, shape (width + 1,)."""
        return (self.begin_ns + np.arange(width + 1) / width * self.length_ns).astype(np.int64)


def clock_text(time_ns: int) -> str:
    """Return minutes and seconds, with hours from an hour on."""
    seconds = max(0, time_ns) / NS_PER_S
    hours, rest = divmod(seconds, 3600)
    minutes, second = divmod(rest, 60)
    return f"{int(hours)}:{int(minutes):02}:{second:04.1f}" if hours else f"{int(minutes)}:{second:04.1f}"


class Facts:
    """What the timeline draws of a session, as arrays of times."""

    def __init__(self, session: SessionView) -> None:
        presses, taken_back = session.presses, np.array(sorted(session.taken_back), dtype=np.int64)
        value, times = presses["value"], presses["time"]
        counted = (presses["verdict"] == 0) & ~np.isin(presses["number"], taken_back)
        self.good: Times = np.sort(times[counted & (value > 0)])
        self.bad: Times = np.sort(times[counted & (value < 0)])
        self.neither: Times = np.sort(times[counted & (value == 0)])
        self.people = [
            (name, tuple(np.sort(times[mine & said]) for said in (value > 0, value < 0, value == 0)))
            for person, name in enumerate(session.people)
            for mine in [counted & (presses["person"] == person)]
        ]
        """Code of each of several participants, and when they pressed good, bad and neither."""
        self.taken_back: Times = np.sort(times[(presses["verdict"] == 0) & ~counted])
        self.refused: Times = np.sort(times[(presses["verdict"] != 0) & ~np.isnan(value)])
        self.starts: Times = session.times("game")
        ends = session.games["end"]
        following = np.append(self.starts[1:], session.end_ns)
        self.ends: Times = np.where(ends < 0, following, ends)
        self.performance = np.ascontiguousarray(session.games["performance"], dtype=np.float64)
        self.weight = np.ascontiguousarray(session.games["weight"], dtype=np.float64)
        trust = np.asarray(session.games["trust"], dtype=np.float64)
        after = np.asarray(session.games["trust_after"], dtype=np.float64)
        # Version 1 did not record what trust said when a game began: what it said after the game before.
        self.trust = (
            np.where(np.isnan(trust), np.concatenate([[0.0], after[:-1]]), trust) if len(trust) else trust
        )
        self.stretches = [
            ("▒", DIM, session.pauses),
            ("f", OTHER, session.unfocused),
            ("#", BAD, session.gaps),
            ("?", OTHER, [stretch for stretch in session.pauses if stretch[2] == "question"]),
        ]


class Timeline(Rows):
    """Draws the session; a click or a drag with the mouse goes there."""

    DEFAULT_CSS = "Timeline { height: auto; }"

    class Sought(Message):
        """The mouse asks for a time."""

        def __init__(self, time_ns: int) -> None:
            super().__init__()
            self.time_ns = time_ns

    def __init__(
        self, session: SessionView, facts: Facts, unit: str, *, tall: bool = True, id: str | None = None
    ) -> None:
        """Prepare.

        Args:
            session: what is drawn.
            facts: of the session.
            unit: of performance, as a label.
            tall: draw everything, in ten lines; otherwise the most important, in seven.
            id: Textual's name of the widget.
        """
        super().__init__(id=id)
        self.tall = tall
        self._session = session
        self._facts = facts
        self._unit = unit
        self.stretch = self._whole = Stretch(session.start_ns, session.end_ns)
        """What is shown; see `zoom`."""
        self.differences: Times = np.zeros(0, dtype=np.int64)
        self.tags: list[Tag] = []
        self._drawn: tuple[object, ...] = ()
        self._base: list[list[Cell]] = []

    def renew(self, facts: Facts) -> None:
        """Draw other facts: more of the session is known. Where all of it was shown, all of it is."""
        whole = self.stretch == self._whole
        self._facts = facts
        self._whole = Stretch(self._session.start_ns, self._session.end_ns)
        if whole:
            self.stretch = self._whole
        self._drawn = ()

    def get_content_height(self, *_: object) -> int:
        """Return the number of lines: a tall one has a line for each of several participants."""
        return len(self._names())

    def zoom(self, factor: float, centre_ns: int) -> None:
        """Show a shorter stretch around a time, or with a factor below 1 a longer one."""
        whole = self._session.end_ns - self._session.start_ns
        length = min(max(self.stretch.length_ns / factor, CLOSEST_NS), max(whole, 1))
        begin = min(max(centre_ns - length / 2, self._session.start_ns), self._session.end_ns - length)
        self.stretch = Stretch(round(begin), round(begin + length))

    def follow(self, time_ns: int) -> None:
        """Move the stretch so that a time is on it."""
        if not self.stretch.begin_ns <= time_ns <= self.stretch.end_ns:
            self.zoom(1.0, time_ns)

    def draw(self, time_ns: int) -> None:
        """Draw, with the viewer at a time."""
        width = self.size.width - LABEL
        if width < 8:
            return
        self.follow(time_ns)
        key = (width, self.tall, self.stretch, len(self.differences), tuple(self.tags))
        if key != self._drawn:
            self._drawn, self._base = key, self._cells(width)
        cursor = self.stretch.column(time_ns, width)
        lines: list[list[Run]] = []
        for name, cells in zip(self._names(), self._base, strict=True):
            text, style = cells[cursor]
            mark = "│" if text == " " else text
            marked = [*cells[:cursor], (mark, (style or Style()) + Style(reverse=True)), *cells[cursor + 1 :]]
            lines.append([(f"{name:<{LABEL}}"[:LABEL], DIM), *cells_to_runs(marked)])
        self.show(lines)

    def _names(self) -> list[str]:
        if self.tall:
            said = [name for name, _ in self._facts.people] or ["good", "bad"]
            return ["games", *said, "other", "pauses", self._unit, "trust", "weight", "marks", ""]
        return ["games", "good", "bad", self._unit, "weight", "marks", ""]

    def _cells(self, width: int) -> list[list[Cell]]:
        facts, edges = self._facts, self.stretch.edges(width)
        good, bad = _marks(facts.good, edges, "▲", GOOD), _marks(facts.bad, edges, "▼", BAD)
        good = _over(_marks(facts.neither, edges, "◇", OTHER), good)
        other = _over(_marks(facts.refused, edges, "·", OTHER), _marks(facts.taken_back, edges, "x", OTHER))
        performance = self._bars(edges, facts.performance, SCORE)
        trust, weight = (
            self._bars(edges, facts.trust, TRUST, top=1.0),
            self._bars(edges, facts.weight, WEIGHT),
        )
        pauses = self._stretches(width)
        marks = _over(_marks(self.differences, edges, "◆", DIFFERS), self._tags(width))
        games, ruler = self._games(edges), self._ruler(width)
        if self.tall:
            said = [_of_person(when, edges) for _, when in facts.people] or [good, bad]
            return [games, *said, other, pauses, performance, trust, weight, marks, ruler]
        # Few lines: what became of refused presses stands with the bad ones, pauses with the marks.
        return [games, good, _over(other, bad), performance, weight, _over(pauses, marks), ruler]

    def _games(self, edges: Times) -> list[Cell]:
        starts, ends = self._facts.starts, self._facts.ends
        cells: list[Cell] = [(" ", None)] * (len(edges) - 1)
        rows = np.searchsorted(starts, edges[:-1], side="right") - 1
        for column in range(len(cells)):
            begun = int(np.searchsorted(starts, edges[column + 1], side="left")) - 1
            row = max(int(rows[column]), begun)
            if row >= 0 and ends[row] >= edges[column]:
                cells[column] = (" ", SHADES[row % 2])
        widths = (ends - starts) / max(1, edges[-1] - edges[0]) * len(cells)
        for row in np.flatnonzero((ends >= edges[0]) & (starts <= edges[-1]) & (widths >= 3)).tolist():
            column = max(0, int((starts[row] - edges[0]) / max(1, edges[-1] - edges[0]) * len(cells)))
            for place, letter in enumerate(str(row + 1), column):
                if place < len(cells):
                    cells[place] = (letter, SHADES[row % 2] + BOLD)
        return cells

    def _stretches(self, width: int) -> list[Cell]:
        cells: list[Cell] = [(" ", None)] * width
        for mark, style, stretches in self._facts.stretches:
            for begin, end, _ in stretches:
                if end < self.stretch.begin_ns or begin > self.stretch.end_ns:
                    continue
                for column in range(self.stretch.column(begin, width), self.stretch.column(end, width) + 1):
                    cells[column] = (mark, style)
        return cells

    def _bars(
        self, edges: Times, values: NDArray[np.float64], style: Style, top: float | None = None
    ) -> list[Cell]:
        """Return the mean of the games in each column as a bar; a point where it is 0."""
        starts, ends = self._facts.starts, self._facts.ends
        known = np.abs(values[~np.isnan(values)])
        height = max(top or 0.0, float(known.max()) if len(known) else 0.0) or 1.0
        cells: list[Cell] = []
        for column in range(len(edges) - 1):
            first = max(0, int(np.searchsorted(starts, edges[column], side="right")) - 1)
            last = max(first + 1, int(np.searchsorted(starts, edges[column + 1], side="left")))
            inside = values[first:last][ends[first:last] >= edges[column]]
            inside = inside[~np.isnan(inside)]
            if not len(inside) or (len(starts) and edges[column + 1] <= starts[0]):
                cells.append((" ", None))
                continue
            mean = float(inside.mean())
            # A weight below 0 is drawn upside down: in reverse.
            cells.append((level(abs(mean) / height) if mean else "·", style + Style(reverse=mean < 0)))
        return cells

    def _tags(self, width: int) -> list[Cell]:
        cells: list[Cell] = [(" ", None)] * width
        for tag in self.tags:
            if self.stretch.begin_ns <= tag.time_ns <= self.stretch.end_ns:
                cells[self.stretch.column(tag.time_ns, width)] = (tag.tag[0], TAG)
        return cells

    def _ruler(self, width: int) -> list[Cell]:
        text = [" "] * width
        step = _nice(self.stretch.length_ns / NS_PER_S / max(1, width // 12))
        start_s = (self.stretch.begin_ns - self._session.start_ns) / NS_PER_S
        tick = math.ceil(start_s / step)
        while (tick * step - start_s) * NS_PER_S <= self.stretch.length_ns:
            label = "╵" + clock_text(round(tick * step * NS_PER_S)).removesuffix(".0")
            column = self.stretch.column(self._session.start_ns + round(tick * step * NS_PER_S), width)
            if column + len(label) <= width and (column == 0 or text[column - 1] == " "):
                text[column : column + len(label)] = label
            tick += 1
        return [(letter, DIM) for letter in text]

    def on_mouse_down(self, event: events.MouseDown) -> None:
        """Go to where the mouse is."""
        self.capture_mouse()
        self._seek(event.x)

    def on_mouse_move(self, event: events.MouseMove) -> None:
        """Scrub while a button is held."""
        if event.button:
            self._seek(event.x)

    def on_mouse_up(self) -> None:
        """End the drag."""
        self.release_mouse()

    def on_mouse_scroll_up(self, event: events.MouseScrollUp) -> None:
        """Look closer."""
        self.zoom(ZOOM, self.stretch.time(event.x - LABEL, max(1, self.size.width - LABEL)))

    def on_mouse_scroll_down(self, event: events.MouseScrollDown) -> None:
        """Look from further away."""
        self.zoom(1 / ZOOM, self.stretch.time(event.x - LABEL, max(1, self.size.width - LABEL)))

    def _seek(self, x: int) -> None:
        width = max(1, self.size.width - LABEL)
        self.post_message(self.Sought(self.stretch.time(min(max(x - LABEL, 0), width - 1), width)))


def _marks(times: Times, edges: Times, mark: str, style: Style) -> list[Cell]:
    """Return a mark in each column in which something happened; bold digits where it happened several
    times.
    """
    counts = np.diff(np.searchsorted(times, edges, side="left"))
    if len(times) and len(counts) and times[-1] == edges[-1]:
        counts[-1] += int((times == edges[-1]).sum())
    return [
        (" ", None) if not n else (mark if n == 1 else str(n) if n < 10 else "+", style)
        for n in counts.tolist()
    ]


def _of_person(when: Sequence[Times], edges: Times) -> list[Cell]:
    """Return in one line when one of several participants pressed good, bad and neither."""
    good, bad, neither = when
    said = _over(_marks(neither, edges, "◇", OTHER), _marks(good, edges, "▲", GOOD))
    return _over(said, _marks(bad, edges, "▼", BAD))


def _over(below: list[Cell], above: list[Cell]) -> list[Cell]:
    return [low if high[0] == " " else high for low, high in zip(below, above, strict=True)]


def _nice(seconds: float) -> float:
    """Return a round number of seconds of at least this."""
    steps = (
        0.1,
        0.2,
        0.5,
        1,
        2,
        5,
        10,
        20,
        30,
        60,
        120,
        300,
        600,
        1200,
        1800,
        3600,
        7200,
        14400,
        36000,
        86400,
    )
    return next((step for step in steps if step >= seconds), float(math.ceil(seconds / 86400) * 86400))
