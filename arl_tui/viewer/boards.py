"""The games with marks: credited pieces and candidates on a board, bars at the receivers on a pitch."""

from collections.abc import Mapping
from types import MappingProxyType

from rich.segment import Segment
from rich.style import Style
from textual.strip import Strip

from arl_tui.widgets.blocks import CELLS_PER_BLOCK
from arl_tui.widgets.board import TetrisBoard
from arl_tui.widgets.pitch import PitchWidget
from arl_tui.widgets.pitch_sheet import Sheet
from core.keepaway.picture import PitchFrame

Marks = Mapping[tuple[int, int], tuple[str, Style]]
"""By line and column (of blocks, or of characters): what is written there."""
_EIGHTHS = " ▏▎▍▌▋▊▉"
CANDIDATE = Style(color="#f0e442", bgcolor="#33301a", bold=True)
WHAT_IF = Style(color="#cc79a7", bgcolor="#33202c", bold=True)
PRAISED = Style(color="#000000", bgcolor="#9be08f", bold=True)
BLAMED = Style(color="#000000", bgcolor="#ff8d85", bold=True)


def _with_marks(strip: Strip, marks: list[tuple[int, str, Style]], width: int) -> Strip:
    """Return a line with texts written over it, in the order of their columns."""
    parts: list[Strip] = []
    at = 0
    for column, text, style in marks:
        if column < at or column + len(text) > width:
            continue
        parts += [strip.crop(at, column), Strip([Segment(text, style)])]
        at = column + len(text)
    return Strip.join([*parts, strip.crop(at, width)])


class MarkedBoard(TetrisBoard):
    """A board of Tetris with marks on blocks."""

    _marks: Marks = MappingProxyType({})

    def overlay(self, marks: Marks) -> None:
        """Write two characters over each of these blocks (line from the top, column)."""
        if marks != self._marks:
            self._marks = dict(marks)
            self.refresh()

    def render_line(self, y: int) -> Strip:
        """Return one line of the widget's content."""
        strip = super().render_line(y)
        here = [
            (column * CELLS_PER_BLOCK, text, style)
            for (line, column), (text, style) in sorted(self._marks.items())
            if line == y
        ]
        if not here or self.covered:
            return strip
        return _with_marks(strip, here, self.columns * CELLS_PER_BLOCK)


class MarkedPitch(PitchWidget):
    """A pitch with bars beneath the players' names."""

    _bars: Mapping[int, tuple[str, Style]] = MappingProxyType({})

    def overlay(self, bars: Mapping[int, tuple[str, Style]]) -> None:
        """Write a short text beneath each of these players."""
        if bars != self._bars:
            self._bars = dict(bars)
            self.refresh()

    def render_line(self, y: int) -> Strip:
        """Return one line of the widget's content."""
        strip = super().render_line(y)
        view, shape = self._view, self._shape
        if not self._bars or view is None or shape is None or self.covered:
            return strip
        top = (self.size.height - shape.lines) // 2
        margin = (self.size.width - shape.columns) // 2
        here = []
        for player, (text, style) in self._bars.items():
            column, line = _beneath(view, Sheet(view, shape, self.detail), player, len(text))
            if top + line == y:
                here.append((margin + column, text, style))
        return _with_marks(strip, sorted(here), self.size.width) if here else strip


def _beneath(view: PitchFrame, sheet: Sheet, player: int, length: int) -> tuple[int, int]:
    """Return where a text beneath a player begins: column and line."""
    column, line = sheet.point(view.players[player].x_m, view.players[player].y_m)
    row = int(line) + 1
    if row > sheet.shape.lines - 2:
        row = int(line) - 1
    start = min(max(round(column - length / 2), 1), sheet.shape.columns - 1 - length)
    return start, row


def bar(fraction: float, width: int = 3) -> str:
    """Return a bar of `width` characters that is full at a fraction of 1; at least a trace of it."""
    full, rest = divmod(round(min(max(fraction, 0.02), 1.0) * width * 8), 8)
    return ("█" * full + (_EIGHTHS[rest] if rest else "")).ljust(width)
