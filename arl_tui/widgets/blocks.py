"""What the board and the next piece have in common: blocks of two cells, drawn a row at a time."""

from collections.abc import Iterator
from itertools import groupby
from typing import ClassVar

from rich.segment import Segment
from rich.style import Style
from textual.cache import LRUCache
from textual.strip import Strip
from textual.widget import Widget

from arl_tui.palette import BLOCKS, PALETTES, STANDARD, Palette, component_classes, style_sheet
from core.tetris.picture import CLEARED, EMPTY, FALLING, GHOST

CELLS_PER_BLOCK = 2
GHOST_TEXTURE = "░░"
MARKED_GOOD, MARKED_BAD = 128, 192
"""High bits of a marked block's code (`core.tetris.picture` leaves 128 free)."""


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
        self._strips: LRUCache[bytes, Strip] = LRUCache(2048)
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

    def strip(self, codes: bytes) -> Strip:
        """Return one row of blocks: two cells per code, drawn once and kept."""
        strip = self._strips.get(codes)
        if strip is None:
            strip = Strip(self._segments(codes), len(codes) * CELLS_PER_BLOCK).simplify()
            self._strips[codes] = strip
        return strip

    def _segments(self, codes: bytes) -> Iterator[Segment]:
        # An empty cell's look depends on its column.
        keyed = [
            -1 - (column % 2 if self.STRIPED else 0) if code == EMPTY else code
            for column, code in enumerate(codes)
        ]
        for key, run in groupby(keyed):
            text, style = self._look(key)
            yield Segment(text * len(list(run)), style)

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
