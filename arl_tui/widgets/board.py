"""The board of Tetris."""

from asyncio import TimerHandle
from collections.abc import Iterable, Sequence
from typing import ClassVar

from rich.segment import Segment
from textual.geometry import Region, Size
from textual.strip import Strip

from arl_tui.app.once import after
from arl_tui.palette import STANDARD, Palette
from arl_tui.widgets.blocks import CELLS_PER_BLOCK, MARKED_BAD, MARKED_GOOD, BlockWidget
from arl_tui.widgets.coverable import CoverableWidget
from core.tetris.picture import FALLING, Snapshot

MARK_S = 1.0
"""How long a mark stays, seconds."""


class TetrisBoard(BlockWidget, CoverableWidget):
    """Draws snapshots; repaints only the rows that have changed.

    Two cells per block: a board of 20 x 10 takes 22 lines and 22 columns with its border.
    """

    COMPONENT_CLASSES: ClassVar[set[str]] = {"board--cover", "board--option"}
    DEFAULT_CSS: ClassVar[str] = """
    TetrisBoard {
        width: auto;
        height: auto;
        border: round $foreground 40%;
        border-title-color: $foreground 75%;
        border-title-align: center;
    }
    TetrisBoard > .board--option { background: $foreground; color: $background; text-style: bold; }
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
        self._plain = self._codes
        """The same without a mark."""
        self._mark: tuple[frozenset[int] | None, int] | None = None
        """What is marked (places in the codes; None for the falling piece), and with which code."""
        self._mark_timer: TimerHandle | None = None
        self._options: dict[int, str] = {}
        """What is written on a place (in the codes) for the options of a question: two characters."""
        self._due = False
        """Whether a picture is to be drawn, other than for a mark."""
        self._silent = False
        """Whether the next paint is for a mark alone, and no new picture."""

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
        if snapshot.cleared:
            self._forget_mark()  # what is above these rows is about to be elsewhere
        before, plain_before = self._codes, self._plain
        self._plain = snapshot.codes()
        self._codes = self._with_mark()
        self.frame = frame
        if self.hidden_whole or (before == self._codes and plain_before == self._plain):
            return False
        self._due, self._silent = True, False
        self._repaint(before)
        return True

    def take_drawn(self) -> int:
        """Return the newest picture of which a row has been drawn since the last call; -1 where none has.

        A mark that comes or goes is no picture: it is not counted.
        """
        drawn, self.drawn_frame = self.drawn_frame, -1
        self._due, self._silent = False, False
        return drawn

    @property
    def shows_falling(self) -> bool:
        """Whether a piece is falling in the present picture."""
        return any(code & FALLING for code in self._plain)

    def mark(self, blocks: Iterable[tuple[int, int]] | None, *, good: bool) -> None:
        """Mark blocks for a moment, over what the pictures show.

        Args:
            blocks: (row from the bottom, column) of settled blocks; None for the falling piece.
            good: whether they were judged good.
        """
        self._forget_mark()
        places = None
        if blocks is not None:
            places = frozenset(
                (self.rows - 1 - row) * self.columns + column for row, column in blocks if row < self.rows
            )
        self._remark((places, MARKED_GOOD if good else MARKED_BAD))
        self._mark_timer = after(self, MARK_S, self.unmark)

    def unmark(self) -> None:
        """Take the mark away."""
        self._forget_mark()
        self._remark(None)

    def pose(self, options: Sequence[tuple[Iterable[tuple[int, int]], str]]) -> None:
        """Draw the options of a question over the picture; none takes them away.

        Args:
            options: (row from the bottom, column) of the piece at rest, and the option's key, one character.
                Where two options share a block both keys stand on it.
        """
        keys: dict[int, str] = {}
        for blocks, key in options:
            for row, column in blocks:
                if row < self.rows:
                    place = (self.rows - 1 - row) * self.columns + column
                    keys[place] = keys.get(place, "") + key
        self._options = {place: (held * CELLS_PER_BLOCK)[:CELLS_PER_BLOCK] for place, held in keys.items()}
        self._silent = not self._due
        self.refresh()

    def _with_options(self, y: int, strip: Strip) -> Strip:
        """Return a line of the board with the options on it."""
        style = self.get_component_rich_style("board--option")
        pieces: list[Strip] = []
        for column in range(self.columns):
            start = column * CELLS_PER_BLOCK
            text = self._options.get(y * self.columns + column)
            cell = strip.crop(start, start + CELLS_PER_BLOCK)
            pieces.append(cell if text is None else Strip([Segment(text, style)], CELLS_PER_BLOCK))
        return Strip.join(pieces)

    def _forget_mark(self) -> None:
        self._mark = None
        if self._mark_timer is not None:
            self._mark_timer.cancel()
            self._mark_timer = None

    def _remark(self, mark: tuple[frozenset[int] | None, int] | None) -> None:
        before, self._mark = self._codes, mark
        self._codes = self._with_mark()
        if before != self._codes and not self.hidden_whole:
            self._silent = not self._due
            self._repaint(before)

    def _with_mark(self) -> bytes:
        """Return the codes of the present picture with the mark over them."""
        if self._mark is None:
            return self._plain
        places, marked = self._mark
        return bytes(
            (code & 15) | marked
            if (code & FALLING if places is None else place in places and 0 < code < FALLING)
            else code
            for place, code in enumerate(self._plain)
        )

    def _repaint(self, before: bytes) -> None:
        """Ask for the rows to be painted that have changed."""
        width, after_ = self.columns, self._codes
        changed = [
            Region(0, row, width * CELLS_PER_BLOCK, 1)
            for row in range(self.rows)
            if before[row * width : (row + 1) * width] != after_[row * width : (row + 1) * width]
        ]
        if changed:
            self.refresh(*changed)

    def render_line(self, y: int) -> Strip:
        """Return one line of the widget's content."""
        if y >= self.rows:
            return Strip.blank(self.size.width)
        words = self.covering(y, self.rows)
        if words is not None:
            return self._cover_line(words)
        if not self._silent:
            self.drawn_frame = self.frame
        strip = self.strip(self._codes[y * self.columns : (y + 1) * self.columns])
        return self._with_options(y, strip) if self._options else strip

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
