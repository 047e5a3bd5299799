"""What a screen shows of a game of Tetris: coloured walls, snapshots, and a placement as a row of snapshots.

Everything here is immutable and made of plain numbers and bytes, so that it can be sent to another process.
"""

import msgspec

from core.plugins import View
from core.tetris.game import (
    Board,
    FallingPiece,
    Plan,
    Settled,
    at_rest,
    flight,
    landing_row,
    rest_row,
    settle,
    spawn,
)

EMPTY = 0
"""Code of an empty cell; a settled cell has the id of its piece plus one."""
UNKNOWN = 8
"""Code of a settled cell of which nobody knows the piece."""
FALLING = 16
"""Added to a cell of the falling piece."""
GHOST = 32
"""Added to an empty cell where the falling piece would come to rest."""
CLEARED = 64
"""Added to a cell of a row that has just been filled."""


class Wall(msgspec.Struct, frozen=True, array_like=True):
    """The settled cells with their colours."""

    rows: int
    columns: int
    levels: tuple[bytes, ...] = ()
    """Rows from the bottom, one byte per cell (codes above); rows that are not listed are empty."""

    @classmethod
    def of_board(cls, board: Board, rows: int) -> "Wall":
        """Return a wall whose pieces nobody knows."""
        height = max(bits.bit_length() for bits in board)
        levels = tuple(bytes(UNKNOWN * (bits >> row & 1) for bits in board) for row in range(height))
        return cls(rows=rows, columns=len(board), levels=levels)

    @property
    def board(self) -> Board:
        """Column bitboards, as the learner sees them."""
        return tuple(
            sum(1 << row for row, level in enumerate(self.levels) if level[column])
            for column in range(self.columns)
        )

    def with_piece(self, falling: FallingPiece) -> "Wall":
        """Return the wall with the piece added where it is; nothing is cleared."""
        levels = [bytearray(level) for level in self.levels]
        levels += [bytearray(self.columns) for _ in range(falling.row + falling.height - len(levels))]
        for row, column in falling.cells():
            levels[row][column] = falling.piece + 1
        return Wall(self.rows, self.columns, tuple(bytes(level) for level in levels))

    def without(self, cleared: tuple[int, ...]) -> "Wall":
        """Return the wall without these rows, what was above them lower."""
        kept = tuple(level for row, level in enumerate(self.levels) if row not in cleared)
        return Wall(self.rows, self.columns, kept)

    def from_top(self) -> bytes:
        """Return rows x columns codes from the highest row of the board; what sticks out above it is left
        out.
        """
        inside = self.levels[: self.rows]
        return bytes(self.columns) * (self.rows - len(inside)) + b"".join(reversed(inside))


class Counts(msgspec.Struct, frozen=True, kw_only=True, array_like=True):
    """The figures beside the board."""

    lines: int = 0
    pieces: int = 0
    """Pieces that have come to rest."""
    next_piece: int = -1
    """Id of the piece after the falling one; -1 where it is not shown."""


class Snapshot(msgspec.Struct, View, frozen=True, kw_only=True, array_like=True, tag="tetris"):
    """One picture of a game."""

    rows: int
    columns: int
    cells: bytes
    """Settled cells: rows x columns codes from the highest row, each row from the left."""
    falling: FallingPiece | None = None
    ghost_row: int = -1
    """Row in which the falling piece would come to rest; -1 without a falling piece."""
    cleared: tuple[int, ...] = ()
    """Rows (from the bottom) that are full and about to go."""
    counts: Counts = Counts()
    tick: int = 0
    """Number of the picture since the piece entered."""
    over: bool = False

    def codes(self) -> bytes:
        """Return what each cell shows: rows x columns codes from the highest row, each row from the left."""
        codes = bytearray(self.cells)
        if self.falling is not None:
            for row, column in self.falling.cells():
                self._mark(
                    codes, row + self.ghost_row - self.falling.row, column, GHOST + self.falling.piece + 1
                )
            for row, column in self.falling.cells():
                self._mark(codes, row, column, FALLING + self.falling.piece + 1)
        for row in self.cleared:
            start = (self.rows - 1 - row) * self.columns
            for index in range(start, start + self.columns):
                codes[index] += CLEARED
        return bytes(codes)

    def _mark(self, codes: bytearray, row: int, column: int, code: int) -> None:
        if row < self.rows:
            codes[(self.rows - 1 - row) * self.columns + column] = code


