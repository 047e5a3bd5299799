"""The pipe between the screen's process and the learner's, and what is said through it.

Messages are frozen records in msgpack. Inputs and outputs of the session (`core.events`) travel as they are;
the records below are those that only the two processes need, and that no recording holds.
"""

import asyncio
import contextlib
import math
import queue
import threading
from collections.abc import Callable
from multiprocessing.connection import Connection
from multiprocessing.process import BaseProcess
from typing import Protocol

import msgspec

from core.configuration.open_table import decode_open_table
from core.events import Input, Output, Record
from core.plugins import View


class Begin(Record, frozen=True, kw_only=True, tag="begin"):
    """To the worker: the participant has started the session."""


class Preparing(Record, frozen=True, kw_only=True, tag="preparing"):
    """From the worker: how far the preparation is. Several, before `Ready` or before unseen episodes."""

    compiled: int
    """Kernels that are compiled, or loaded from the cache."""
    needed: int
    """About how many the session needs, >= compiled."""
    fraction: float = 0.0
    """Fraction of the work that is done, in [0, 1]."""


class Practised(Record, frozen=True, kw_only=True, tag="practised"):
    """From the worker: how many of a block's unseen episodes have been played. Several per block."""

    done: int
    """Episodes played so far, in [0, count]."""
    count: int
    """How many the block has."""


class Ready(Record, frozen=True, kw_only=True, tag="ready"):
    """From the worker: everything has run once, and the first game can begin."""

    warm_up_ns: int
    """How long that took."""
    reach: float | None = None
    """Share of a press that reaches the step it was meant for (`core.session.reach`), in [0, 1]."""
    step_s: float = 0.0
    """Mean time on screen of a step, in seconds."""


class Picture(Record, frozen=True, kw_only=True, tag="picture"):
    """From the worker: what is to be seen now."""

    number: int
    """From 0, never skipped by the worker; the screen shows the newest it has."""
    step: int
    """Watched step that is seen; -1 between episodes."""
    view: View
    ahead: View | None = None
    """The picture after this one, where the screen may show what lies between."""
    lasts_ns: int = 0
    """How long until that one is due, on the screen's clock."""


class PressSuggested(Record, frozen=True, kw_only=True, tag="press-suggested"):
    """From the worker: a simulated participant presses a key."""

    key: str
    time_ns: int
    """When; not before the message arrives."""


class TakenFor(Record, frozen=True, kw_only=True, tag="taken-for"):
    """From the worker: what an accepted press was taken for. For the screen alone."""

    press: int
    value: float
    """What the press says: > 0 good, < 0 bad."""
    step: int
    """The step that gets the largest share of it; -1 where none was on screen."""
    place: tuple[tuple[int, ...], ...] = ()
    """Where that step is to be seen now, in the numbers of the game's own renderer and panel; () nowhere."""
    person: int = 0
    """Who pressed, as in `core.events.KeyPressed.person`."""


class AskNow(Record, frozen=True, kw_only=True, tag="ask-now"):
    """From the worker: the game stands still, and the question that was posed last is to cover it."""

    question: int
    places: tuple[tuple[tuple[int, ...], ...], ...]
    """Where each option is to be seen, as in `TakenFor.place`; empty where the game's pictures have no places
    for them."""


class TriedOut(Record, frozen=True, kw_only=True, tag="tried-out"):
    """From the worker, its first message where the game's rules are foreign: they can be played."""


class Crashed(Record, frozen=True, kw_only=True, tag="crashed"):
    """From the worker: its last message."""

    error: str
    """One line."""
    trace: str
    """Traceback, many lines; "" where the one line says all."""


class Alive(Record, frozen=True, kw_only=True, tag="alive"):
    """From the worker: it waits, and has nothing to say."""


ALIVE_EVERY_S = 0.5
"""How often a waiting worker says so, seconds."""

ToWorker = Begin | Input
FromWorker = (
    Preparing
    | Practised
    | Ready
    | Alive
    | TriedOut
    | Picture
    | PressSuggested
    | TakenFor
    | AskNow
    | Crashed
    | Output
)

_encoder = msgspec.msgpack.Encoder()
_to_worker = msgspec.msgpack.Decoder(ToWorker)
_from_worker = msgspec.msgpack.Decoder(FromWorker, dec_hook=decode_open_table)


class LinkError(ValueError):
    """A message of the other process cannot be understood."""


def from_worker(message: bytes) -> FromWorker:
    """Return what the worker says.

    Raises:
        LinkError: it is no message of a worker.
    """
    try:
        said: FromWorker = _from_worker.decode(message)
    except (msgspec.DecodeError, ValueError, RecursionError) as error:
        raise LinkError(str(error)) from error
    return said


def to_worker(message: bytes) -> ToWorker:
    """Return what is said to the worker.

    Raises:
        LinkError: it is no message to a worker.
    """
    try:
        said: ToWorker = _to_worker.decode(message)
    except (msgspec.DecodeError, ValueError, RecursionError) as error:
        raise LinkError(str(error)) from error
    return said


