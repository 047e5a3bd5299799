"""Tetris in the play screen: the board, the next piece, and the score."""

from collections.abc import Iterable, Sequence

from textual.geometry import Size
from textual.widget import Widget

from arl_tui.app.link import Picture, TakenFor
from arl_tui.games.panel import SMALLEST, Progress
from arl_tui.games.rendering import Place
from arl_tui.language import tr
from arl_tui.palette import Palette
from arl_tui.widgets.blocks import CELLS_PER_BLOCK
from arl_tui.widgets.board import TetrisBoard
from arl_tui.widgets.coverable import CoverableWidget
from arl_tui.widgets.next_piece import ROWS, NextPiece
from arl_tui.widgets.stats import Figures, StatsPanel
from core.session.protocol import Protocol
from core.tetris.config import TetrisConfig
from core.tetris.picture import Snapshot

BESIDE = 58
"""Columns that Tetris takes beside its blocks."""
BELOW = 3
"""Lines that it takes beside its rows: border and keys."""
LARGEST_NEXT = 2
"""A block of the next piece is at most so many lines high."""


class TetrisPanel:
    """The board, the next piece, and the score."""

    def __init__(self, protocol: Protocol, palette: Palette) -> None:
        """Draw an empty board of the protocol's size."""
        assert isinstance(protocol.domain, TetrisConfig), "a protocol of Tetris"
        rows, columns = protocol.domain.rows, protocol.domain.columns
        self.board = TetrisBoard(rows, columns, palette=palette, around=Size(BESIDE, BELOW))
        self.needed = Size(
            max(SMALLEST.width, columns * CELLS_PER_BLOCK + BESIDE), max(SMALLEST.height, rows + BELOW)
        )
        self._next = NextPiece(palette=palette, lines_in=self._lines_in_next)
        self._stats = StatsPanel(grows=lambda window: ROWS * (self._lines_in_next(window) - 1))
        self._step = -1

    def _lines_in_next(self, window: Size) -> int:
        """Return how many lines high a block of the next piece is: a larger one would take the figures'
        room.
        """
        return min(LARGEST_NEXT, self.board.lines_in(window))

    def take_drawn(self) -> bool:
        """Return whether a line of the board has been drawn since the last call, other than for a mark."""
        return self.board.take_drawn() >= 0

    def game_widget(self) -> CoverableWidget:
        """Return the board."""
        return self.board

    def figures(self) -> Iterable[Widget]:
        """Return next piece and score."""
        return self._next, self._stats

    def show(self, picture: Picture, progress: Progress) -> None:
        """Draw a board."""
        view = picture.view
        assert isinstance(view, Snapshot), "a worker that plays Tetris sends boards"
        changed = self.board.show(view, picture.number)
        if not changed and picture.step != self._step:
            # Another step that looks the same is still to be seen, and stamped.
            self.board.refresh()
        self._step = picture.step
        self._next.show(view.counts.next_piece)
        self._stats.show(
            Figures(
                lines=view.counts.lines,
                pieces=view.counts.pieces,
                episode=progress.episode,
                episodes=progress.episodes,
                human_weights=progress.human_weights or None,
            )
        )

    def refresh(self) -> None:
        """Draw the board once more."""
        self.board.refresh()

    def title(self, text: str) -> None:
        """Write into the board's border."""
        self.board.border_title = text

    def part(self, text: str) -> None:
        """Write into the border of the figures."""
        self._stats.border_title = text

    def mark(self, taken: TakenFor) -> str:
        """Mark the piece, where it is falling or what is left of it on the wall."""
        if taken.step < 0:
            return tr("but no piece had landed")
        if taken.value == 0:
            falling = taken.step == self._step
            return tr("for the falling piece") if falling else tr("for the piece that landed")
        if taken.step == self._step and self.board.shows_falling:
            self.board.mark(None, good=taken.value > 0)
        elif taken.place:
            self.board.mark([(row, column) for row, column in taken.place], good=taken.value > 0)
        else:
            return tr("for the last piece, which is gone")
        return tr("for the marked piece")

    def unmark(self) -> None:
        """Take the mark away."""
        self.board.unmark()

    def pose(self, places: Sequence[Place], keys: Sequence[str]) -> None:
        """Draw the piece where each option would put it, by the option's key."""
        self.board.pose(
            [
                ([(row, column) for row, column in place], key)
                for place, key in zip(places, keys, strict=False)
            ]
        )

    def unpose(self) -> None:
        """Take the options away."""
        self.board.pose(())

    def presses_left(self, presses: int | None) -> None:
        """Say nothing: the feedback bar is near enough."""
