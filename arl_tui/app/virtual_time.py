"""Time that passes at once: an event loop for apps that a simulated participant uses, with nobody waiting.

Where the loop would sleep, its time moves on instead. It stands still while something outside of the loop
works (`VirtualLoop.hold`): a learner takes no time on the loop's clock, as in every simulated session.
"""

import asyncio
import contextlib
import selectors
from collections.abc import Iterator

from textual import _time as textual_time

from core.numerics.clock import NS_PER_S

LOOK_S = 0.0005
"""How long the loop waits at a time, in real seconds, for what works outside of it."""


class _NeverSleeping(selectors.DefaultSelector):
    """A selector that moves the loop's time on where another would sleep."""

    now_s = 0.0
    held = 0

    def select(self, timeout: float | None = None) -> list[tuple[selectors.SelectorKey, int]]:
        """Return what is ready; let time pass where nothing is."""
        ready = super().select(0)
        if ready or (timeout is not None and timeout <= 0):
            return ready
        if timeout is None or self.held:
            return super().select(LOOK_S)
        self.now_s += timeout
        return []


class VirtualLoop(asyncio.SelectorEventLoop):
    """An event loop that never sleeps. Its time begins at 0."""

    def __init__(self) -> None:
        self._steps = _NeverSleeping()
        super().__init__(self._steps)

    def time(self) -> float:
        """Return the loop's time in seconds."""
        return self._steps.now_s

    def hold(self) -> None:
        """Let no time pass until `go_on` has been called as often. In any thread."""
        self._steps.held += 1

    def go_on(self) -> None:
        """Let time pass again. In the loop's thread."""
        self._steps.held -= 1


class LoopClock:
    """A loop's time as a clock (`core.numerics.clock.Clock`)."""

    def __init__(self, loop: VirtualLoop) -> None:
        self._loop = loop

    def now_ns(self) -> int:
        """Return the loop's time in nanoseconds, rounded to a microsecond: floats hold no more for long."""
        return round(self._loop.time() * 1e6) * (NS_PER_S // 1_000_000)


@contextlib.contextmanager
def textual_in(loop: VirtualLoop) -> Iterator[None]:
    """Let Textual's timers and messages go by the loop's time.

    Textual asks one function for the time and offers no other way to change it.
    """
    before = textual_time.get_time
    textual_time.get_time = loop.time
    try:
        yield
    finally:
        textual_time.get_time = before
