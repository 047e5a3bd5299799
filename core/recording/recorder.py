"""Write a recording, line by line, without ever making the screen wait.

Two things can happen to a line, and they are not the same. *Written*: the operating system has it, so it
survives the end of this program, however sudden. *Synced*: the disk has confirmed it, so it survives a power
cut. A write takes microseconds, a sync up to seconds; so each has a thread of its own.
"""

import contextlib
import errno
import os
import queue
import threading
from collections import deque
from collections.abc import Callable, Iterable
from dataclasses import dataclass
from pathlib import Path
from types import TracebackType
from typing import BinaryIO, Self

import msgspec

from core.events import Event
from core.numerics.clock import NS_PER_S, Clock, MonotonicClock
from core.recording.chain import Chain
from core.recording.schema import DURABLE, VERSION, End, Header, Line, encode
from core.system.in_use import hold
from core.system.private_files import create_private, make_private_folder, sync_folder, write_all

LOOK_S = 0.25
"""How often the recorder looks whether its file is still where it was, seconds."""


class LineWriter:
    """Append sealed lines to a new file, in the caller's thread."""

    def __init__(self, path: Path, header: Header, *, sign: Callable[[bytes], bytes] | None = None) -> None:
        """Create a new file that only its owner can read; an existing one is never touched.

        Its header says the present version of the format.

        Args:
            path: of the new file.
            header: its first line.
            sign: returns the signature of a message; None leaves the recording unsigned.

        Raises:
            FileExistsError: there is a file at `path` already.
            OSError: the file cannot be created, or its header cannot be written.
        """
        make_private_folder(path.parent)
        self.path = path
        self._file: BinaryIO = create_private(path)
        hold(self._file)
        self._chain = Chain()
        self._sign = sign
        self._events = 0
        self._length = 0
        try:
            self._append(msgspec.structs.replace(header, version=VERSION))
        except OSError:
            self._file.close()
            path.unlink(missing_ok=True)  # nothing is in it, and it would be listed as damaged
            raise
        sync_folder(path.parent)

    def write(self, event: Event) -> None:
        """Append one event; on the disk when this returns if it is of a durable kind.

        Raises:
            OSError: the disk did not take it. The file then ends with the line before.
        """
        self.append(event)
        if is_durable(event):
            self.sync()

    def append(self, event: Event) -> None:
        """Append one event without waiting for the disk to confirm it.

        Raises:
            OSError: the disk did not take it. The file then ends with the line before.
        """
        self._append(event)
        self._events += 1

    def sync(self) -> None:
        """Wait until everything that has been appended is on the disk. In any thread.

        Raises:
            OSError: the disk failed.
        """
        os.fsync(self._file.fileno())

    def check_place(self) -> None:
        """Look whether the file is still to be found under its name.

        Raises:
            OSError: it was removed or moved, or another file has taken its place.
        """
        ours = os.fstat(self._file.fileno())
        try:
            there = os.stat(self.path)
        except FileNotFoundError:
            there = None
        if there is None or (there.st_ino, there.st_dev) != (ours.st_ino, ours.st_dev):
            raise FileNotFoundError(
                errno.ENOENT, "the file was removed or moved during the session", str(self.path)
            )

    def content(self) -> bytes:
        """Return what the file holds, also where its name is gone.

        Raises:
            OSError: it cannot be read.
        """
        parts: list[bytes] = []
        while part := os.pread(self._file.fileno(), 1 << 20, sum(map(len, parts))):
            parts.append(part)
        return b"".join(parts)

    def finish(self) -> None:
        """Append the end line, without waiting for the disk to confirm it."""
        signature = b"" if self._sign is None else self._sign(self._chain.to_sign(self._events))
        self._append(End(events=self._events, signature=signature.hex()))

    def close(self) -> None:
        """Append the end line, wait until everything is on the disk, and close."""
        self.finish()
        self.sync()
        self._file.close()

    def abandon(self) -> None:
        """Close without an end line, as a crash would."""
        self._file.close()

    def _append(self, line: Line) -> None:
        # One write per line, unbuffered: a kill between two lines leaves only whole lines.
        sealed = self._chain.seal(encode(line))
        try:
            write_all(self._file, sealed)
        except OSError:
            # A torn line would make all that stands behind it unreadable. Cutting needs no room on the disk.
            with contextlib.suppress(OSError):  # then it stays the last one: nothing is written after it
                os.ftruncate(self._file.fileno(), self._length)
            raise
        self._length += len(sealed)


