"""Textual's driver for Linux and macOS, made to survive a terminal that misbehaves.

What it does otherwise than Textual's own (8.2):

- A terminal that goes away, at either end, ends the app; Textual's reading thread spins and its writing
  thread blocks.
- A terminal that does not take what is written cannot block the end of the app.
- SIGCONT restarts the terminal only after Textual itself has stopped it. The kernel sends SIGHUP and SIGCONT
  when a terminal closes, and SIGCONT alone after a stop from outside; a restart then starts a second reader
  and forgets how the terminal was before the app.
- Bytes that are not UTF-8 are read as U+FFFD, a key without a meaning, instead of ending the app.
- The mouse is not asked for: nothing here uses it, and its reports are the commonest bytes that are not
  UTF-8.

Import this module only where Textual's Linux driver can be imported.
"""

import asyncio
import contextlib
import os
import select
import selectors
import termios
import tty
from codecs import getincrementaldecoder
from collections.abc import Callable, Iterable
from queue import Full
from typing import Any

from textual import constants, events
from textual._xterm_parser import XTermParser
from textual.drivers.linux_driver import LinuxDriver
from textual.message import Message

from core.numerics.clock import NS_PER_S, MonotonicClock

LOOK_S = 0.1
"""How often a blocked write and an idle reader look around, seconds."""
LAST_WRITES_S = 0.5
"""For so long a terminal may keep an app waiting that is to end, seconds."""
UNREADABLE = "unreadable-input"
"""Name of a key for input that Textual's parser cannot take in."""


class SteadyFile:
    """A text file that reports when nothing can be written to it any more, instead of failing."""

    def __init__(self, file: Any, on_gone: Callable[[], None]) -> None:
        self._file = file
        self._on_gone = on_gone

    def write(self, text: str) -> int:
        """Write `text`, or report that the terminal is gone."""
        try:
            return int(self._file.write(text))
        except (OSError, ValueError):
            self._on_gone()
            return len(text)

    def flush(self) -> None:
        """Flush, or report that the terminal is gone."""
        try:
            self._file.flush()
        except (OSError, ValueError):
            self._on_gone()

    def __getattr__(self, name: str) -> Any:
        return getattr(self._file, name)


