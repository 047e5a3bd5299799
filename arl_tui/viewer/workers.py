"""Works out in another process what agents thought, while the screen goes on."""

import contextlib
import os
import tempfile
import warnings
from collections.abc import Callable
from concurrent.futures import Future, ProcessPoolExecutor
from pathlib import Path
from types import TracebackType
from typing import Self, TypeVar

from arl_tui.command_line import note_or_warning
from core.session.protocol import Protocol
from core.system.foreign_text import printable
from core.system.temporary import prefix_of, remove_left_behind
from studies.pools import processes
from studies.session_view.thoughts import Thoughts

Result = TypeVar("Result")
SAID = "said"
"""Name of the file, in the folder of decisions, that takes what the other process prints."""


class Working:
    """One agent's decisions, perhaps still being worked out."""

    def __init__(self, thoughts: Thoughts, future: "Future[str] | None" = None, words: str = "") -> None:
        """Follow a future; without one everything is there, found as `words` say."""
        self.thoughts = thoughts
        self._future = future
        self._words = words

    @property
    def done(self) -> bool:
        """Whether nothing more will come."""
        return self._future is None or self._future.done()

    @property
    def words(self) -> str:
        """Say how far it is, and how the values were found."""
        if self._future is None:
            return self._words
        if not self._future.done():
            return f"working out values ... {len(self.thoughts):,} decisions"
        error = self._future.exception()
        return self._future.result() if error is None else f"no values: {printable(str(error))}"


class WholeIndex:
    """The index of a long recording while another process builds it."""

    def __init__(self, told: Path, future: "Future[None]") -> None:
        """Follow a future that writes into `told` which share has been read."""
        self._told = told
        self._future = future

    @property
    def share(self) -> float:
        """Which fraction of the recording has been read, in [0, 1]."""
        try:
            return float(self._told.read_text() or 0)
        except (OSError, ValueError):
            return 0.0

    @property
    def done(self) -> bool:
        """Whether the index is there, or cannot be built."""
        return self._future.done()

    def check(self) -> None:
        """Raise what has kept the index from being built, if anything has."""
        self._future.result()


class Workers:
    """A process that works out decisions, and the folder in which it writes them; both go with the viewer."""

    def __init__(self, recording: Path) -> None:
        """Prepare for one recording."""
        self.said = ""
        """At the end: what the process printed, which must not stand on the screen."""
        self._recording = recording
        self._stack = contextlib.ExitStack()
        self._pool: ProcessPoolExecutor | None = None
        self._n = 0

    def __enter__(self) -> Self:
        remove_left_behind()
        folder = tempfile.TemporaryDirectory(prefix=prefix_of("watch"))
        self._folder = Path(self._stack.enter_context(folder))
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        if self._pool is not None:
            # What is being worked out is of no use any more; processes of our own pool only.
            for process in list(getattr(self._pool, "_processes", {}).values()):
                process.terminate()
        with contextlib.suppress(OSError):
            self.said = (self._folder / SAID).read_text(encoding="utf-8", errors="replace").strip()
        with contextlib.suppress(Exception):
            self._stack.close()

    def own(self) -> Working:
        """Begin with the session's own agent."""
        return self._work(_own)

    def what_if(self, protocol: Protocol) -> Working:
        """Begin with an agent that learns from the recording under another protocol."""
        return self._work(_what_if, protocol)

    def index(self) -> WholeIndex:
        """Begin to build the recording's index."""
        told = self._folder / "read"
        return WholeIndex(told, self._submit(_index, told))

    def _work(self, function: "Callable[..., str]", *arguments: object) -> Working:
        self._n += 1
        out = self._folder / f"{self._n}.thoughts"
        return Working(Thoughts(out), self._submit(function, out, *arguments))

    def _submit(self, function: "Callable[..., Result]", *arguments: object) -> "Future[Result]":
        if self._pool is None:
            self._pool = self._stack.enter_context(processes(1))
        return self._pool.submit(_printing_into, self._folder / SAID, function, self._recording, *arguments)


def _printing_into(said: Path, function: "Callable[..., Result]", *arguments: object) -> Result:
    """Call a function in a process that prints into a file: the viewer draws on the terminal."""
    descriptor = os.open(said, os.O_CREAT | os.O_APPEND | os.O_WRONLY, 0o600)
    os.dup2(descriptor, 1)
    os.dup2(descriptor, 2)
    os.close(descriptor)
    warnings.formatwarning = note_or_warning
    return function(*arguments)


def _index(recording: Path, told: Path) -> None:
    from studies.session_view.index import open_index

    def tell(share: float) -> None:
        told.write_text(f"{share:.3f}")

    open_index(recording, on_progress=tell)


def _own(recording: Path, out: Path) -> str:
    from studies.session_view.thinking import own_thoughts  # here, not above: compiled code comes with it

    return own_thoughts(recording, out)


def _what_if(recording: Path, out: Path, protocol: Protocol) -> str:
    from studies.session_view.thinking import what_if_thoughts

    return what_if_thoughts(recording, out, protocol)