def write_recording(path: Path, header: Header, events: Iterable[Event]) -> None:
    """Write a recording that is all there already: the whole file, or none.

    Args:
        path: of the new file.
        header: its first line.
        events: in order.

    Raises:
        FileExistsError: there is a file at `path` already; it is not touched.
        OSError: the file cannot be written.
    """
    encode(header)  # what cannot be encoded must not leave a file behind
    writer = LineWriter(path, header)
    try:
        for event in events:
            writer.append(event)
        writer.close()
    except BaseException:
        writer.abandon()
        path.unlink(missing_ok=True)
        raise


def is_durable(event: Event) -> bool:
    """Return whether a record is forced to the disk at once."""
    return type(event).__name__ in DURABLE


@dataclass(frozen=True, slots=True)
class Kept:
    """How much of a session is safe, counted in events (the header and the end line are not among them)."""

    recorded: int
    """Events that were handed to the recorder."""
    written: int
    """Events that the operating system has: they survive the end of this program."""
    synced: int
    """Events that the disk has confirmed: they survive a power cut."""


class Recorder:
    """A `LineWriter` with a thread that writes and a thread that syncs.

    `record` returns at once. `written` and `synced` say how far the threads have come. If the disk fails,
    `failure` holds the error and the events that could not be written are kept in `unwritten`, so that the
    session can end with a message and save them elsewhere. Where the disk took events and could not confirm
    them, these are in `unwritten`, too: nobody knows whether the file holds them. Where the file was removed
    or moved, `failure` says so and the rest is still written to it: `content` then holds the whole recording.
    """

    def __init__(
        self,
        path: Path,
        header: Header,
        *,
        on_news: Callable[[], None] = lambda: None,
        clock: Clock | None = None,
        sign: Callable[[bytes], bytes] | None = None,
    ) -> None:
        """Create the file and start the threads.

        Args:
            path: of the new file.
            header: its first line.
            on_news: called when events have been written, and when the disk has failed; in another thread.
            clock: tells how long the disk takes.
            sign: returns the signature of a message; None leaves the recording unsigned.

        Raises:
            FileExistsError: there is a file at `path` already.
            OSError: the file cannot be created.
        """
        self.path = path
        self.failure: OSError | None = None
        self.unwritten: list[Event] = []
        self.recorded = 0
        self.written = 0
        self.synced = 0
        self._on_news = on_news
        self._clock = clock or MonotonicClock()
        self._writer = LineWriter(path, header, sign=sign)
        self._queue: queue.SimpleQueue[Event | None] = queue.SimpleQueue()
        self._pending: deque[Event] = deque()
        # Written, and not yet confirmed by the disk.
        self._unsynced: deque[Event] = deque()
        self._change = threading.Condition()
        self._wanted = 0
        self._waiting_since_ns: int | None = None
        self._all_written = False
        self._broken = False
        self._unconfirmed = False
        self._content: bytes | None = None
        self._write_thread = threading.Thread(target=self._write_all, name="recorder", daemon=True)
        self._sync_thread = threading.Thread(target=self._sync_all, name="recorder-sync", daemon=True)
        self._write_thread.start()
        self._sync_thread.start()

    # --- from the session -----------------------------------------------------------------------------------

    def record(self, event: Event) -> None:
        """Hand over one event; from one thread; never waits for the disk."""
        self.recorded += 1
        self._pending.append(event)
        self._queue.put(event)

    @property
    def kept(self) -> Kept:
        """How much is safe by now."""
        return Kept(self.recorded, self.written, self.synced)

    def unsynced_s(self) -> float:
        """Return for how long the oldest event that should be on the disk has waited for it, seconds; 0.0 if
        none.
        """
        since_ns = self._waiting_since_ns
        return 0.0 if since_ns is None else (self._clock.now_ns() - since_ns) / NS_PER_S

    def close(self, timeout_s: float = 10.0) -> None:
        """Write what is left and the end line.

        Raises:
            OSError: the disk failed at some time; `unwritten` holds what is missing from the file.
            TimeoutError: the disk did not take, or not confirm, the rest within `timeout_s` seconds; `kept`
                says how much it has, and `unwritten` holds what may be missing from the file.
        """
        self._queue.put(None)
        until_ns = self._clock.now_ns() + round(timeout_s * NS_PER_S)
        self._write_thread.join(timeout_s)
        self._sync_thread.join(max(0.0, (until_ns - self._clock.now_ns()) / NS_PER_S))
        if not self._write_thread.is_alive() and not self._sync_thread.is_alive():
            if self.failure is not None:
                self._content = self._writer.content()
            self._writer.abandon()
        if self._unconfirmed:
            self.unwritten = [*self._unsynced, *self.unwritten]
            self._unsynced.clear()
        if self.failure is not None:
            raise self.failure
        if self._write_thread.is_alive():
            # The first of these may get into the file later: twice is better than not at all.
            self.unwritten = list(self._pending)
            raise TimeoutError(f"{self.path}: the disk did not take the recording within {timeout_s:g} s")
        if self._sync_thread.is_alive():
            raise TimeoutError(f"{self.path}: the disk did not confirm the recording within {timeout_s:g} s")

    def content(self) -> bytes:
        """Return what the file holds, also where its name is gone and after a failure that `close` has
        reported.
        """
        return self._writer.content() if self._content is None else self._content

    def __enter__(self) -> Self:
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        self.close()

    # --- the thread that writes -----------------------------------------------------------------------------

    def _write_all(self) -> None:
        while (event := self._queue.get()) is not None:
            if not self._broken:
                try:
                    self._writer.append(event)
                except OSError as error:
                    self._break(error)
                else:
                    self._unsynced.append(self._pending.popleft())
                    self.written += 1
                    self._ask_for_sync(is_durable(event))
                    self._on_news()
                    continue
            self.unwritten.append(self._pending.popleft())
        if not self._broken:
            try:
                self._writer.finish()
            except OSError as error:
                self._break(error)
        with self._change:
            self._all_written = True
            self._change.notify()

    def _ask_for_sync(self, durable: bool) -> None:
        if durable:
            with self._change:
                self._wanted = self.written
                if self._waiting_since_ns is None:
                    self._waiting_since_ns = self._clock.now_ns()
                self._change.notify()

    def _break(self, error: OSError) -> None:
        """Write nothing more: the disk has failed."""
        self._broken = True
        self._fail(error)

    def _fail(self, error: OSError) -> None:
        if self.failure is None:
            self.failure = error
            self._on_news()

    # --- the thread that syncs ------------------------------------------------------------------------------

    def _sync_all(self) -> None:
        ended = False
        while not ended and not self._broken:
            with self._change:
                if self._wanted <= self.synced and not self._all_written:
                    self._change.wait(LOOK_S)
                ended = self._all_written
                # All that was written before the sync begins is on the disk when it is over.
                asked, covered = ended or self._wanted > self.synced, self.written
            try:
                if asked:
                    self._sync(covered)
            except OSError as error:
                self._unconfirmed = True
                self._break(error)
            try:
                self._writer.check_place()
            except OSError as error:
                self._fail(error)

    def _sync(self, covered: int) -> None:
        began_ns = self._clock.now_ns()
        self._writer.sync()
        with self._change:
            for _ in range(covered - self.synced):
                self._unsynced.popleft()
            self.synced = covered
            self._waiting_since_ns = began_ns if self._wanted > covered else None
