"""What is done at a step of Tetris, as recordings hold it."""

from msgspec import UNSET, UnsetType

from core.events import ActionRecord


class PlacedPiece(ActionRecord, frozen=True):
    """A piece and where it was put."""

    piece: int
    """0 to 6, in the order of `core.tetris.shapes`."""
    orientation: int | UnsetType = UNSET
    """Number of quarter turns, from 0; not set where an imported log does not say."""
    column: int | UnsetType = UNSET
    """Of the piece's leftmost block, from 0; not set where an imported log does not say."""

    @property
    def place(self) -> tuple[int, int]:
        """Orientation and column.

        Raises:
            ValueError: the log does not say where the piece was put.
        """
        if self.orientation is UNSET or self.column is UNSET:
            raise ValueError(f"where piece {self.piece} was put is not recorded")
        return self.orientation, self.column
