"""What all apps have in common: no palette of commands, no selection, no animation, and a size that is always right."""

import os
import sys
from typing import TypeVar

from textual import events
from textual.app import App
from textual.driver import Driver

from core.layouts import KeyReader, alphabet_of

Result = TypeVar("Result")

UNSURE = ("slash", "semicolon")
"""What the key of q sends under Hebrew and Greek: it may also be meant as it stands."""


class PlainApp(App[Result], inherit_bindings=False):
    """An app that shows what it is told to, and hears of every change of the window's size."""

    ENABLE_COMMAND_PALETTE = False
    ALLOW_SELECT = False
    AUTO_FOCUS = None

    def __init__(self, driver_class: type[Driver] | None = None) -> None:
        """Prepare; `driver_class` is Textual's own choice by default."""
        trust_the_terminal()
        self.reader = KeyReader(language())
        """Finds the Latin letter on a key where the keyboard is set to another alphabet."""
        self._foreign_keys = 0
        super().__init__(driver_class=driver_class)
        self.animation_level = "none"

    async def on_event(self, event: events.Event) -> None:
        """Let a key of another alphabet do what the Latin letter on the same key does."""
        if isinstance(event, events.Key) and not event.is_forwarded:
            self._read_in_latin(event)
        await super().on_event(event)

    def _read_in_latin(self, event: events.Key) -> None:
        raw = event.key
        reading = self.reader.read(raw)
        if reading is not None:
            event.key = event.character = reading.letter
            self._foreign_keys = 0
            return
        alphabet = alphabet_of(event.character or "")
        self._foreign_keys = self._foreign_keys + 1 if alphabet or raw in UNSURE else 0
        if alphabet or self._foreign_keys == 2:
            self.tell_foreign_key(alphabet)

    def tell_foreign_key(self, alphabet: str) -> None:
        """Say that keys of this alphabet ("" where it is not known) mean nothing here; apps may say it elsewhere."""
        self.notify(foreign_words(alphabet), title="Keyboard", severity="warning", timeout=8.0)

    def on_resize(self, event: events.Resize) -> None:
        """Tell the screen of its size.

        Textual does so itself, by a timer of 8 ms that never rings on a machine that is busy at the wrong moment (see
        `arl_tui.once`); then this change of size and all later ones would be missed.
        """
        self.call_later(self._tell_size)

    def _tell_size(self) -> None:
        if self.screen_stack:
            self.screen.post_message(events.Resize(self.size, self.size))


def language() -> str:
    """Return the language of this environment by ISO 639, as "bg"; "" where it is not said."""
    named = next((value for name in ("LC_ALL", "LC_CTYPE", "LANG") if (value := os.environ.get(name))), "")
    return (
        "" if named.startswith(("C.", "POSIX")) or named == "C" else named.partition("_")[0].partition(".")[0]
    )


def foreign_words(alphabet: str) -> str:
    """Return what to do about a keyboard that is set to this alphabet; "" where it is not known."""
    letters = f"{alphabet} letters" if alphabet else "other letters"
    return f"Is your keyboard set to {letters}? Change it to English (Latin) letters"


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
