"""How practice went: performance per game over the blocks of unseen games. Import it late: plotting brings
numpy.
"""

import math
from collections.abc import Sequence

from textual_plot import HiResMode, PlotWidget

MAX_TICKS = 10
"""Along the blocks."""
LINES_A_TICK = 4
"""Two ticks on one line of a low plot would be one, at the wrong height."""


def ticks(top: float, most: int) -> list[float]:
    """Return 0 and multiples of a round number up to `top` (> 0): at most `most` beside 0."""
    power = 10.0 ** math.floor(math.log10(top / most))
    step = next(nice * power for nice in (1, 2, 4, 5, 10) if top / (nice * power) < most + 1)
    return [k * step for k in range(int(top / step) + 1)]


class LearningCurve(PlotWidget, can_focus=False):
    """A line through the mean performance of each block."""

    DEFAULT_CSS = """
    LearningCurve { height: 7; }
    LearningCurve > .plot--axis { color: $foreground 60%; }
    LearningCurve > .plot--tick { color: $foreground; }
    """

    def __init__(self, practised: Sequence[float]) -> None:
        """Draw two blocks or more.

        Args:
            practised: mean performance of each block.
        """
        super().__init__(allow_pan_and_zoom=False)
        self._practised = list(practised)

    def on_mount(self) -> None:
        """Plot once the plot has its size and has made its own preparations, which clear it."""
        self.margin_top, self.margin_bottom = 0, 1  # there are few lines, and the curve needs them
        self.call_after_refresh(self._draw)

    def _draw(self) -> None:
        blocks = list(range(1, len(self._practised) + 1))
        self.plot(blocks, self._practised, line_style="bright_cyan", hires_mode=HiResMode.BRAILLE)
        self.set_xlimits(1, len(blocks))
        top = max(*self._practised, 1.0)
        self.set_ylimits(-0.05 * top, 1.05 * top)  # a little room, or a line along the floor is cut off
        self.set_yticks(ticks(top, most=max(2, self.size.height // LINES_A_TICK)))
        self.set_xticks(blocks if len(blocks) <= MAX_TICKS else [1, len(blocks)])
