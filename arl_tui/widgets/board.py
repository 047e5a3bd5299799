"""The board of Tetris."""

from typing import ClassVar

from rich.segment import Segment
from textual.geometry import Region, Size
from textual.strip import Strip

from arl_tui.palette import STANDARD, Palette
from arl_tui.widgets.blocks import CELLS_PER_BLOCK, BlockWidget
from arl_tui.widgets.coverable import CoverableWidget
from core.tetris.picture import Snapshot


class TetrisBoard(BlockWidget, CoverableWidget):
    """Draws snapshots; repaints only the rows that have changed.

    Two cells per block: a board of 20 x 10 takes 22 lines and 22 columns with its border.
    """

    COMPONENT_CLASSES: ClassVar[set[str]] = {"board--cover"}
    DEFAULT_CSS: ClassVar[str] = """
    TetrisBoard {
        width: auto;
        height: auto;
        border: round $foreground 40%;
        border-title-color: $foreground 75%;
        border-title-align: center;
    }
    TetrisBoard > .board--cover { background: $surface; color: $foreground; text-style: bold; }
    """

    def __init__(
        self,
        rows: int = 20,
        columns: int = 10,
        *,
        palette: Palette = STANDARD,
        id: str | None = None,
        classes: str | None = None,
    ) -> None:
        """Draw an empty board of this size."""
        super().__init__(palette=palette, id=id, classes=classes)
        self.rows = rows
        self.columns = columns
        self.frame = -1
        """Number of the frame given last; see `show`."""
        self.drawn_frame = -1
        """Number of the newest frame of which at least one row has been drawn."""
        self._codes = bytes(rows * columns)

    def get_content_width(self, container: Size, viewport: Size) -> int:
        """Return the board's width in cells."""
        return self.columns * CELLS_PER_BLOCK

    def get_content_height(self, container: Size, viewport: Size, width: int) -> int:
        """Return the board's height in lines."""
        return self.rows

    def show(self, snapshot: Snapshot, frame: int = -1) -> bool:
        """Draw this snapshot with the next paint.

        Args:
            snapshot: of a board of this widget's size.
            frame: its number, which `drawn_frame` takes on when it is drawn.

        Returns:
            Whether anything visible changes; where not, nothing is drawn and `drawn_frame` stays.

        Raises:
            ValueError: the snapshot is of another size.
        """
        if (snapshot.rows, snapshot.columns) != (self.rows, self.columns):
            raise ValueError(
                f"a board of {self.rows} x {self.columns} cannot show a snapshot of "
                f"{snapshot.rows} x {snapshot.columns}: make the widget in the size of the game"
            )
        before, after = self._codes, snapshot.codes()
        self._codes = after
        self.frame = frame
        if self.hidden_whole or before == after:
            return False
        width = self.columns
        changed = [
            Region(0, row, width * CELLS_PER_BLOCK, 1)
            for row in range(self.rows)
            if before[row * width : (row + 1) * width] != after[row * width : (row + 1) * width]
        ]
        self.refresh(*changed)
        return True

    def render_line(self, y: int) -> Strip:
        """Return one line of the widget's content."""
        if y >= self.rows:
            return Strip.blank(self.size.width)
        words = self.covering(y, self.rows)
        if words is not None:
            return self._cover_line(words)
        self.drawn_frame = self.frame
        return self.strip(self._codes[y * self.columns : (y + 1) * self.columns])

    def _cover_line(self, words: str) -> Strip:
        width = self.columns * CELLS_PER_BLOCK
        text = words[:width]
        style = self.get_component_rich_style("board--cover")
        left = (width - len(text)) // 2
        return Strip(
            [
                Segment(" " * left, style),
                Segment(text, style),
                Segment(" " * (width - left - len(text)), style),
            ]
        )
