"""When a frame's bytes left for the terminal: a Linux driver whose output file is watched.

`App.post_display_hook` tells when a frame was *queued*; a thread of Textual's writes and flushes it 0.2 ms to
many milliseconds later. `FlushClock` stamps the flush itself. Keys need nothing of the kind: Textual stamps
`events.Key.time` in its input thread as soon as the bytes are read.

The stamp is taken right before the bytes are handed to the system, not after: the writing thread lets go of
the interpreter's lock to hand them over and gets it back only when the painting thread has done, up to 9 ms
later (measured). Only where the system kept the thread for longer than that, because nobody reads the
terminal, did the bytes leave at the end.

The only private name used here is `LinuxDriver._file`; a pty test fails if stamps stop arriving.
"""

import os
import sys
import threading
from collections import deque
from collections.abc import Callable
from typing import TYPE_CHECKING, Any

from core.numerics.clock import Clock

if TYPE_CHECKING:
    from textual.driver import Driver


STALLED_NS = 20_000_000
"""A flush that takes longer has been waiting for the terminal, not for the lock (a switch of threads takes 5
ms)."""


class FlushClock:
    """Tells at what time everything written up to a mark had been flushed.

    Three threads' worth of calls: `queued` and `mark` in the thread that paints, `written` and `flushed` in
    the thread that writes. `on_stamp` is called in either; it must only pass the news on.
    """

    def __init__(self, clock: Clock, on_stamp: Callable[[], None] = lambda: None) -> None:
        self.on_stamp = on_stamp
        self.running = False
        """True once a driver reports to this clock."""
        self._clock = clock
        self._lock = threading.Lock()
        self._n_queued = 0
        self._n_written = 0
        self._n_flushed = 0
        self._last_flush_ns = 0
        self._waiting: deque[tuple[int, int]] = deque()
        self._stamped: deque[tuple[int, int]] = deque()

    def queued(self, n_characters: int) -> None:
        """Note that so much has been handed to the writing thread."""
        self._n_queued += n_characters

    def mark(self, label: int) -> None:
        """Ask when all that has been queued so far is flushed; `label` comes back with the time."""
        with self._lock:
            if self._n_flushed >= self._n_queued:
                # The writing thread was faster than this call: the flush is over.
                self._stamped.append((label, self._last_flush_ns))
            else:
                self._waiting.append((self._n_queued, label))
                return
        self.on_stamp()

    def written(self, n_characters: int) -> None:
        """Note that so much has been written, though perhaps only to a buffer."""
        self._n_written += n_characters

    def now_ns(self) -> int:
        """Return the time, to be handed to `flushed`."""
        return self._clock.now_ns()

    def flushed(self, began_ns: int) -> None:
        """Note that all that was written has been passed to the terminal.

        Args:
            began_ns: time just before it was.
        """
        now_ns = self._clock.now_ns()
        if now_ns - began_ns <= STALLED_NS:
            now_ns = began_ns
        with self._lock:
            if self._n_written == self._n_flushed:
                return
            self._n_flushed = self._n_written
            self._last_flush_ns = now_ns
            n_before = len(self._stamped)
            while self._waiting and self._waiting[0][0] <= self._n_flushed:
                self._stamped.append((self._waiting.popleft()[1], now_ns))
            news = len(self._stamped) > n_before
        if news:
            self.on_stamp()

    def take(self) -> list[tuple[int, int]]:
        """Return the stamps that have arrived since the last call: (label, time in ns), oldest first."""
        with self._lock:
            stamps = list(self._stamped)
            self._stamped.clear()
        return stamps


class WatchedFile:
    """A text file whose writes and flushes are told to a `FlushClock`."""

    def __init__(self, file: Any, flush_clock: FlushClock) -> None:
        self._file = file
        self._flush_clock = flush_clock
        self._by_line = bool(getattr(file, "line_buffering", False))

    def write(self, text: str) -> int:
        """Write `text`; a file that flushes whole lines by itself (standard error does) has flushed it
        then.
        """
        began_ns = self._flush_clock.now_ns()
        self._flush_clock.written(len(text))
        count = int(self._file.write(text))
        if self._by_line and ("\n" in text or "\r" in text):
            self._flush_clock.flushed(began_ns)
        return count

    def flush(self) -> None:
        """Flush, and tell the clock."""
        began_ns = self._flush_clock.now_ns()
        self._file.flush()
        self._flush_clock.flushed(began_ns)

    def __getattr__(self, name: str) -> Any:
        return getattr(self._file, name)


def own_driver() -> "type[Driver] | None":
    """Return the driver of all apps; None where Textual's own choice must stand (Windows, a browser)."""
    if sys.platform == "win32" or os.environ.get("TEXTUAL_DRIVER"):
        return None
    from arl_tui.app.steady_driver import SteadyDriver

    return SteadyDriver


def stamped_driver(flush_clock: FlushClock) -> "type[Driver] | None":
    """Return a driver class that tells `flush_clock` of every flush.

    None where Textual's own choice must stand (Windows, a browser): frames are then stamped when they are
    queued.
    """
    if own_driver() is None:
        return None
    from arl_tui.app.steady_driver import SteadyDriver

    class StampedDriver(SteadyDriver):
        """The driver of all apps, with the time of every flush."""

        def __init__(self, *args: Any, **kwargs: Any) -> None:
            super().__init__(*args, **kwargs)
            self._file: Any = WatchedFile(self._file, flush_clock)
            flush_clock.running = True

        def write(self, data: str) -> None:
            flush_clock.queued(len(data))
            super().write(data)

    return StampedDriver
