"""Colours of the pitch: data, and the style sheet that follows from it.

Who is who never depends on colour alone: keepers are called K1, K2, ..., takers T1, T2, ..., the ball is a
dot of its own, and what is going on stands in words below. The two teams' colours are a pair that people with
any colour blindness tell apart (Okabe & Ito 2002), and differ in lightness as well.
"""

from collections.abc import Iterator, Mapping
from typing import Final

from arl_tui.widgets.pitch_ink import INKS

_STANDARD: Final = {
    "grass": "#0f2419",
    "stripe": "#12291d",
    "line": "#6f8f7c",
    "spot": "#3c5a49",
    "words": "#e4ece7",
    "path": "#8fa9b8",
    "faint": "#6b7f74",
    "trail": "#c4cfc8",
    "keeper": "#56b4e9",
    "taker": "#e5702a",
    "ball": "#f6ec5f",
    "keeper-name": "#000000",
    "taker-name": "#000000",
    "holder-name": "#000000",
    "good": "#1f7a4d",
    "bad": "#b3372f",
}
_BLACK_AND_WHITE: Final = {
    **dict.fromkeys(INKS, "#ffffff"),
    "grass": "#000000",
    "stripe": "#000000",
    "spot": "#606060",
    "faint": "#a0a0a0",
    "path": "#a0a0a0",
    "keeper": "#c0c0c0",
    "taker": "#505050",
    "keeper-name": "#000000",
    "holder-name": "#000000",
    "good": "#000000",
    "bad": "#000000",
}
_SIXTEEN: Final = {
    **dict.fromkeys(INKS, "#ffffff"),
    "grass": "#000000",
    "stripe": "#000000",
    "line": "#808080",
    "spot": "#808080",
    "faint": "#808080",
    "path": "#00ff00",
    "keeper": "#00ffff",
    "taker": "#ffff00",
    "keeper-name": "#000000",
    "taker-name": "#000000",
    "holder-name": "#000000",
    "good": "#008000",
    "bad": "#800000",
}
_LIGHT: Final = {
    "grass": "#e3efe6",
    "stripe": "#dbe9df",
    "line": "#5d7a69",
    "spot": "#a3bbab",
    "words": "#14241b",
    "path": "#466070",
    "faint": "#9db0a4",
    "trail": "#55655c",
    "keeper": "#0067a8",
    "taker": "#b84600",
    "ball": "#1c1c1c",
    "keeper-name": "#ffffff",
    "taker-name": "#ffffff",
    "holder-name": "#ffffff",
    "good": "#7fd6a6",
    "bad": "#ffa59d",
}
COLOURS: Final[Mapping[str, Mapping[str, str]]] = {
    "standard": _STANDARD,
    "colour-blind": _STANDARD,
    "high-contrast": _BLACK_AND_WHITE,
    "sixteen": _SIXTEEN,
    "standard-light": _LIGHT,
    "colour-blind-light": _LIGHT,
}
"""By name of the palette (`arl_tui.palette.PALETTES`), colour by name of the ink."""


def component_classes() -> set[str]:
    """Return the names of all styles of the pitch."""
    return {f"pitch--{ink}" for ink in INKS}


def style_sheet(widget: str) -> str:
    """Return the style rules of every palette for widgets of this type; the widget's class `-NAME`
    chooses.
    """
    return "\n".join(rule for name in COLOURS for rule in _rules(widget, name))


def legend(palette: str) -> tuple[str, str]:
    """Return two lines, in markup, that say what the badges of a palette mean."""
    colours = COLOURS[palette]

    def badge(name: str, ink: str, paper: str) -> str:
        return f"[b {colours[ink]} on {colours[paper]}]{name}[/]"

    return (
        f"{badge('K1', 'keeper-name', 'keeper')} keeper   {badge('T1', 'taker-name', 'taker')} taker",
        f"{badge('K1', 'holder-name', 'words')} with the ball",
    )


def _rules(widget: str, palette: str) -> Iterator[str]:
    colours = COLOURS[palette]
    yield f"{widget}.-{palette} {{ background: {colours['grass']}; }}"
    for ink, colour in colours.items():
        bold = " text-style: bold;" if ink.endswith("name") or ink == "words" else ""
        yield f"{widget}.-{palette} > .pitch--{ink} {{ color: {colour}; background: {colour};{bold} }}"
