"""The piece that comes next."""

from collections.abc import Callable
from typing import ClassVar

from textual.geometry import Size
from textual.strip import Strip

from arl_tui.language import tr
from arl_tui.palette import STANDARD, Palette
from arl_tui.widgets.blocks import CELLS_PER_BLOCK, BlockWidget
from core.tetris.game import flattest
from core.tetris.picture import FALLING
from core.tetris.shapes import MAX_SHAPE_SIZE, ORIENTATION_ROWS

ROWS = 2
"""Every piece lies in two rows when it enters."""


class NextPiece(BlockWidget):
    """Shows one piece as it will enter, or an empty box."""

    STRIPED: ClassVar[bool] = False
    DEFAULT_CSS: ClassVar[str] = """
    NextPiece {
        width: auto;
        height: auto;
        padding: 1 1;
        border: round $foreground 40%;
        border-title-color: $foreground 75%;
        border-title-align: center;
    }
    """

    def __init__(
        self,
        *,
        palette: Palette = STANDARD,
        lines_in: Callable[[Size], int] = lambda window: 1,
        id: str | None = None,
        classes: str | None = None,
    ) -> None:
        """Draw an empty box.

        Args:
            palette: colours.
            lines_in: returns how many lines high a block is in a window: as on the board beside it.
            id: Textual's name of the widget.
            classes: Textual's style classes.
        """
        super().__init__(palette=palette, id=id, classes=classes)
        self._lines_in = lines_in
        self.border_title = tr("Next")
        self._piece = -1

    def get_content_width(self, container: Size, viewport: Size) -> int:
        """Return the width of the widest piece and a cell on either side."""
        return MAX_SHAPE_SIZE * CELLS_PER_BLOCK * self._lines_in(viewport) + 2

    def get_content_height(self, container: Size, viewport: Size, width: int) -> int:
        """Return the height of the highest piece as it enters."""
        return ROWS * self._lines_in(viewport)

    def show(self, piece: int) -> None:
        """Draw this piece (id 0..6), or nothing (-1)."""
        if piece != self._piece:
            self._piece = piece
            self.refresh()

    def render_line(self, y: int) -> Strip:
        """Return one line of the box."""
        width = self.size.width
        empty = self.get_component_rich_style("block--empty")
        lines = max(1, self.size.height // ROWS)
        row, line = divmod(y, lines)
        codes = self._codes(ROWS - 1 - row)
        if not codes:
            return Strip.blank(width, empty)
        strip = self.strip(codes, lines, last=line == lines - 1)
        left = (width - strip.cell_length) // 2
        right = width - strip.cell_length - left
        return Strip.join([Strip.blank(left, empty), strip, Strip.blank(right, empty)])

    def _codes(self, row: int) -> bytes:
        """Return the cells of a row of the piece, counted from the bottom; none where it does not reach."""
        if self._piece < 0:
            return b""
        shape = ORIENTATION_ROWS[self._piece][flattest(self._piece)]
        if not 0 <= row < len(shape):
            return b""
        width = max(shape).bit_length()
        return bytes((FALLING + self._piece + 1) * (shape[row] >> column & 1) for column in range(width))
