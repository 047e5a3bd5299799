"""The other end of the terminal: starts the real command in a pseudo-terminal, reads its screen, presses
keys."""

import os
import sys
import time
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Self

import pexpect
import pyte

from tests.e2e.processes import children

COLUMNS, LINES = 80, 24
TROUBLE = "had to end early"
"""What the last screen says when something failed."""
START = "Enter  to start, "
"""What the first page of a session says."""
ASKS_AGAIN = "Ready. "
"""What it says when getting ready took longer than a participant can be expected to have waited."""
HELD_UP = "slept or was held up"
"""What the page says behind which a session waits when the machine has stood still for a second."""
PATIENCE_S = 600.0
"""Compiling everything for the first time takes a minute, and many on a busy machine; nobody waits longer
than they must."""
REPOSITORY = Path(__file__).resolve().parents[2]


class Terminal:
    """A terminal of 80 x 24 with `arl` running in it, or another program."""

    def __init__(
        self,
        *arguments: str,
        cwd: Path,
        columns: int = COLUMNS,
        lines: int = LINES,
        exported: Mapping[str, str] | None = None,
        module: str = "arl_tui.cli",
        in_shell: bool = False,
        program: Sequence[str] = (),
    ) -> None:
        environment = {
            **os.environ,
            "ARL_HOME": str(cwd),
            "TERM": "xterm-256color",
            "COLORTERM": "truecolor",
            "TEXTUAL_DISABLE_KITTY_KEY": "1",
            "PYTHONPATH": os.pathsep.join([str(REPOSITORY), os.environ.get("PYTHONPATH", "")]),
        }
        for name in ("TMUX", "STY", "SSH_CONNECTION", "NO_COLOR", "TEXTUAL_DRIVER", "COLUMNS", "LINES"):
            environment.pop(name, None)
        environment |= exported or {}
        self.mark = b""
        """Bytes whose arrival is timed."""
        self.mark_ns: list[int] = []
        """When the mark was read, before anything was made of it: ns of the monotonic clock."""
        self.received = b""
        """Everything that has been read."""
        self._tail = b""
        self._held_up_since: float | None = None
        self._screen = pyte.Screen(columns, lines)
        self._stream = pyte.ByteStream(self._screen)
        command = [*program] or [sys.executable, "-W", "ignore", "-m", module, *arguments]
        if in_shell:
            # As at a prompt: the shell outlives the program. Where the program leads the terminal's session,
            # the kernel closes the terminal as soon as it ends, and its guard cannot write to it.
            command = ["/bin/sh", "-c", '"$@"; read -r _', "sh", *command]
        self._in_shell = in_shell
        self.child = pexpect.spawn(
            command[0],
            command[1:],
            dimensions=(lines, columns),
            cwd=str(cwd),
            env=environment,
            timeout=PATIENCE_S,
        )

    def __enter__(self) -> Self:
        return self

    def __exit__(self, *_: object) -> None:
        try:
            self.child.close(force=True)
        except pexpect.ExceptionPexpect:  # on a busy machine a killed process takes longer to go
            while self.child.isalive():
                time.sleep(0.05)
            self.child.close()

    @property
    def pid(self) -> int:
        """Process id of the program."""
        pid: int = self.child.pid
        if self._in_shell:
            (pid,) = children(pid)
        return pid

    def pump(self, duration_s: float = 0.05) -> bool:
        """Read what arrives for a while; return whether the program still runs."""
        end = time.monotonic() + duration_s
        while (left := end - time.monotonic()) > 0:
            try:
                read = self.child.read_nonblocking(65536, timeout=left)
            except pexpect.TIMEOUT:
                return True
            except pexpect.EOF:
                return False
            self._time_mark(read, time.monotonic_ns())
            self.received += read
            self._stream.feed(read)
        return True

    def discard(self, duration_s: float) -> None:
        """Read what arrives for a while and keep none of it: a session of hours writes gigabytes."""
        end = time.monotonic() + duration_s
        while (left := end - time.monotonic()) > 0:
            try:
                self.child.read_nonblocking(65536, timeout=left)
            except (pexpect.TIMEOUT, pexpect.EOF):
                return

    def _time_mark(self, read: bytes, now_ns: int) -> None:
        if self.mark:
            recent = self._tail + read  # what is read may begin anywhere in it
            if self.mark in recent:
                self.mark_ns.append(now_ns)
            self._tail = recent[1 - len(self.mark) :]

    @property
    def text(self) -> str:
        """What stands on the screen, line by line."""
        return "\n".join(line.rstrip() for line in self._screen.display)

    def wait_for(self, *texts: str, patience_s: float = PATIENCE_S) -> str:
        """Read until one of the texts stands on the screen; return which."""
        end = time.monotonic() + patience_s
        while time.monotonic() < end:
            running = self.pump()
            for text in texts:
                if text in self.text:
                    return text
            self._go_on_after_a_gap()
            if TROUBLE in self.text and TROUBLE not in texts:
                raise AssertionError(f"trouble before {texts} was seen:\n{self.text}")
            if not running:
                raise AssertionError(f"the program ended before {texts} was seen:\n{self.text}")
        raise AssertionError(f"{texts} was not seen within {patience_s:.0f} s:\n{self.text}")

    def wait_for_words(self, words: str) -> None:
        """Read until words stand on the screen, whatever blanks are between them.

        Where getting ready took so long that the page asks for the start key once more, it is pressed.
        """
        end = time.monotonic() + PATIENCE_S
        asked = False
        running = True
        while words not in " ".join(self.text.split()):
            assert running, f"the program ended before {words!r} was seen:\n{self.text}"
            assert time.monotonic() < end, f"{words!r} was not seen:\n{self.text}"
            assert TROUBLE not in self.text, f"trouble before {words!r} was seen:\n{self.text}"
            if ASKS_AGAIN in self.text and not asked:
                self.press("\r")
            asked = ASKS_AGAIN in self.text
            running = self.pump()
            self._go_on_after_a_gap()

    def _go_on_after_a_gap(self) -> None:
        """Go on, as a participant would, where a busy machine has made the session pause by itself.

        Only after a moment: a test that is about gaps goes on by itself.
        """
        now = time.monotonic()
        if HELD_UP not in self.text:
            self._held_up_since = None
        elif self._held_up_since is None:
            self._held_up_since = now
        elif now > self._held_up_since + 2.0:
            self.press(" ")
            self._held_up_since = None

    def press(self, keys: str) -> int:
        """Write keys to the terminal; return the time just before, ns of the monotonic clock."""
        now_ns = time.monotonic_ns()
        os.write(self.child.child_fd, keys.encode())
        return now_ns

    def begin(self, *seen: str) -> str:
        """Start the session from its first page, and read until one of the texts is seen; return which.

        A game begins only in front of a participant: where getting ready took longer than a few seconds, the
        page asks for the start key once more.
        """
        self.wait_for(START)
        self.press("\r")
        if self.wait_for(ASKS_AGAIN, *seen) == ASKS_AGAIN:
            self.press("\r")
        while ASKS_AGAIN in self.text:
            assert self.pump(), self.text
        return self.wait_for(*seen)

    def wait_for_exit(self, patience_s: float = PATIENCE_S) -> int:
        """Read to the end; return the exit status."""
        end = time.monotonic() + patience_s
        while time.monotonic() < end:
            running = self.pump()
            self._go_on_after_a_gap()
            if not running:
                self.child.close()
                assert self.child.exitstatus is not None, f"ended by signal {self.child.signalstatus}"
                return self.child.exitstatus
        raise AssertionError(f"the program still runs after {patience_s:.0f} s:\n{self.text}")

    def wait_for_exit_only(self, patience_s: float = 60.0) -> int:
        """Read until the program has ended, and leave the terminal open; return the exit status (minus a
        signal's)."""
        end = time.monotonic() + patience_s
        while self.child.isalive():
            assert time.monotonic() < end, f"the program still runs after {patience_s:.0f} s:\n{self.text}"
            self.pump()
        self.drain(0.3)
        status = self.child.exitstatus
        return -int(self.child.signalstatus) if status is None else int(status)

    def drain(self, duration_s: float = 1.5) -> None:
        """Read what still arrives, also after the end of the program."""
        end = time.monotonic() + duration_s
        while time.monotonic() < end and self.pump(0.1):
            pass

    def blocks_on_board(self) -> int:
        """Count the blocks in the board's frame: settled ones and those of the falling piece, not the
        ghost."""
        inside = [line[3:23] for line in self._screen.display[1:21]]
        return sum(row.count("▕") for row in inside)

    def resize(self, columns: int, lines: int) -> None:
        """Change the window's size."""
        self._screen.resize(lines, columns)
        self.child.setwinsize(lines, columns)

    def hang_up(self) -> None:
        """Close the window: the terminal is gone, and the kernel tells the program so."""
        self.child.ptyproc.fileobj.close()
        self.child.ptyproc.closed = self.child.closed = True

    def ends_by_itself(self, patience_s: float) -> bool:
        """Return whether the program ends within the time, without anybody reading what it writes."""
        end = time.monotonic() + patience_s
        while time.monotonic() < end:
            if not self.child.isalive():
                return True
            time.sleep(0.1)
        return False
