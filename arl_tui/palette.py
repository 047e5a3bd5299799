"""Colours and textures of Tetris pieces: data, and the style sheet that follows from it.

Widgets that draw blocks take their colours from component classes (`block--i`, `block--i-falling`, ...), so a
theme or a style sheet may overrule any of them. Three of the palettes do not rely on colour alone: each piece
has a texture of its own, and mirrored pieces have mirrored textures.
"""

from collections.abc import Iterator
from dataclasses import dataclass, replace

from rich.color import ColorSystem
from textual.color import Color

BLOCKS: tuple[str, ...] = ("i", "o", "t", "z", "s", "j", "l", "unknown")
"""Names of block colours: by piece id, and last what nobody knows the piece of."""

SEAM = " ▕"
"""A line at the right side of each block, which lets the eye count them."""
SEAM_BELOW = "▁"
"""The same along the lower side of a block that is higher than a line."""
TEXTURES: tuple[str, ...] = ("==", "[]", "++", "\\\\", "//", "<<", ">>", "..")
"""Two characters per block, in ASCII so that every font has them."""


MARKS = {"good": "#1f7a4d", "bad": "#b3372f"}
"""Background of what a press was taken for: the colours of the words GOOD and BAD."""


@dataclass(frozen=True, slots=True)
class Palette:
    """How blocks look."""

    name: str
    title: str
    """As offered to the participant."""
    colours: tuple[str, ...]
    """Background of a falling piece's blocks, in the order of BLOCKS."""
    textures: tuple[str, ...]
    """What is written on a block, two cells each, in the order of BLOCKS."""
    empty: str = "#14161c"
    stripe: str = "#1a1d25"
    """Background of every other column, which helps the eye to see where a piece will land."""
    settled: float = 0.14
    """How much darker a block is once it has settled, in [0, 1]."""
    ink: float = 0.6
    """How far the texture stands out from the block, in [0, 1]."""
    cleared: tuple[str, str] = ("#ffffff", "#000000")
    """Background and ink of a row that is about to disappear."""

    def __post_init__(self) -> None:
        if len(self.colours) != len(BLOCKS) or len(self.textures) != len(BLOCKS):
            raise ValueError(
                f"palette {self.name!r} needs {len(BLOCKS)} colours and textures ({', '.join(BLOCKS)}), "
                f"got {len(self.colours)} and {len(self.textures)}"
            )


STANDARD = Palette(
    name="standard",
    title="Standard",
    colours=("#41c7d9", "#f0c94d", "#ab6fdc", "#e35d55", "#68bd5e", "#5180e0", "#ec9343", "#8b93a5"),
    textures=(SEAM,) * 8,
    ink=0.25,
)

COLOUR_BLIND = Palette(
    name="colour-blind",
    title="Colour-blind safe, with textures",
    # Okabe & Ito 2002, "Color Universal Design"; grey for the unknown.
    colours=("#56b4e9", "#f0e442", "#cc79a7", "#d55e00", "#009e73", "#0072b2", "#e69f00", "#999999"),
    textures=TEXTURES,
    settled=0.08,
)

HIGH_CONTRAST = Palette(
    name="high-contrast",
    title="Black and white, with textures",
    colours=("#ffffff",) * 7 + ("#a0a0a0",),
    textures=TEXTURES,
    empty="#000000",
    stripe="#000000",
    settled=0.25,
)

SIXTEEN = Palette(
    name="sixteen",
    title="For terminals with sixteen colours",
    # The terminal's own bright cyan, yellow, magenta, red, green, blue, white, and grey.
    colours=("#00ffff", "#ffff00", "#ff00ff", "#ff0000", "#00ff00", "#0000ff", "#ffffff", "#808080"),
    textures=TEXTURES,
    empty="#000000",
    stripe="#000000",
    settled=0.0,
    ink=1.0,
)

_LIGHT_BOARD = {"empty": "#f7f8fa", "stripe": "#eceef2", "cleared": ("#20232b", "#ffffff")}
LIGHT: dict[str, Palette] = {
    "standard": replace(
        STANDARD,
        name="standard-light",
        # As the standard ones, and darker: each stands out from the empty board by 3 to 1.
        colours=("#1fa0b5", "#cf9f10", "#9650cf", "#d8403a", "#3f9c38", "#3468d6", "#d9741a", "#78808f"),
        **_LIGHT_BOARD,  # type: ignore[arg-type] # each value is of its field's type
    ),
    "colour-blind": replace(
        COLOUR_BLIND,
        name="colour-blind-light",
        # Okabe & Ito's hues, as dark as a light board needs.
        colours=("#2186bf", "#8f8400", "#b45488", "#c95500", "#008a65", "#0067a5", "#a87200", "#777777"),
        ink=0.8,
        **_LIGHT_BOARD,  # type: ignore[arg-type]
    ),
}
"""What a light theme shows in place of a palette for dark ones; the others do for any theme."""

