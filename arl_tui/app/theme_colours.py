"""Colours of all pages in each theme: data."""

from collections.abc import Mapping
from typing import Final

from textual.theme import Theme

THEMES: Final[Mapping[str, Theme]] = {
    "dark": Theme(
        name="arl-dark",
        primary="#0178D4",
        secondary="#004578",
        accent="#ffa62b",
        warning="#ffa62b",
        error="#ba3c5b",
        success="#4EBF71",
        foreground="#e0e0e0",
        dark=True,
    ),
    "light": Theme(
        name="arl-light",
        primary="#004578",
        secondary="#0178D4",
        accent="#8a4b00",
        warning="#8a4b00",
        error="#9c1c3c",
        success="#146c3a",
        foreground="#1c1f26",
        background="#f1f2f4",
        surface="#fbfbfc",
        panel="#e6e8eb",
        dark=False,
    ),
    "high-contrast": Theme(
        name="arl-high-contrast",
        primary="#ffffff",
        secondary="#ffffff",
        accent="#ffff00",
        warning="#ffff00",
        error="#ff9c9c",
        success="#9cff9c",
        foreground="#ffffff",
        background="#000000",
        surface="#000000",
        panel="#000000",
        dark=True,
        text_alpha=1.0,
    ),
}
"""The accent of a light theme is dark: words are written in it."""
