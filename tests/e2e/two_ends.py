"""A program whose keyboard and screen are two pseudo-terminals, so that one can close and the other not."""

import fcntl
import os
import pty
import select
import struct
import subprocess
import sys
import termios
import time
from pathlib import Path
from typing import Self

import pyte

from tests.e2e.terminal import ASKS_AGAIN, COLUMNS, LINES, PATIENCE_S, REPOSITORY, START


class TwoEnds:
    """`arl` with its input at one pseudo-terminal and its output at another; neither is its controlling
    one."""

    def __init__(self, *arguments: str, cwd: Path) -> None:
        self.keyboard, keys = pty.openpty()
        self.display, shown = pty.openpty()
        for end in (keys, shown):
            fcntl.ioctl(end, termios.TIOCSWINSZ, struct.pack("HHHH", LINES, COLUMNS, 0, 0))
        environment = {**os.environ, "TERM": "xterm-256color", "TEXTUAL_DISABLE_KITTY_KEY": "1"}
        environment["PYTHONPATH"] = str(REPOSITORY)
        for name in ("TMUX", "STY", "SSH_CONNECTION", "NO_COLOR", "TEXTUAL_DRIVER", "COLUMNS", "LINES"):
            environment.pop(name, None)
        self.process = subprocess.Popen(
            [sys.executable, "-W", "ignore", "-m", "arl_tui.cli", *arguments],
            stdin=keys,
            stdout=shown,
            stderr=shown,
            cwd=cwd,
            env=environment,
            start_new_session=True,
        )
        os.close(keys)
        os.close(shown)
        self.received = b""
        """Everything that has been written to the display."""
        self._screen = pyte.Screen(COLUMNS, LINES)
        self._stream = pyte.ByteStream(self._screen)

    def __enter__(self) -> Self:
        return self

    def __exit__(self, *_: object) -> None:
        self.process.kill()
        self.process.wait()
        self.close("both")

    def pump(self, duration_s: float = 0.05) -> None:
        """Read what arrives for a while."""
        end = time.monotonic() + duration_s
        while (left := end - time.monotonic()) > 0:
            if self.display < 0 or not select.select([self.display], [], [], left)[0]:
                time.sleep(min(left, 0.01) if self.display < 0 else 0.0)
                continue
            try:
                part = os.read(self.display, 65536)
            except OSError:
                return
            self.received += part
            self._stream.feed(part)

    @property
    def text(self) -> str:
        """What stands on the screen, line by line."""
        return "\n".join(self._screen.display)

    def wait_for(self, *texts: str, patience_s: float = PATIENCE_S) -> str:
        """Read until one of the texts stands on the screen; return which."""
        end = time.monotonic() + patience_s
        while time.monotonic() < end:
            self.pump()
            for text in texts:
                if text in self.text:
                    return text
            assert self.process.poll() is None, f"the program ended before {texts} was seen:\n{self.text}"
        raise AssertionError(f"{texts} was not seen:\n{self.text}")

    def begin(self, *seen: str) -> str:
        """Start the session from its first page, as `tests.e2e.terminal.Terminal.begin` does."""
        self.wait_for(START)
        self.press("\r")
        if self.wait_for(ASKS_AGAIN, *seen) == ASKS_AGAIN:
            self.press("\r")
        while ASKS_AGAIN in self.text:
            self.pump()
        return self.wait_for(*seen)

    def press(self, keys: str) -> None:
        """Write keys."""
        os.write(self.keyboard, keys.encode())

    def close(self, which: str) -> None:
        """Close the "input", the "output" or "both"."""
        if which in ("input", "both") and self.keyboard >= 0:
            os.close(self.keyboard)
            self.keyboard = -1
        if which in ("output", "both") and self.display >= 0:
            os.close(self.display)
            self.display = -1

    def seconds_to_end(self, patience_s: float = 30.0) -> float:
        """Return how long the program takes to end, seconds; its display is read meanwhile, where it has
        one."""
        began = time.monotonic()
        while self.process.poll() is None:
            assert time.monotonic() - began < patience_s, "the program does not end"
            self.pump(0.02)
        took_s = time.monotonic() - began
        self.pump(0.3)
        return took_s
