"""Which theme is in use: dark, light or high contrast (`arl_tui.app.theme_colours` has their colours)."""

import os
from collections.abc import Mapping
from typing import Final

VARIABLE = "ARL_THEME"
"""Environment variable that overrules a protocol's `[screen] theme` on one computer; `--theme` sets it."""
NAMES: Final = ("dark", "light", "high-contrast")


class ThemeError(ValueError):
    """There is no such theme."""


def theme_in_use(wanted: str = "dark", environment: Mapping[str, str] | None = None) -> str:
    """Return the theme that is shown: the environment's choice, else the protocol's.

    Args:
        wanted: `[screen] theme` of a protocol.
        environment: variables; this process's by default.

    Raises:
        ThemeError: the environment names a theme that does not exist.
    """
    chosen = (os.environ if environment is None else environment).get(VARIABLE, "") or wanted
    if chosen not in NAMES:
        raise ThemeError(f"there is no theme {chosen!r} ({VARIABLE}): choose one of {', '.join(NAMES)}")
    return chosen