class SteadyDriver(LinuxDriver):
    """See the module. `on_gone` is called once, in the event loop, when the terminal has gone away."""

    def __init__(
        self, app: Any, *, debug: bool = False, mouse: bool = True, size: tuple[int, int] | None = None
    ) -> None:
        """Take over the terminal; `mouse` is ignored.

        Args:
            app: whose `terminal_gone` method is called when the terminal has gone away.
            debug: Textual's own.
            mouse: of Textual's signature.
            size: of the terminal; None asks it.
        """
        super().__init__(app, debug=debug, mouse=False, size=size)
        self._file: Any = SteadyFile(self._file, self.lose_terminal)
        self._clock = MonotonicClock()
        self._ending = False
        self._event_loop: asyncio.AbstractEventLoop | None = None
        self.gone = False
        """Whether the terminal is known to be away: nothing more is written."""

    # --- the end --------------------------------------------------------------------------------------------

    def lose_terminal(self) -> None:
        """Note that the terminal has gone away. In any thread, or in a signal handler."""
        if not self.gone:
            self.gone = True
            self._in_loop(self._app.terminal_gone)  # type: ignore[attr-defined]

    def end_soon(self) -> None:
        """Note that the app is to end: no write waits for long from now on. Also in a signal handler."""
        self._ending = True

    def _give_up_after(self, began_ns: int) -> None:
        """Take a terminal that has kept the ending app waiting since `began_ns` for one that is gone."""
        if self._ending and self._clock.now_ns() - began_ns > LAST_WRITES_S * NS_PER_S:
            self.gone = True

    def _in_loop(self, callback: Callable[[], object]) -> None:
        loop = self._event_loop
        if loop is not None and not loop.is_closed():
            loop.call_soon_threadsafe(callback)

    # --- writing --------------------------------------------------------------------------------------------

    def write(self, data: str) -> None:
        """Hand text to the writing thread; drop it where the terminal is gone."""
        self._put(data)

    def _put(self, data: str | None) -> None:
        thread, began_ns = self._writer_thread, self._clock.now_ns()
        while thread is not None and not self.gone:
            try:
                return thread._queue.put(data, timeout=LOOK_S)
            except Full:
                self._give_up_after(began_ns)

    def close(self) -> None:
        """Wait for what has been written, but not for a terminal that does not take it."""
        self._put(None)
        thread, began_ns = self._writer_thread, self._clock.now_ns()
        while thread is not None and thread.is_alive() and not self.gone:
            thread.join(LOOK_S)
            self._give_up_after(began_ns)

    # --- stopping and going on ------------------------------------------------------------------------------

    def start_application_mode(self) -> None:
        """Start as Textual does, and remember the loop for what other threads have to say."""
        self._event_loop = asyncio.get_running_loop()
        super().start_application_mode()  # type: ignore[no-untyped-call]

    def _sigcont_application(self, *_: Any) -> None:
        if self._must_signal_resume:
            super()._sigcont_application()
        else:
            # This handler may have interrupted a write: do nothing here that writes.
            self._in_loop(self._assert_modes)

    def _assert_modes(self) -> None:
        """Turn everything on again: a shell may have taken the terminal while this process was stopped."""
        if self.gone or self.exit_event.is_set():
            return
        with contextlib.suppress(termios.error):
            attributes = termios.tcgetattr(self.fileno)
            attributes[tty.LFLAG] = self._patch_lflag(attributes[tty.LFLAG])
            attributes[tty.IFLAG] = self._patch_iflag(attributes[tty.IFLAG])
            termios.tcsetattr(self.fileno, termios.TCSANOW, attributes)
        self.write("\x1b[?1049h\x1b[?25l\x1b[?1004h")
        if not constants.DISABLE_KITTY_KEY:
            # Set, not pushed: the end of the app takes one entry from the terminal's stack.
            self.write("\x1b[=25u")
        self._enable_bracketed_paste()
        self._disable_line_wrap()
        self._app.refresh(repaint=True, layout=True)

    # --- reading --------------------------------------------------------------------------------------------

    def run_input_thread(self) -> None:
        """Read keys until the app or the terminal ends."""
        reader = InputReader(self.process_message, debug=self._debug)
        output = select.poll()
        # No event is asked for: that the other end has gone is reported in any case.
        output.register(self._file.fileno(), 0)
        with selectors.SelectSelector() as selector:
            selector.register(self.fileno, selectors.EVENT_READ)
            while not self.exit_event.is_set():
                ready = selector.select(LOOK_S)
                if output.poll(0):
                    return self.lose_terminal()
                if not ready:
                    reader.idle()
                    continue
                try:
                    read = os.read(self.fileno, 4096)
                except OSError:
                    read = b""
                if not read:
                    return self.lose_terminal()
                reader.take(read)


class InputReader:
    """Turns the terminal's bytes into messages, whatever they are."""

    def __init__(self, post: Callable[[Message], None], *, debug: bool = False) -> None:
        """Prepare.

        Args:
            post: takes each message.
            debug: of Textual's parser.
        """
        self._post = post
        self._debug = debug
        self._parser = XTermParser(debug)
        self._decoder = getincrementaldecoder("utf-8")(errors="replace")

    def take(self, read: bytes) -> None:
        """Take in bytes that have arrived."""
        self._feed(self._decoder.decode(read))

    def idle(self) -> None:
        """Note that nothing has arrived for a while: half a character will not become a whole one."""
        if self._decoder.getstate()[0]:
            self._feed(self._decoder.decode(b"", final=True))
        self._pass_on(self._parser.tick)

    def _feed(self, text: str) -> None:
        if text:
            self._pass_on(lambda: self._parser.feed(text))
        self._pass_on(self._parser.tick)

    def _pass_on(self, messages: Callable[[], Iterable[Message]]) -> None:
        try:
            for message in messages():
                self._post(message)
        except Exception:  # noqa: BLE001 - no input whatever may end a session
            # A parser that has failed is at its end; a new one goes on with what comes next.
            self._parser = XTermParser(self._debug)
            self._post(events.Key(UNREADABLE, None))
