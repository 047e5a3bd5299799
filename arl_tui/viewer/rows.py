"""A widget made of lines of styled text that are worked out when they are asked for."""

from collections.abc import Sequence
from typing import ClassVar

from rich.segment import Segment
from rich.style import Style
from textual.strip import Strip
from textual.widget import Widget

Run = tuple[str, Style | None]
"""Text and its style; None for the widget's own."""

DIM = Style(dim=True)
BOLD = Style(bold=True)
GOOD = Style(color="#68bd5e", bold=True)
BAD = Style(color="#e35d55", bold=True)
OTHER = Style(color="#8b93a5")
TRUST = Style(color="#56b4e9")
WEIGHT = Style(color="#e69f00")
SCORE = Style(color="#c4cfc8")
DIFFERS = Style(color="#cc79a7", bold=True)
TAG = Style(color="#f0e442", bold=True)
SHADES = (Style(bgcolor="#2b3242"), Style(bgcolor="#1a1d25"))
"""Behind games and steps, in turn."""
LEVELS = " ▁▂▃▄▅▆▇█"


def level(fraction: float) -> str:
    """Return a block as high as `fraction`, in [0, 1]; the lowest one for anything above 0."""
    if not fraction > 0:
        return LEVELS[0]
    return LEVELS[min(max(round(fraction * 8), 1), 8)]


class Rows(Widget, inherit_bindings=False, can_focus=False):
    """Draws the lines of `lines_of`, and draws only those anew that have changed."""

    ALLOW_SELECT: ClassVar[bool] = False

    def __init__(self, *, id: str | None = None, classes: str | None = None) -> None:
        super().__init__(id=id, classes=classes)
        self._lines: list[list[Run]] = []

    def show(self, lines: Sequence[Sequence[Run]]) -> None:
        """Draw these lines with the next paint."""
        fresh = [list(line) for line in lines]
        if fresh != self._lines:
            self._lines = fresh
            self.refresh()

    @property
    def text(self) -> str:
        """What is written, without styles."""
        return "\n".join("".join(text for text, _ in line).rstrip() for line in self._lines)

    def render_line(self, y: int) -> Strip:
        """Return one line of the widget's content."""
        width, own = self.size.width, self.rich_style
        if y >= len(self._lines):
            return Strip.blank(width, own)
        segments = [Segment(text, own if style is None else own + style) for text, style in self._lines[y]]
        return Strip(segments).adjust_cell_length(width, own)


def cells_to_runs(cells: Sequence[tuple[str, Style | None]]) -> list[Run]:
    """Join neighbouring cells of the same style."""
    runs: list[Run] = []
    for text, style in cells:
        if runs and runs[-1][1] == style:
            runs[-1] = (runs[-1][0] + text, style)
        else:
            runs.append((text, style))
    return runs
