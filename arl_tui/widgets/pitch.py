"""The pitch of Keepaway, seen from above."""

import os
import sys
from asyncio import TimerHandle
from collections.abc import Mapping
from typing import ClassVar

from rich.segment import Segment
from rich.style import Style
from textual.cache import LRUCache
from textual.geometry import Region, Size
from textual.strip import Strip

from arl_tui.app.once import after
from arl_tui.palette import PALETTES, STANDARD, Palette
from arl_tui.widgets.board import MARK_S
from arl_tui.widgets.coverable import CoverableWidget
from arl_tui.widgets.pitch_colours import component_classes, style_sheet
from arl_tui.widgets.pitch_drawing import draw, fit
from arl_tui.widgets.pitch_ink import GRASS, INKS, WORDS, Detail, Mark, Row, Shape
from core.keepaway.picture import PitchFrame

TOO_SMALL = "Too small a window to draw the pitch"


def detail_for(environment: Mapping[str, str] | None = None, encoding: str | None = None) -> Detail:
    """Return the finest rendering that this terminal can be trusted with.

    Args:
        environment: variables such as TERM; this process's by default.
        encoding: of what is written; standard output's by default.
    """
    environment = os.environ if environment is None else environment
    encoding = encoding or getattr(sys.__stdout__, "encoding", None) or "ascii"
    kind = environment.get("TERM", "")
    if not encoding.lower().replace("-", "").startswith("utf8") or kind in ("dumb", "vt100", "vt220"):
        return "ascii"
    # The console of Linux has 512 glyphs: half-blocks are among them, braille is not.
    return "half" if kind == "linux" else "braille"


