"""What all apps have in common: no palette of commands, no selection, no animation, and a size that is always right."""

import os
import sys
from typing import TypeVar

from textual import events
from textual.app import App
from textual.driver import Driver

Result = TypeVar("Result")


class PlainApp(App[Result], inherit_bindings=False):
    """An app that shows what it is told to, and hears of every change of the window's size."""

    ENABLE_COMMAND_PALETTE = False
    ALLOW_SELECT = False
    AUTO_FOCUS = None

    def __init__(self, driver_class: type[Driver] | None = None) -> None:
        """Prepare; `driver_class` is Textual's own choice by default."""
        trust_the_terminal()
        super().__init__(driver_class=driver_class)
        self.animation_level = "none"

    def on_resize(self, event: events.Resize) -> None:
        """Tell the screen of its size.

        Textual does so itself, by a timer of 8 ms that never rings on a machine that is busy at the wrong moment (see
        `arl_tui.once`); then this change of size and all later ones would be missed.
        """
        self.call_later(self._tell_size)

    def _tell_size(self) -> None:
        if self.screen_stack:
            self.screen.post_message(events.Resize(self.size, self.size))


def trust_the_terminal() -> None:
    """Forget COLUMNS and LINES where the terminal itself tells its size.

    Textual asks `shutil.get_terminal_size`, which believes these variables before any terminal: exported, as some
    shells and multiplexers leave them, they hold for ever, and no change of the window is ever heard of. Where
    the terminal does not know its size (a serial line says 0 x 0) they are the only way to tell it, and stay.
    """
    try:
        size = os.get_terminal_size(sys.__stdout__.fileno() if sys.__stdout__ else -1)
    except (OSError, ValueError):
        return
    if min(size) > 0:
        for name in ("COLUMNS", "LINES"):
            os.environ.pop(name, None)
