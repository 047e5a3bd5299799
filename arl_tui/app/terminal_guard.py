"""A small process that outlives the app and leaves the terminal usable, however the app ended.

An app that crashes in native code, or is killed, cannot restore the terminal: it stays in raw mode, on the
alternate screen, without a cursor. The guard waits at the other end of a pipe. The pipe closes when the app
ends, whatever the reason; unless the app has said that it has restored the terminal itself, the guard does
so.

The second half of this file runs as a script, with nothing of this project imported.
"""

import contextlib
import faulthandler
import json
import os
import select
import signal
import subprocess
import sys
import tempfile
from types import TracebackType
from typing import Any, Self

RESTORED = b"restored"
"""The app's last word where it has restored the terminal."""
QUIET = b"quiet"
"""The app's last word where it ends on purpose but cannot reach the terminal: restore it and say nothing."""
RESET = (
    "\x1b[?2026l"  # synchronised output
    "\x1b[?1000l\x1b[?1002l\x1b[?1003l\x1b[?1006l\x1b[?1015l\x1b[?1016l"  # mouse reports
    "\x1b[?2004l"  # bracketed paste
    "\x1b[?2048l"  # reports of the window's size
    "\x1b[?1004l"  # focus reports
    "\x1b[<u"  # kitty's keyboard protocol
    "\x1b[?7h"  # line wrap
    "\x1b[?1049l"  # alternate screen
    "\x1b[?25h\x1b[0m"  # cursor, colours
)
"""What turns off everything that Textual turns on."""


class TerminalGuard:
    """Starts the guard of this terminal; does nothing where there is no terminal, or not one of POSIX."""

    def __init__(self) -> None:
        self._pipe = -1
        self._process: subprocess.Popen[bytes] | None = None

    def __enter__(self) -> Self:
        if sys.platform == "win32" or not (os.isatty(0) and os.isatty(2)):
            return self
        import termios

        try:
            attributes = json.dumps(termios.tcgetattr(0), default=lambda byte: byte.decode("latin-1"))
        except termios.error:
            return self
        theirs, self._pipe = os.pipe()
        # Without a name: it is gone when both processes are.
        with tempfile.TemporaryFile() as crash:
            self._process = subprocess.Popen(
                [sys.executable, "-I", "-S", __file__, str(theirs), str(crash.fileno()), attributes],
                pass_fds=(theirs, crash.fileno()),
                # what is sent to all of the terminal's processes does not end this one
                start_new_session=True,
            )
            # The handler keeps the number of the file for as long as this process lives.
            faulthandler.enable(os.dup(crash.fileno()))
        os.close(theirs)
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        self.tell(RESTORED)
        if self._process is not None:
            with contextlib.suppress(subprocess.TimeoutExpired):
                self._process.wait(1.0)

    def tell(self, word: bytes) -> None:
        """Say the app's last word: `RESTORED` or `QUIET`."""
        if self._pipe >= 0:
            with contextlib.suppress(OSError):
                os.write(self._pipe, word)
            os.close(self._pipe)
            self._pipe = -1


def guard(pipe: int, crash: int, attributes: str) -> None:
    """Wait for the end of the app; then restore the terminal where that is needed.

    Args:
        pipe: where the app says its last word.
        crash: file in which Python notes where it was when the app crashed.
        attributes: of the terminal before the app changed them, JSON.
    """
    import termios

    for name in ("SIGINT", "SIGHUP", "SIGTERM", "SIGQUIT", "SIGTSTP", "SIGTTOU", "SIGTTIN", "SIGPIPE"):
        signal.signal(getattr(signal, name), signal.SIG_IGN)
    word = b""
    while part := os.read(pipe, 64):
        word += part
    if word.endswith(RESTORED):
        return
    parsed: list[Any] = json.loads(attributes)
    parsed[6] = [value.encode("latin-1") if isinstance(value, str) else value for value in parsed[6]]
    text = RESET
    if not word.endswith(QUIET):
        trace = os.pread(crash, 20_000, 0).decode(errors="replace").replace("\n", "\r\n")
        text += f"\r\n{trace}arl ended unexpectedly; the terminal has been reset.\r\n"
    with contextlib.suppress(OSError, termios.error):
        termios.tcsetattr(0, termios.TCSANOW, parsed)
    with contextlib.suppress(OSError):
        write_all(2, text.encode())


def write_all(descriptor: int, text: bytes) -> None:
    """Write the whole text: a terminal may take a part of it, and nothing while its buffer is full.

    Raises:
        OSError: the terminal is gone.
    """
    while text:
        try:
            text = text[os.write(descriptor, text) :]
        except BlockingIOError:
            select.select([], [descriptor], [], 1.0)


if __name__ == "__main__":
    guard(int(sys.argv[1]), int(sys.argv[2]), sys.argv[3])
