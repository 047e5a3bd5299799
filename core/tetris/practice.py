"""A game of Tetris for a participant to play: the same board, pieces and primitives as the agent has."""

from collections.abc import Callable
from typing import Literal

from core.tetris.game import FallingPiece, Primitive, fallen, moved, settle, spawn
from core.tetris.picture import Counts, Snapshot, Wall, snapshot
from core.tetris.shapes import seven_bag_piece, uniform_piece

PIECE_STREAMS: dict[str, Callable[[int, int], int]] = {"uniform": uniform_piece, "seven-bag": seven_bag_piece}
"""Which piece comes k-th in an episode with a seed."""


class Practice:
    """The state of a practice game.

    It knows no clock: its caller says when gravity acts. A piece that gravity cannot move settles; where
    that fills rows, they are shown full until the next fall. The game is over when the pile is higher than
    the board.
    """

    def __init__(
        self,
        seed: int,
        *,
        rows: int = 20,
        columns: int = 10,
        pieces: Literal["uniform", "seven-bag"] = "uniform",
    ) -> None:
        """Begin a game.

        Args:
            seed: of the pieces, in [0, 2**63): equal seeds give equal pieces.
            rows: height of the board, >= 4.
            columns: width of the board, >= 4.
            pieces: how the pieces follow each other.

        Raises:
            ValueError: the board is too small.
        """
        if rows < 4 or columns < 4:
            raise ValueError(f"a board has at least 4 rows and 4 columns, got {rows} x {columns}")
        self.lines = 0
        self.pieces = 0
        self.over = False
        self._seed = seed
        self._piece = PIECE_STREAMS[pieces]
        self._wall = Wall(rows, columns)
        self._cleared: tuple[int, ...] = ()
        self._falling: FallingPiece | None = None
        self._enter()

    def step(self, primitive: Primitive | None) -> Snapshot:
        """Make one primitive, or let gravity act once (None), and return the new picture.

        A drop settles the piece at once. Primitives between two pieces and after the end change nothing.
        """
        if self.over:
            return self.picture()
        if self._falling is None:
            if primitive is None:
                self._wall = self._wall.without(self._cleared)
                self._cleared = ()
                self._enter()
            return self.picture()
        board = self._wall.board
        before = self._falling
        self._falling = fallen(board, before) if primitive is None else moved(board, before, primitive)
        if primitive is Primitive.DROP or (primitive is None and self._falling == before):
            self._settle(self._falling)
        return self.picture()

    def picture(self) -> Snapshot:
        """Return what the screen shows."""
        counts = Counts(
            lines=self.lines,
            pieces=self.pieces,
            next_piece=self._piece(self._seed, self.pieces + self._in_the_air),
        )
        return snapshot(self._wall, self._falling, counts=counts, cleared=self._cleared, over=self.over)

    @property
    def _in_the_air(self) -> int:
        return 0 if self._falling is None else 1

    def _enter(self) -> None:
        piece = self._piece(self._seed, self.pieces)
        self._falling = spawn(self._wall.board, piece, self._wall.rows)

    def _settle(self, falling: FallingPiece) -> None:
        settled = settle(self._wall.board, falling, self._wall.rows)
        self._wall = self._wall.with_piece(falling)
        self._cleared = settled.cleared
        self._falling = None
        self.lines += len(settled.cleared)
        self.pieces += 1
        self.over = settled.over
        if not self.over and not settled.cleared:
            self._enter()
