"""What the board and the next piece have in common: blocks of two cells, drawn a row at a time."""

from collections.abc import Iterator
from itertools import groupby
from typing import ClassVar

from rich.segment import Segment
from rich.style import Style
from textual.cache import LRUCache
from textual.geometry import Size
from textual.strip import Strip
from textual.widget import Widget

from arl_tui.palette import (
    BLOCKS,
    PALETTES,
    SEAM,
    SEAM_BELOW,
    STANDARD,
    Palette,
    component_classes,
    style_sheet,
)
from core.tetris.picture import CLEARED, EMPTY, FALLING, GHOST

CELLS_PER_BLOCK = 2
LARGEST = 5
"""A block is at most so many lines high."""
GHOST_TEXTURE = "░░"
MARKED_GOOD, MARKED_BAD = 128, 192
"""High bits of a marked block's code (`core.tetris.picture` leaves 128 free)."""


def lines_per_block(blocks: Size, around: Size, window: Size) -> int:
    """Return how many lines high a block is drawn, and half as many as its columns: as large as fits.

    Args:
        blocks: how many blocks there are across and down.
        around: columns and lines that everything else needs.
        window: columns and lines there are.

    Returns:
        A whole number in [1, LARGEST].
    """
    across = (window.width - around.width) // (CELLS_PER_BLOCK * blocks.width)
    down = (window.height - around.height) // blocks.height
    return max(1, min(across, down, LARGEST))


class BlockWidget(Widget, inherit_bindings=False, can_focus=False):
    """A widget that draws rows of cell codes (`core.tetris.picture`) in the colours of a palette."""

    COMPONENT_CLASSES: ClassVar[set[str]] = component_classes()
    DEFAULT_CSS: ClassVar[str] = style_sheet("BlockWidget")
    ALLOW_SELECT: ClassVar[bool] = False
    STRIPED: ClassVar[bool] = True
    """Whether every other column has a slightly different background."""

    def __init__(
        self, *, palette: Palette = STANDARD, id: str | None = None, classes: str | None = None
    ) -> None:
        super().__init__(id=id, classes=classes)
        self._palette = palette
        self._strips: LRUCache[tuple[bytes, int, bool], Strip] = LRUCache(2048)
        self._looks: dict[int, tuple[str, Style]] = {}
        self.add_class(f"-{palette.name}")

    @property
    def palette(self) -> Palette:
        """Colours and textures in use; may be changed at any time."""
        return self._palette

    @palette.setter
    def palette(self, palette: Palette) -> None:
        self.remove_class(*(f"-{name}" for name in PALETTES))
        self._palette = palette
        self.add_class(f"-{palette.name}")
        self.notify_style_update()
        self.refresh()

    def notify_style_update(self) -> None:
        """Forget what was drawn in the old style."""
        self._strips.clear()
        self._looks.clear()
        super().notify_style_update()

    def strip(self, codes: bytes, lines: int = 1, *, last: bool = True) -> Strip:
        """Return one line of a row of blocks, drawn once and kept.

        Args:
            codes: of the row's cells.
            lines: how many lines high a block is; it is twice as many columns wide.
            last: whether this is the lowest line of the row.
        """
        key = (codes, lines, last)
        strip = self._strips.get(key)
        if strip is None:
            width = len(codes) * CELLS_PER_BLOCK * lines
            strip = self._strips[key] = Strip(self._segments(codes, lines, last), width).simplify()
        return strip

    def _segments(self, codes: bytes, lines: int, last: bool) -> Iterator[Segment]:
        # An empty cell's look depends on its column.
        keyed = [
            -1 - (column % 2 if self.STRIPED else 0) if code == EMPTY else code
            for column, code in enumerate(codes)
        ]
        for key, run in groupby(keyed):
            text, style = self._look(key)
            yield Segment(enlarged(text, lines, last=last) * len(list(run)), style)

    def _look(self, key: int) -> tuple[str, Style]:
        look = self._looks.get(key)
        if look is None:
            name, text = self._component(key)
            look = self._looks[key] = (text, self.get_component_rich_style(f"block--{name}"))
        return look

    def _component(self, key: int) -> tuple[str, str]:
        """Return the style's name (without its prefix) and the two characters for a code."""
        if key < 0:
            return ("empty", "stripe")[-1 - key], "  "
        if key & MARKED_GOOD:
            return ("bad", "--") if key & MARKED_BAD == MARKED_BAD else ("good", "++")
        block = (key & 15) - 1
        texture = self._palette.textures[block]
        if key & CLEARED:
            return "cleared", texture
        if key & FALLING:
            return f"{BLOCKS[block]}-falling", texture
        if key & GHOST:
            return f"{BLOCKS[block]}-ghost", GHOST_TEXTURE
        return BLOCKS[block], texture


def enlarged(texture: str, lines: int, *, last: bool) -> str:
    """Return a block's texture on one of its lines.

    Args:
        texture: two characters, as on a block of one line.
        lines: how many lines high the block is.
        last: whether this is its lowest line.
    """
    left, right = texture[0], texture[1]
    if lines == 1 or left == right:
        return texture * lines
    middle = CELLS_PER_BLOCK * lines - 2
    if texture == SEAM:
        return (SEAM_BELOW if last else left) * (middle + 1) + right
    return left + " " * middle + right
