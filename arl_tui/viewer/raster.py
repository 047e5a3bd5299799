"""A screen of characters as a picture of dots, as PNG files and films need it."""

import functools
from collections.abc import Sequence
from pathlib import Path
from typing import Final

from PIL import Image, ImageDraw, ImageFont
from rich.color import Color
from rich.style import Style
from rich.terminal_theme import DIMMED_MONOKAI
from textual.strip import Strip

CELL: Final = (9, 18)
"""Width and height of a character in dots."""
FONT_SIZE: Final = 15
RGB = tuple[int, int, int]
Cell = tuple[str, RGB, RGB, bool]
"""A character, its colour, the colour behind it, and whether it is bold."""
Cells = list[list[Cell]]
_LIGHT, _DARK = (224, 224, 224), (18, 18, 18)


def cells_of(strips: Sequence[Strip]) -> Cells:
    """Return the characters of a screen, line by line."""
    lines: Cells = []
    for strip in strips:
        line: list[Cell] = []
        for segment in strip:
            if segment.control:
                continue
            front, back, bold = _look(segment.style)
            line += [(letter, front, back, bold) for letter in segment.text]
        lines.append(line)
    return lines


@functools.lru_cache(maxsize=4096)
def _look(style: Style | None) -> tuple[RGB, RGB, bool]:
    if style is None:
        return _LIGHT, _DARK, False
    front = _rgb(style.color, _LIGHT, foreground=True)
    back = _rgb(style.bgcolor, _DARK, foreground=False)
    if style.reverse:
        front, back = back, front
    if style.dim:
        front = tuple((a + b) // 2 for a, b in zip(front, back, strict=True))  # type: ignore[assignment]
    return front, back, bool(style.bold)


def _rgb(colour: Color | None, otherwise: RGB, *, foreground: bool) -> RGB:
    if colour is None or colour.is_default:
        return otherwise
    red, green, blue = colour.get_truecolor(DIMMED_MONOKAI, foreground=foreground)
    return red, green, blue


def picture_of(cells: Cells) -> Image.Image:
    """Return a screen as an RGB image."""
    columns = max((len(line) for line in cells), default=0)
    image = Image.new("RGB", (columns * CELL[0], len(cells) * CELL[1]), _DARK)
    for y, line in enumerate(cells):
        for x, cell in enumerate(line):
            image.paste(_cell_image(*cell), (x * CELL[0], y * CELL[1]))
    return image


@functools.lru_cache(maxsize=16384)
def _cell_image(letter: str, front: RGB, back: RGB, bold: bool) -> Image.Image:
    image = Image.new("RGB", CELL, back)
    if letter == " ":
        return image
    draw = ImageDraw.Draw(image)
    code = ord(letter)
    if 0x2580 <= code <= 0x259F:
        _draw_block(draw, code, front, back)
    elif 0x2800 <= code <= 0x28FF:
        _draw_braille(draw, code - 0x2800, front)
    else:
        draw.text((0, 0), letter, font=_font(bold), fill=front)
    return image


@functools.lru_cache(maxsize=2)
def _font(bold: bool) -> ImageFont.FreeTypeFont:
    # DejaVu comes with matplotlib: pictures look the same on every machine.
    import matplotlib

    name = "DejaVuSansMono-Bold.ttf" if bold else "DejaVuSansMono.ttf"
    return ImageFont.truetype(str(Path(matplotlib.get_data_path(), "fonts", "ttf", name)), FONT_SIZE)


_QUADRANTS: Final = {
    0x2596: 4, 0x2597: 8, 0x2598: 1, 0x2599: 13, 0x259A: 9, 0x259B: 7, 0x259C: 11, 0x259D: 2, 0x259E: 6, 0x259F: 14,  # noqa: E501
}  # fmt: skip
"""Of block characters made of quarters: bits of the upper left, upper right, lower left and lower right
one."""


def _draw_block(draw: ImageDraw.ImageDraw, code: int, front: RGB, back: RGB) -> None:
    """Draw blocks so that neighbours touch, which a font's do not."""
    width, height = CELL
    if code in _QUADRANTS:
        for place in range(4):
            if _QUADRANTS[code] >> place & 1:
                x, y = place % 2 * (width // 2), place // 2 * (height // 2)
                draw.rectangle((x, y, x + width // 2, y + height // 2 - 1), fill=front)
        return
    if 0x2591 <= code <= 0x2593:
        fraction = (code - 0x2590) / 4
        mixed = tuple(round(b + (f - b) * fraction) for f, b in zip(front, back, strict=True))
        draw.rectangle((0, 0, width, height), fill=mixed)
        return
    box = {0x2580: (0, 0, width, height // 2 - 1), 0x2588: (0, 0, width, height)}.get(code)
    if box is None:
        if 0x2581 <= code <= 0x2587:
            box = (0, height - round((code - 0x2580) / 8 * height), width, height)
        elif 0x2589 <= code <= 0x258F:
            box = (0, 0, max(0, round((0x2590 - code) / 8 * width) - 1), height)
        else:
            box = {
                0x2590: (width // 2, 0, width, height),
                0x2594: (0, 0, width, height // 8),
                0x2595: (width - 1, 0, width, height),
            }[code]
    draw.rectangle(box, fill=front)


def _draw_braille(draw: ImageDraw.ImageDraw, bits: int, front: RGB) -> None:
    for bit, (column, row) in enumerate(((0, 0), (0, 1), (0, 2), (1, 0), (1, 1), (1, 2), (0, 3), (1, 3))):
        if bits >> bit & 1:
            x, y = 1 + column * CELL[0] // 2, 1 + row * CELL[1] // 4
            draw.rectangle((x, y, x + 2, y + 2), fill=front)
