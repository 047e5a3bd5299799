"""Write a recording, line by line, without ever making the screen wait."""

import hashlib
import os
import queue
import threading
from pathlib import Path
from types import TracebackType
from typing import BinaryIO, Self

import msgspec

from core.episode import Event
from core.recording.schema import DURABLE, VERSION, End, Header, Line, encode

CHAIN_DIGITS = 16


class Chain:
    """The running hash that ties every line to all lines before it."""

    def __init__(self) -> None:
        self._hash = hashlib.sha256()

    def seal(self, payload: bytes) -> bytes:
        """Return the line for `payload` (a JSON object): with its chain and a newline."""
        return payload[:-1] + b',"chain":"' + self.advance(payload) + b'"}\n'

    def advance(self, payload: bytes) -> bytes:
        """Take in `payload` and return the chain's digits after it."""
        self._hash.update(payload)
        return self._hash.hexdigest()[:CHAIN_DIGITS].encode()


class LineWriter:
    """Append sealed lines to a new file, in the caller's thread."""

    def __init__(self, path: Path, header: Header) -> None:
        """Open a new file; an existing one is never touched. Its header says the present version of the format.

        Raises:
            FileExistsError: there is a file at `path` already.
        """
        path.parent.mkdir(parents=True, exist_ok=True)
        self.path = path
        self._file: BinaryIO = path.open("xb", buffering=0)
        self._chain = Chain()
        self._events = 0
        self._write(msgspec.structs.replace(header, version=VERSION))

    def write(self, event: Event) -> None:
        """Append one event; on disk when this returns if it is of a durable kind."""
        self._write(event)
        self._events += 1

    def close(self) -> None:
        """Append the end line and close."""
        self._write(End(events=self._events))
        self._file.close()

    def abandon(self) -> None:
        """Close without an end line, as a crash would."""
        self._file.close()

    def _write(self, line: Line) -> None:
        # One write per line, unbuffered: a kill between two lines leaves only whole lines.
        self._file.write(self._chain.seal(encode(line)))
        if type(line).__name__ in DURABLE:
            os.fsync(self._file.fileno())


class Recorder:
    """A `LineWriter` behind a queue and a thread of its own.

    `record` returns at once. If the disk fails, `failure` holds the error and the events that could not be
    written are kept in `unwritten`, so that the session can end with a message and save them elsewhere.
    """

    def __init__(self, path: Path, header: Header) -> None:
        self.path = path
        self.failure: OSError | None = None
        self.unwritten: list[Event] = []
        self._writer = LineWriter(path, header)
        self._queue: queue.SimpleQueue[Event | None] = queue.SimpleQueue()
        self._thread = threading.Thread(target=self._run, name="recorder", daemon=True)
        self._thread.start()

    def record(self, event: Event) -> None:
        """Hand over one event; safe from any thread; never waits for the disk."""
        self._queue.put(event)

    def close(self, timeout_s: float = 10.0) -> None:
        """Write what is left and the end line.

        Raises:
            OSError: the disk failed at some time; `unwritten` holds what is missing from the file.
            TimeoutError: the disk did not take the rest within `timeout_s` seconds.
        """
        self._queue.put(None)
        self._thread.join(timeout_s)
        if self._thread.is_alive():
            raise TimeoutError(f"{self.path}: the disk did not take the recording within {timeout_s} s")
        if self.failure is not None:
            raise self.failure

    def __enter__(self) -> Self:
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        self.close()

    def _run(self) -> None:
        while (event := self._queue.get()) is not None:
            if self.failure is None:
                try:
                    self._writer.write(event)
                    continue
                except OSError as error:
                    self.failure = error
            self.unwritten.append(event)
        if self.failure is None:
            try:
                self._writer.close()
            except OSError as error:
                self.failure = error
        else:
            self._writer.abandon()
