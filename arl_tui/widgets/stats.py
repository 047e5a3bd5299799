"""The figures beside the board."""

from asyncio import TimerHandle
from collections.abc import Callable
from dataclasses import dataclass
from typing import ClassVar

from rich.segment import Segment
from textual.geometry import Size
from textual.strip import Strip
from textual.widget import Widget

from arl_tui.app.once import after
from arl_tui.language import later, tr
from core.numerics.clock import Clock, MonotonicClock, seconds

REFRESH_S = 0.25
"""Figures are redrawn at most this often, seconds: they must not take time from the board."""
_BARS = "▁▂▃▄▅▆▇█"


@dataclass(frozen=True, slots=True, kw_only=True)
class Figures:
    """What is shown; None leaves a figure out."""

    lines: int = 0
    pieces: int = 0
    episode: int | None = None
    """Number of the watched episode, from 1."""
    episodes: int | None = None
    """How many there will be."""
    human_weights: tuple[float, ...] | None = None
    """Weight that the scheme used in each episode so far, oldest first; bars show [0, 1]."""


def trend(values: tuple[float, ...], width: int) -> str:
    """Return the last `width` values in [0, 1] as bars of one cell; what lies outside is cut off."""
    shown = values[-width:] if width > 0 else ()
    top = len(_BARS) - 1
    return "".join(_BARS[round(min(1.0, max(0.0, value)) * top)] for value in shown)


class StatsPanel(Widget, inherit_bindings=False, can_focus=False):
    """Lines, pieces, episode, and how much weight the participant's judgement has."""

    COMPONENT_CLASSES: ClassVar[set[str]] = {"stats--label", "stats--figure", "stats--trend"}
    DEFAULT_CSS: ClassVar[str] = """
    StatsPanel {
        width: 1fr;
        height: auto;
        border: round $foreground 40%;
        border-title-color: $foreground 75%;
        padding: 0 1;
    }
    StatsPanel > .stats--label { color: $foreground 65%; }
    StatsPanel > .stats--figure { color: $foreground; text-style: bold; }
    StatsPanel > .stats--trend { color: $accent; }
    """
    ALLOW_SELECT: ClassVar[bool] = False
    LABEL_WIDTH: ClassVar[int] = 11

    def __init__(
        self,
        title: str = later("Progress"),
        *,
        lines_high: int = 4,
        grows: Callable[[Size], int] = lambda window: 0,
        clock: Clock | None = None,
        id: str | None = None,
        classes: str | None = None,
    ) -> None:
        """Show zeros.

        Args:
            title: in the border, in English (`arl_tui.language.later`).
            lines_high: lines inside the border: 4 hold all figures, 2 only lines and pieces.
            grows: returns how many lines more it has in a window, to end where its neighbour ends.
            clock: says when the next redrawing is due; the machine's by default.
            id: Textual's name of the widget.
            classes: Textual's style classes.
        """
        super().__init__(id=id, classes=classes)
        self.border_title = tr(title)
        self.figures = Figures()
        """What is on screen, or will be with the next paint."""
        self._lines_high = lines_high
        self._grows = grows
        self._clock = clock or MonotonicClock()
        self._drawn_ns: int | None = None
        self._waiting: Figures | None = None
        self._timer: TimerHandle | None = None

    def get_content_height(self, container: Size, viewport: Size, width: int) -> int:
        """Return the height, which only the window's size changes."""
        return self._lines_high + self._grows(viewport)

    def show(self, figures: Figures) -> None:
        """Draw these figures: at once, or when the last drawing is old enough. The newest win."""
        if figures == (self._waiting or self.figures):
            return
        self._waiting = figures
        if self._timer is not None:
            return
        if (wait_s := self._wait_s()) > 0:
            self._timer = after(self, wait_s, self._draw)
        else:
            self._draw()

    def _wait_s(self) -> float:
        if self._drawn_ns is None:
            return 0.0
        return REFRESH_S - seconds(self._clock.now_ns() - self._drawn_ns)

    def _draw(self) -> None:
        self._timer = None
        if self._waiting is not None:
            self.figures, self._waiting = self._waiting, None
        self._drawn_ns = self._clock.now_ns()
        self.refresh()

    def render_line(self, y: int) -> Strip:
        """Return one line: a label and its figure."""
        rows = self._rows()
        label, figure, bars = rows[y] if y < len(rows) else ("", "", "")
        segments = [
            Segment(f"{label:<{self.LABEL_WIDTH}}", self.get_component_rich_style("stats--label")),
            Segment(figure, self.get_component_rich_style("stats--figure")),
            Segment(f"  {bars}", self.get_component_rich_style("stats--trend")),
        ]
        return Strip(segments).adjust_cell_length(self.size.width, self.rich_style)

    def _rows(self) -> list[tuple[str, str, str]]:
        figures = self.figures
        rows = []
        if figures.episode is not None:
            done = f"{figures.episode:>4}"
            of = done if figures.episodes is None else tr("{done} of {all}", done=done, all=figures.episodes)
            rows.append((tr("Game"), of, ""))
        rows += [(tr("Lines"), f"{figures.lines:>4}", ""), (tr("Pieces"), f"{figures.pieces:>4}", "")]
        if figures.human_weights:
            width = self.size.width - self.LABEL_WIDTH - 6
            rows.append(
                (tr("Influence"), f"{figures.human_weights[-1]:>4.2f}", trend(figures.human_weights, width))
            )
        return rows
