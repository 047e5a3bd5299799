"""Compiling in a process of its own, while the game has begun already: on the second core, and with low
priority.

The process ends with the program that started it: it watches its standard input. What it has compiled by
then is kept.
"""

import os
import subprocess
import sys
import threading

import msgspec

from arl_tui.app.compile_order import Order, is_compiled, purpose_of
from core.keepaway.pitch import KeepawayConfig
from core.session.protocol_reading import protocol_from

MODULE = "arl_tui.ahead"
NICENESS = 5
"""Lower priority than the game's."""


class Ahead:
    """A process that compiles what an order says."""

    def __init__(self, order: Order) -> None:
        self._process = subprocess.Popen(
            [sys.executable, "-m", MODULE],
            stdin=subprocess.PIPE,
            stdout=subprocess.DEVNULL,
            # The terminal's Ctrl+C is for the programs that draw and record.
            start_new_session=True,
        )
        assert self._process.stdin is not None, "it was asked for"
        self._process.stdin.write(msgspec.json.encode(order) + b"\n")
        self._process.stdin.flush()

    @property
    def finished(self) -> bool:
        """Whether it has ended: everything is compiled, or it failed (then programs compile what they
        need).
        """
        return self._process.poll() is not None

    @property
    def failed(self) -> bool:
        """Whether it has ended without having compiled everything."""
        return self._process.poll() not in (None, 0)

    def wait(self) -> None:
        """Wait until it has ended."""
        self._process.wait()

    def close(self) -> None:
        """End it; what it has compiled is kept."""
        assert self._process.stdin is not None, "it was asked for"
        self._process.stdin.close()
        self._process.terminate()


def fill(order: Order, *, noted: bool = True) -> None:
    """Compile or load everything that an order asks for, in the order of need.

    Args:
        order: what is needed.
        noted: write down that it is there.
    """
    from core.numerics.interpreting import note_ready

    if order.protocol is not None:
        from arl_tui.warm_up import warm_up  # compiled code comes with it

        warm_up(protocol_from(order.protocol))
    if order.task is not None:
        warm_up_match(order.task)
    if noted and not is_compiled(order):
        note_ready(purpose_of(order))


def warm_up_match(task: KeepawayConfig) -> None:
    """Play a match that is watched until a keeper has decided, and set up the next episode."""
    from core.keepaway.viewed_match import ViewedMatch

    match = ViewedMatch(task, "hand", 0)
    for _ in range(100):
        if match.step().decider >= 0:
            break
    match.next_episode()


def main() -> None:
    """Read an order from the standard input, and compile it unless the program that ordered it ends."""
    if hasattr(os, "nice"):
        os.nice(NICENESS)
    order = msgspec.json.decode(sys.stdin.buffer.readline(), type=Order)
    threading.Thread(target=_leave_with_the_starter, daemon=True).start()
    fill(order)


def _leave_with_the_starter() -> None:
    # Not `sys.stdin`: its lock, held by a thread that waits, ends Python with an error.
    while os.read(0, 1024):
        pass
    os._exit(1)


if __name__ == "__main__":
    main()
