"""What all apps have in common: no palette of commands, no selection, no animation, and a size that is always
right.

They also end in the same way when the terminal goes away or a signal asks for it.
"""

import asyncio
import contextvars
import os
import signal
import sys
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from typing import Any, ClassVar, NoReturn, TypeVar

import click
from textual import events
from textual.app import App
from textual.binding import BindingType
from textual.driver import Driver

from arl_tui.app.driver import own_driver
from arl_tui.app.foreign_keys import ForeignKeys, language_of_environment
from arl_tui.app.key_help import HELP, KeyHelp
from arl_tui.app.terminal_guard import QUIET, TerminalGuard
from arl_tui.app.theme_colours import THEMES
from arl_tui.language import tr, use
from arl_tui.own_keys import keymap
from arl_tui.themes import theme_in_use
from core.feedback.layouts import KeyReader

Result = TypeVar("Result")
ENDING_SIGNALS = ("SIGHUP", "SIGINT", "SIGTERM")
"""Signals that ask an app to end; the terminal sends SIGHUP when it closes."""


class PlainApp(App[Result], inherit_bindings=False):
    """An app that shows what it is told to, and hears of every change of the window's size."""

    BINDINGS: ClassVar[list[BindingType]] = [HELP]
    ENABLE_COMMAND_PALETTE = False
    ALLOW_SELECT = False
    AUTO_FOCUS = None

    def __init__(
        self, driver_class: type[Driver] | None = None, *, theme: str = "dark", language: str = "en"
    ) -> None:
        """Prepare.

        Args:
            driver_class: that of all apps by default.
            theme: of the pages (`arl_tui.themes`), unless the environment names another.
            language: of all words that this app shows (`arl_tui.language.LANGUAGES`).
        """
        trust_the_terminal()
        use(language)
        no_color = os.environ.get("NO_COLOR")
        self.reader = KeyReader(language_of_environment())
        """Finds the Latin letter on a key where the keyboard is set to another alphabet."""
        self._foreign_keys = ForeignKeys()
        super().__init__(driver_class=driver_class or own_driver())
        self.set_keymap(keymap())
        if no_color is not None:
            os.environ["NO_COLOR"] = no_color  # Textual takes it away, and a study's next app needs it
        for each in THEMES.values():
            self.register_theme(each)
        self.theme_name = theme_in_use(theme)
        """Which theme is in use: a key of `arl_tui.themes.THEMES`."""
        self.theme = THEMES[self.theme_name].name
        self.animation_level = "none"
        self.ended_by: signal.Signals | None = None
        """The signal that has ended this app; SIGHUP also where the terminal was found to be gone."""
        self._guard = TerminalGuard()
        self._event_loop: asyncio.AbstractEventLoop | None = None
        self._own_context = contextvars.copy_context()
        self.before_leaving: Callable[[], None] = lambda: None
        """Called before the process ends because the terminal is gone: the last chance to write something."""

    # --- life and its end -----------------------------------------------------------------------------------

    def run_in_terminal(self) -> Result | None:
        """Run in this terminal; however that ends, the terminal is left as it was found.

        Returns:
            The app's result; None also where a signal has ended it (`ended_by`).
        """
        with self._guard, self._signals_taken():
            result = self.run(mouse=False)
            if getattr(self._driver, "gone", False):
                # A thread may be blocked in a write for ever, which Python would wait for.
                self.leave_at_once()
        return result

    def stop_if_it_failed(self) -> None:
        """Stop the command where the app ended by a fault of its own, which is printed already.

        Raises:
            click.ClickException: it did.
        """
        if self.return_code == 1:
            raise click.ClickException("the program ended by a fault of its own; see the message above")

    @contextmanager
    def _signals_taken(self) -> Iterator[None]:
        before = {}
        for name in ENDING_SIGNALS:
            if (number := getattr(signal, name, None)) is not None:
                before[number] = signal.signal(number, self._on_signal)
        try:
            yield
        finally:
            for number, handler in before.items():
                signal.signal(number, handler)

    def _on_signal(self, number: int, _frame: object) -> None:
        # Python runs this between two instructions of the main thread, also while that waits for the
        # terminal.
        driver: Any = self._driver
        if getattr(signal, "SIGHUP", None) == number and hasattr(driver, "gone"):
            driver.gone = True
        if self.ended_by is None:
            self.ended_by = signal.Signals(number)
            if hasattr(driver, "end_soon"):
                driver.end_soon()
            self.soon(self.end_by_signal, self.ended_by)

    def soon(self, callback: Callable[..., object], *arguments: object) -> None:
        """Call back in the app's event loop as soon as possible: from any thread, or from a signal handler.

        What is called knows its app. Textual keeps the app in a context variable; other threads have none,
        and a page that is opened without one ends the app with an error.
        """
        loop = self._event_loop
        if loop is not None and not loop.is_closed():
            loop.call_soon_threadsafe(callback, *arguments, context=self._own_context.copy())

    def terminal_gone(self) -> None:
        """Act on a terminal that can no longer be read, or no longer be written to."""
        self._on_signal(signal.SIGHUP, None)

    def on_mount(self) -> None:
        """Act on a signal that came before the app ran."""
        self._event_loop, self._own_context = asyncio.get_running_loop(), contextvars.copy_context()
        if self.ended_by is not None:
            self.call_later(self.end_by_signal, self.ended_by)

    def end_by_signal(self, number: signal.Signals) -> None:
        """End, because a signal asks for it or the terminal is gone. An app that has to save something does
        so first.
        """
        if number == getattr(signal, "SIGHUP", None):
            self.leave_at_once()
        self.exit(return_code=128 + number)

    def leave_at_once(self) -> NoReturn:
        """End this process now; the guard restores what there is of the terminal."""
        try:
            self.before_leaving()
        finally:
            self._guard.tell(QUIET)
            os._exit(128 + (self.ended_by or signal.SIGTERM))

    def action_page_help(self) -> None:
        """Say what the keys of this page do."""
        if self.screen_stack and not isinstance(self.screen, KeyHelp):
            self.push_screen(KeyHelp(self.screen))

    # --- size -----------------------------------------------------------------------------------------------

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
            return
        advice = self._foreign_keys.advice(raw, read=False)
        if advice is not None:
            self.tell_about_keys(advice)

    def tell_about_keys(self, advice: str) -> None:
        """Show advice about the keyboard over the page; an app with a game may show it beside that."""
        self.notify(advice, title=tr("Keyboard"), severity="warning", timeout=8.0)

    def on_resize(self, event: events.Resize) -> None:
        """Tell the screen of its size.

        Textual does so itself, by a timer of 8 ms that never rings on a machine that is busy at the wrong
        moment (see `arl_tui.app.once`); then this change of size and all later ones would be missed.
        """
        self.call_later(self._tell_size)

    def _tell_size(self) -> None:
        if self.screen_stack:
            self.screen.post_message(events.Resize(self.size, self.size))


def trust_the_terminal() -> None:
    """Forget COLUMNS and LINES where the terminal itself tells its size.

    Textual asks `shutil.get_terminal_size`, which believes these variables before any terminal: exported, as
    some shells and multiplexers leave them, they hold for ever, and no change of the window is ever heard of.
    Where the terminal does not know its size (a serial line says 0 x 0) they are the only way to tell it, and
    stay.
    """
    try:
        size = os.get_terminal_size(sys.__stdout__.fileno() if sys.__stdout__ else -1)
    except (OSError, ValueError):
        return
    if min(size) > 0:
        for name in ("COLUMNS", "LINES"):
            os.environ.pop(name, None)
