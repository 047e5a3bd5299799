"""Where a stimulus appears: a box of fixed size whose content changes in one picture."""

from typing import ClassVar

from rich.segment import Segment
from rich.style import Style
from textual.geometry import Size
from textual.strip import Strip
from textual.widget import Widget

COLUMNS, ROWS = 36, 9
FIXATION = "+"
_SHAPES: dict[str, tuple[str, ...]] = {
    "X": ("██      ██", "  ██  ██  ", "    ██    ", "  ██  ██  ", "██      ██"),
    "O": ("  ██████  ", "██      ██", "██      ██", "██      ██", "  ██████  "),
    "<<<": ("    ██    ", "  ██      ", "██████████", "  ██      ", "    ██    "),
    ">>>": ("    ██    ", "      ██  ", "██████████", "      ██  ", "    ██    "),
}
"""Large drawings; everything else is shown as text."""


def drawing(stimulus: str) -> tuple[str, ...]:
    """Return the lines that show a stimulus, all equally long."""
    lines = _SHAPES.get(stimulus) or tuple(stimulus.split("\n"))
    width = max(len(line) for line in lines)
    return tuple(line.ljust(width) for line in lines)


class StimulusBox(Widget, inherit_bindings=False, can_focus=False):
    """Shows a fixation mark, a stimulus, or nothing."""

    COMPONENT_CLASSES: ClassVar[set[str]] = {"stimulus--shown", "stimulus--fixation"}
    DEFAULT_CSS: ClassVar[str] = """
    StimulusBox { width: 38; height: 11; border: round $foreground 40%; }
    StimulusBox > .stimulus--shown { color: $foreground; text-style: bold; }
    StimulusBox > .stimulus--fixation { color: $foreground 60%; }
    """
    ALLOW_SELECT: ClassVar[bool] = False

    def __init__(self) -> None:
        super().__init__()
        self.drawn = -1
        """Number of the stimulus that has been drawn since this was last set to -1."""
        self._lines: tuple[str, ...] = ()
        self._number = -1
        self._look = "stimulus--fixation"

    def get_content_width(self, container: Size, viewport: Size) -> int:
        """Return the width in cells."""
        return COLUMNS

    def get_content_height(self, container: Size, viewport: Size, width: int) -> int:
        """Return the height in lines."""
        return ROWS

    def show(self, stimulus: str, number: int = -1) -> None:
        """Show a stimulus (or an item to study) with the next paint; `drawn` takes on its number then."""
        self._set(drawing(stimulus), number, "stimulus--shown")

    def fixate(self) -> None:
        """Show the mark to look at."""
        self._set((FIXATION,), -1, "stimulus--fixation")

    def clear(self) -> None:
        """Show nothing."""
        self._set((), -1, "stimulus--fixation")

    @property
    def lines(self) -> tuple[str, ...]:
        """What is shown."""
        return self._lines

    def _set(self, lines: tuple[str, ...], number: int, look: str) -> None:
        if (lines, number, look) != (self._lines, self._number, self._look):
            self._lines, self._number, self._look = lines, number, look
            self.refresh()

    def render_line(self, y: int) -> Strip:
        """Return one line of the content."""
        self.drawn = self._number
        at = y - (ROWS - len(self._lines)) // 2
        text = self._lines[at] if 0 <= at < len(self._lines) else ""
        style: Style = self.get_component_rich_style(self._look)
        return Strip([Segment(text.center(COLUMNS)[:COLUMNS], style)], COLUMNS)