class PitchWidget(CoverableWidget):
    """Draws pictures of the pitch as large as there is room; repaints only the lines that have changed."""

    COMPONENT_CLASSES: ClassVar[set[str]] = component_classes()
    DEFAULT_CSS: ClassVar[str] = (
        "PitchWidget { width: auto; height: 1fr; content-align: center middle; }\n"
        + style_sheet("PitchWidget")
    )
    ALLOW_SELECT: ClassVar[bool] = False

    def __init__(
        self,
        length_m: float = 20.0,
        width_m: float = 20.0,
        *,
        detail: Detail | None = None,
        beside: int = 0,
        palette: Palette = STANDARD,
        caption: bool = True,
        id: str | None = None,
        classes: str | None = None,
    ) -> None:
        """Draw an empty pitch.

        Args:
            length_m: extent of the region from left to right.
            width_m: extent of the region downwards.
            detail: how fine; what the terminal can show by default.
            beside: columns to leave for others in the same row.
            palette: colours; the pitch is colour-blind safe in any.
            caption: whether the boundary says what is going on, and how an episode ended.
            id: Textual's name of the widget.
            classes: Textual's style classes.
        """
        super().__init__(id=id, classes=classes)
        self.length_m, self.width_m = length_m, width_m
        self.frame = -1
        """Number of the picture given last; see `show`."""
        self.drawn_frame = -1
        """Number of the newest picture of which at least one line has been drawn."""
        self._detail: Detail = detail or detail_for()
        self._beside = beside
        self._note = ""
        self._caption = caption
        self._mark: Mark | None = None
        self._mark_timer: TimerHandle | None = None
        self._options: tuple[tuple[int, str], ...] = ()
        self._title: str | None = None
        self._view: PitchFrame | None = None
        self._shape: Shape | None = None
        self._rows: tuple[Row, ...] = ()
        self._strips: LRUCache[Row, Strip] = LRUCache(512)
        self._looks: dict[tuple[int, int], Style] = {}
        self.add_class(f"-{palette.name}" if palette.name in PALETTES else f"-{STANDARD.name}")

    # --- what is shown --------------------------------------------------------------------------------------

    def show(self, view: PitchFrame, frame: int = -1) -> bool:
        """Draw this picture with the next paint.

        Args:
            view: of a region of this widget's size.
            frame: its number, which `drawn_frame` takes on when it is drawn.

        Returns:
            Whether anything visible changes; where not, nothing is drawn and `drawn_frame` stays.

        Raises:
            ValueError: the picture is of another region.
        """
        if (view.length_m, view.width_m) != (self.length_m, self.width_m):
            raise ValueError(
                f"a pitch of {self.length_m:g} m x {self.width_m:g} m cannot show a picture of "
                f"{view.length_m:g} m x {view.width_m:g} m: make the widget in the size of the game"
            )
        self._view = view
        self.frame = frame
        return self._redraw()

    @property
    def detail(self) -> Detail:
        """How fine the pitch is drawn; may be changed at any time."""
        return self._detail

    @detail.setter
    def detail(self, detail: Detail) -> None:
        self._detail = detail
        self._redraw()

    @property
    def note(self) -> str:
        """What stands in the boundary at the bottom right, such as the presses left."""
        return self._note

    @note.setter
    def note(self, note: str) -> None:
        if note != self._note:
            self._note = note
            self._redraw()

    @property
    def title(self) -> str | None:
        """What stands in the boundary at the top left; None for the number of the episode."""
        return self._title

    @title.setter
    def title(self, title: str | None) -> None:
        if title != self._title:
            self._title = title
            self._redraw()

    def mark(self, player: int, target: int = -1, *, good: bool) -> None:
        """Mark for a moment who chose an option, and who was passed to (-1: nobody)."""
        self.unmark()
        self._mark = Mark((player, target) if target >= 0 else (player,), good)
        self._mark_timer = after(self, MARK_S, self.unmark)
        self._redraw()

    def unmark(self) -> None:
        """Take the mark away."""
        if self._mark_timer is not None:
            self._mark_timer.cancel()
            self._mark_timer = None
        if self._mark is not None:
            self._mark = None
            self._redraw()

    def pose(self, options: tuple[tuple[int, str], ...]) -> None:
        """Write the keys of a question's options beside players; none takes them away.

        Args:
            options: player, and the key of the option.
        """
        self._options = options
        self._redraw()

    # --- drawing --------------------------------------------------------------------------------------------

    def get_content_width(self, container: Size, viewport: Size) -> int:
        """Return the width of the largest pitch that there is room for."""
        shape = fit(self.length_m, self.width_m, container.width - self._beside, container.height)
        return container.width - self._beside if shape is None else shape.columns

    def on_resize(self) -> None:
        """Draw in the new size."""
        self._shape = fit(self.length_m, self.width_m, self.size.width, self.size.height)
        self._redraw()
        self.refresh()

    def notify_style_update(self) -> None:
        """Forget what was drawn in the old style."""
        self._strips.clear()
        self._looks.clear()
        super().notify_style_update()

    def _redraw(self) -> bool:
        """Work the picture out; ask for its changed lines to be painted and return whether there are any."""
        if self._view is None or self._shape is None:
            return False
        before = self._rows
        self._rows = draw(
            self._view,
            self._shape,
            self._detail,
            self._note,
            self._title,
            caption=self._caption,
            mark=self._mark,
            options=self._options,
        )
        if self.hidden_whole or before == self._rows:
            return False
        if len(before) != len(self._rows):
            self.refresh()
            return True
        top, width = self._top, self.size.width
        changed = [
            Region(0, top + line, width, 1) for line, row in enumerate(self._rows) if row != before[line]
        ]
        self.refresh(*changed)
        return True

    @property
    def _top(self) -> int:
        return (self.size.height - len(self._rows)) // 2

    def render_line(self, y: int) -> Strip:
        """Return one line of the widget's content."""
        line = y - self._top
        words = self.covering(y, self.size.height)
        if words is not None:
            return self._words(words)
        if self._shape is None:
            return self._words(TOO_SMALL if y == self.size.height // 2 else "")
        if not 0 <= line < len(self._rows):
            return Strip.blank(self.size.width, self.rich_style)
        self.drawn_frame = self.frame
        return self._strip(self._rows[line])

    def _strip(self, row: Row) -> Strip:
        strip = self._strips.get(row)
        if strip is None:
            segments = [Segment(text, self._look(ink, paper)) for text, ink, paper in row]
            width = sum(len(text) for text, _, _ in row)
            margin = (self.size.width - width) // 2
            strip = Strip([Segment(" " * margin, self.rich_style), *segments]).adjust_cell_length(
                self.size.width, self.rich_style
            )
            self._strips[row] = strip
        return strip

    def _look(self, ink: int, paper: int) -> Style:
        look = self._looks.get((ink, paper))
        if look is None:
            front = self.get_component_rich_style(f"pitch--{INKS[ink]}")
            back = self.get_component_rich_style(f"pitch--{INKS[paper]}")
            look = Style(color=front.color, bgcolor=back.bgcolor, bold=front.bold)
            self._looks[ink, paper] = look
        return look

    def _words(self, text: str) -> Strip:
        width = self.size.width
        style = self._look(WORDS, GRASS)
        return Strip([Segment(text[:width].center(width), style)], width)