class Link(Protocol):
    """The screen's end, as the app sees it: a real one or a test's."""

    def listen(self, on_message: Callable[[FromWorker], None], on_lost: Callable[[str], None]) -> None:
        """Call `on_message` for each message, and `on_lost` once (with a reason) if the worker dies."""
        ...

    def stop_listening(self) -> None:
        """Deliver nothing more. In the event loop's thread."""
        ...

    def send(self, message: ToWorker) -> None:
        """Send without ever waiting."""
        ...

    def close(self, patience_s: float = 2.0) -> None:
        """End the worker and wait until it is gone; kill it after `patience_s` seconds. In any thread."""
        ...


class WorkerLink:
    """The screen's end of the pipe to a real process."""

    def __init__(self, connection: Connection, process: BaseProcess, last_words: Callable[[], str]) -> None:
        """Take over a process that has been started.

        Args:
            connection: our end of its pipe.
            process: the worker.
            last_words: returns what it wrote to its error output, and removes it.
        """
        self.process = process
        self._connection = connection
        self._last_words = last_words
        self._outbox: queue.SimpleQueue[ToWorker | None] = queue.SimpleQueue()
        # A full pipe blocks this thread, not the screen.
        self._sender = threading.Thread(target=self._send_all, name="to-worker", daemon=True)
        self._sender.start()
        self._on_message: Callable[[FromWorker], None] = lambda _message: None
        self._on_lost: Callable[[str], None] = lambda _reason: None
        self._loop: asyncio.AbstractEventLoop | None = None

    def refusal(self) -> str:
        """Wait until a game with foreign rules has been tried, before anything else is listened
        to; return why it cannot be played, "" where it can.
        """
        try:
            first = from_worker(self._connection.recv_bytes())
        except (EOFError, OSError):
            self.process.join(1.0)
            return self._post_mortem()
        return f"{first.error}\n{first.trace}".strip() if isinstance(first, Crashed) else ""

    def listen(self, on_message: Callable[[FromWorker], None], on_lost: Callable[[str], None]) -> None:
        """Start delivering messages in the running event loop."""
        self._on_message, self._on_lost = on_message, on_lost
        self._loop = asyncio.get_running_loop()
        self._loop.add_reader(self._connection.fileno(), self._read_all)

    def stop_listening(self) -> None:
        """Take the pipe out of the event loop."""
        if self._loop is not None:
            self._loop.remove_reader(self._connection.fileno())
        self._loop = None

    def send(self, message: ToWorker) -> None:
        """Queue a message for the sending thread."""
        self._outbox.put(message)

    def close(self, patience_s: float = 2.0) -> None:
        """Close the pipe, which ends the worker; kill it where that takes longer than `patience_s`
        seconds.
        """
        self._outbox.put(None)
        self._sender.join(timeout=0.2)
        with contextlib.suppress(OSError):
            self._connection.close()
        self.process.join(patience_s)
        if self.process.is_alive():
            self.process.kill()
            self.process.join(patience_s)
        self._last_words()  # Removes the file they were in.

    def _send_all(self) -> None:
        while (message := self._outbox.get()) is not None:
            try:
                self._connection.send_bytes(_encoder.encode(message))
            except (OSError, ValueError):
                return  # The worker is gone; the reading side says so.

    def _read_all(self) -> None:
        try:
            while self._loop is not None and self._connection.poll():
                self._on_message(from_worker(self._connection.recv_bytes()))
        except LinkError as error:
            self.stop_listening()
            self._on_lost(f"The learner's process sent something that cannot be understood: {error}")
        except (EOFError, OSError):
            self.stop_listening()
            self.process.join(1.0)
            self._on_lost(self._post_mortem())

    def _post_mortem(self) -> str:
        code = self.process.exitcode
        if code is None:
            how = "has closed its end"
        elif code < 0:
            how = f"was ended by signal {-code}"
        else:
            how = f"left with status {code}"
        words = self._last_words().strip()
        return f"The learner's process {how}." + (f"\n\n{words}" if words else "")


class Line(Protocol):
    """The worker's end, as a session's player sees it."""

    def send(self, message: FromWorker) -> None:
        """Say something to the screen."""
        ...

    def receive(self, timeout_s: float | None = 0.0) -> list[ToWorker]:
        """Return all messages that are there, waiting up to `timeout_s` for the first (None: for ever)."""
        ...


class WorkerLine:
    """The worker's end of the pipe."""

    def __init__(self, connection: Connection) -> None:
        self._connection = connection

    def send(self, message: FromWorker) -> None:
        """Send; waits while the pipe is full."""
        self._connection.send_bytes(_encoder.encode(message))

    def receive(self, timeout_s: float | None = 0.0) -> list[ToWorker]:
        """Return all messages that are there, waiting up to `timeout_s` for the first (None: for ever).

        A wait of more than `ALIVE_EVERY_S` says so to the screen: a worker that is silent for longer hangs.

        Raises:
            EOFError: the screen's process has gone.
            LinkError: it sent something that is no message.
        """
        messages: list[ToWorker] = []
        left_s = math.inf if timeout_s is None else timeout_s
        while not self._connection.poll(min(left_s, ALIVE_EVERY_S)):
            left_s -= ALIVE_EVERY_S
            if left_s <= 0:
                return messages
            self.send(Alive())
        while self._connection.poll(0.0):
            messages.append(to_worker(self._connection.recv_bytes()))
        return messages