CHOICES: tuple[Palette, ...] = (STANDARD, COLOUR_BLIND, HIGH_CONTRAST, SIXTEEN)
"""What a protocol can choose."""
PALETTES: dict[str, Palette] = {palette.name: palette for palette in (*CHOICES, *LIGHT.values())}


def palette_for(
    wanted: str, system: ColorSystem | str | None, *, no_color: bool = False, theme: str = "dark"
) -> Palette:
    """Return the palette called `wanted`, or what a poorer terminal can show of it.

    Args:
        wanted: name of one of CHOICES.
        system: the console's colour system (`App.console.color_system`): "truecolor", "256", "standard",
            None.
        no_color: the participant has asked for no colours (`App.no_color`, from the environment variable
            NO_COLOR).
        theme: of the pages around the game (`arl_tui.themes`).

    Raises:
        ValueError: there is no such palette.
    """
    if wanted not in (names := [palette.name for palette in CHOICES]):
        raise ValueError(f"there is no palette {wanted!r}: choose one of {', '.join(names)}")
    if system is None or no_color or (theme == "high-contrast" and wanted == "standard"):
        return HIGH_CONTRAST
    if (
        system in ("standard", "windows", ColorSystem.STANDARD, ColorSystem.WINDOWS)
        and wanted != "high-contrast"
    ):
        return SIXTEEN
    if theme == "light" and wanted in LIGHT:
        return LIGHT[wanted]
    return PALETTES[wanted]


def component_classes() -> set[str]:
    """Return the names of all styles of blocks."""
    roles = ("", "-falling", "-ghost")
    return {f"block--{block}{role}" for block in BLOCKS for role in roles} | {
        "block--empty",
        "block--stripe",
        "block--cleared",
        "block--good",
        "block--bad",
    }


def style_sheet(widget: str) -> str:
    """Return the style rules of every palette for widgets of this type; the widget's class `-NAME`
    chooses.
    """
    return "\n".join(rule for palette in PALETTES.values() for rule in _rules(widget, palette))


def _rules(widget: str, palette: Palette) -> Iterator[str]:
    yield f"{widget}.-{palette.name} {{ background: {palette.empty}; }}"
    start = f"{widget}.-{palette.name} > .block--"
    yield f"{start}empty {{ background: {palette.empty}; color: {_grey(palette)}; }}"
    yield f"{start}stripe {{ background: {palette.stripe}; color: {_grey(palette)}; }}"
    paper, ink = palette.cleared
    yield f"{start}cleared {{ background: {paper}; color: {ink}; text-style: bold; }}"
    plain = palette.name == "high-contrast"
    for mark, colour_of in MARKS.items():
        paper = "#000000" if plain else colour_of
        yield f"{start}{mark} {{ background: {paper}; color: #ffffff; text-style: bold; }}"
    for block, text in zip(BLOCKS, palette.colours, strict=True):
        colour = Color.parse(text)
        settled = colour.blend(Color.parse("#000000"), palette.settled)
        yield f"{start}{block} {{ background: {settled.hex}; color: {_ink(settled, palette.ink)}; }}"
        yield (
            f"{start}{block}-falling {{ background: {text}; color: {_ink(colour, palette.ink)}; text-style: "
            f"bold; }}"
        )
        ghost = colour.blend(Color.parse(palette.empty), 0.15)
        yield f"{start}{block}-ghost {{ background: {palette.empty}; color: {ghost.hex}; }}"


def _ink(background: Color, fraction: float) -> str:
    """Return the colour of the texture on a block: the background, this far on the way to black or white."""
    black, white = Color.parse("#000000"), Color.parse("#ffffff")
    return background.blend(white if background.brightness < 0.35 else black, fraction).hex


def _grey(palette: Palette) -> str:
    empty = Color.parse(palette.empty)
    return empty.blend(Color.parse("#ffffff" if empty.brightness < 0.5 else "#000000"), 0.2).hex