def snapshot(
    wall: Wall,
    falling: FallingPiece | None = None,
    *,
    counts: Counts,
    cleared: tuple[int, ...] = (),
    tick: int = 0,
    over: bool = False,
) -> Snapshot:
    """Return the picture of a wall with a piece above it."""
    return Snapshot(
        rows=wall.rows,
        columns=wall.columns,
        cells=wall.from_top(),
        falling=falling,
        ghost_row=-1 if falling is None else rest_row(wall.board, falling),
        # A row above the board cannot be shown.
        cleared=tuple(row for row in cleared if row < wall.rows),
        counts=counts,
        tick=tick,
        over=over,
    )


class PieceAnimation(msgspec.Struct, frozen=True):
    """A placement from entering to the settled board, one picture per tick."""

    frames: tuple[Snapshot, ...]
    """`frames[i]` is on screen during tick i; the last one stays until the next piece enters."""
    wall: Wall
    """The coloured wall afterwards: what the next animation starts from."""
    settled: Settled
    """The same in the learner's terms."""

    @property
    def ticks(self) -> int:
        """How many pictures there are."""
        return len(self.frames)


def animate(
    wall: Wall,
    piece: int,
    placement: tuple[int, int],
    plan: Plan | None,
    *,
    counts: Counts,
    drop_rows_per_tick: int = 4,
    clear_on_overflow: bool = False,
) -> PieceAnimation:
    """Draw a placement tick by tick.

    Args:
        wall: what has settled before.
        piece: id of the piece that enters.
        placement: (orientation, leftmost column), used where there is no plan.
        plan: primitives that bring the placement about (`core.tetris.game.reachable_placements`). None for a
            placement that primitives cannot reach: the piece then enters turned and above its columns.
        counts: the figures while the piece falls; lines and pieces are brought up to date in the last
            picture.
        drop_rows_per_tick: a drop is shown as a fall of this many rows per tick, >= 1.
        clear_on_overflow: see `core.tetris.game.settle`.

    Raises:
        ValueError: the plan does not bring the piece to rest, or `drop_rows_per_tick` is not positive.
    """
    if drop_rows_per_tick < 1:
        raise ValueError(f"drop_rows_per_tick is at least 1, got {drop_rows_per_tick}")
    board = wall.board
    path = (
        _straight_path(wall, piece, placement)
        if plan is None
        else flight(board, spawn(board, piece, wall.rows), plan)
    )
    shown = _slow_drop(path, drop_rows_per_tick)
    frames = [snapshot(wall, falling, counts=counts, tick=tick) for tick, falling in enumerate(shown)]
    settled = settle(board, path[-1], wall.rows, clear_on_overflow=clear_on_overflow)
    filled = wall.with_piece(path[-1])
    if settled.cleared:
        frames.append(snapshot(filled, counts=counts, cleared=settled.cleared, tick=len(frames)))
    after = filled.without(settled.cleared)
    final = Counts(
        lines=counts.lines + len(settled.cleared), pieces=counts.pieces + 1, next_piece=counts.next_piece
    )
    frames.append(snapshot(after, counts=final, tick=len(frames), over=settled.over))
    return PieceAnimation(frames=tuple(frames), wall=after, settled=settled)


def _straight_path(wall: Wall, piece: int, placement: tuple[int, int]) -> tuple[FallingPiece, ...]:
    """Return a fall from the top of the board, or from the landing row where that is higher."""
    orientation, column = placement
    landing = landing_row(wall.board, piece, orientation, column)
    high = FallingPiece(piece, orientation, landing, column)
    start = FallingPiece(piece, orientation, max(landing, wall.rows - high.height), column)
    return (start, at_rest(wall.board, start))


def _slow_drop(path: tuple[FallingPiece, ...], rows_per_tick: int) -> list[FallingPiece]:
    """Return the path with its last leg, if it is longer than a row, cut into falls of `rows_per_tick`."""
    shown = list(path[:-1])
    last = path[-1]
    rows = (
        range(path[-2].row - rows_per_tick, last.row, -rows_per_tick) if path[-2].row - last.row > 1 else ()
    )
    shown += [FallingPiece(last.piece, last.orientation, row, last.column) for row in rows]
    return [*shown, last]
