"""What all apps have in common: no palette of commands, no selection, no animation, and a size that is always right."""

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
