"""The robot participant: runs the app under test in a pseudo-terminal and answers each stimulus after an
exact delay.

The robot and the app use one clock (CLOCK_MONOTONIC) of one machine, so their times can be subtracted. The
true reaction time is the robot's: from just after the read that brought the stimulus to just before the write
of the key.
"""

import contextlib
import fcntl
import os
import pty
import re
import select
import signal
import struct
import subprocess
import sys
import tempfile
import termios
import time
from collections.abc import Callable
from pathlib import Path
from typing import Self

import msgspec

from arl_tui.app.facts import REPOSITORY
from arl_tui.drawing_rate import FRAMES_PER_S
from arl_tui.timing.plan import ANSWER_KEY, MARKER, START_UP_S, Plan, Seen
from core.system.temporary import prefix_of, remove_left_behind

SPIN_NS = 2_000_000
"""The last 2 ms before a key is written are spent looking at the clock: no wake-up is late then."""
REST_S = 0.02
"""The robot sleeps for so long after a key: the kernel's worker that carries the key over may share its core
with the robot, and a robot that goes on working holds it up until the next tick (measured: median 0.07
against 0.3 to 0.6 ms)."""
_TAIL = 64
"""Bytes kept from one read to the next: more than a marker or a query."""
_LAST_WORDS = 2000
_CONTROL = re.compile(r"\x1b\[[0-9;?<>=$]*[a-zA-Z]|\x1b[()=>].?|\r")
"""Escape sequences, which mean nothing outside a terminal."""
_SYNC_QUERY, _SYNC_REPLY = b"\x1b[?2026$p", b"\x1b[?2026;2$y"
"""Does the terminal know synchronised output? Yes, and it is off."""


class TimingError(RuntimeError):
    """The self-test could not be carried out; the message says why."""


class RobotTrial(msgspec.Struct, frozen=True, kw_only=True):
    """A trial as the robot saw it. Times in ns of the monotonic clock."""

    number: int
    read_ns: int
    """Just after the read that brought the stimulus."""
    written_ns: int
    """Just before the write of the key."""


class Robot:
    """A pseudo-terminal with the app under test on its other side. A context manager: no process is left
    behind.
    """

    def __init__(self, plan: Plan, folder: Path) -> None:
        """Start the app.

        Args:
            plan: what it shows, and when it is answered.
            folder: for the files the two exchange.
        """
        self.trials: list[RobotTrial] = []
        self._delays_ns = {trial.number: trial.delay_ms * 1_000_000 for trial in plan.trials}
        self._read_ns: dict[int, int] = {}
        self._due: list[tuple[int, int]] = []
        self._tail = b""
        self._words = b""
        plan_path = folder / "plan.json"
        plan_path.write_bytes(msgspec.json.encode(plan))
        self._seen_path = folder / "seen.json"
        self._fd, theirs = pty.openpty()
        fcntl.ioctl(theirs, termios.TIOCSWINSZ, struct.pack("HHHH", plan.lines, plan.columns, 0, 0))
        arguments = [str(plan_path), str(self._seen_path), str(os.getpid())]
        self._process = subprocess.Popen(
            [sys.executable, "-m", _program(plan), *arguments],
            stdin=theirs,
            stdout=theirs,
            stderr=theirs,
            env=_environment(),
            start_new_session=True,
        )
        os.close(theirs)

    @property
    def pid(self) -> int:
        """Process id of the app under test."""
        return self._process.pid

    def __enter__(self) -> Self:
        return self

    def __exit__(self, *_: object) -> None:
        """End every process that was started."""
        with contextlib.suppress(ProcessLookupError):
            os.killpg(self._process.pid, signal.SIGKILL)
        self._process.wait()
        os.close(self._fd)

    def run(self, longest_s: float, on_trial: Callable[[], None]) -> Seen:
        """Answer all stimuli; return what the app saw.

        Args:
            longest_s: give up after so many seconds.
            on_trial: called after each answer.

        Raises:
            TimingError: the app ended early or takes too long.
        """
        end_ns = time.monotonic_ns() + round(longest_s * 1e9)
        while self._pump():
            if self._due and self._due[0][0] - time.monotonic_ns() <= SPIN_NS:
                self._answer(*self._due.pop(0))
                on_trial()
            if time.monotonic_ns() > end_ns:
                raise TimingError(
                    f"the app under test still runs after {longest_s:.0f} s. {self._last_words()}"
                )
        status = self._process.wait()
        if status != 0 or not self._seen_path.exists():
            raise TimingError(f"the app under test left with status {status}. {self._last_words()}")
        return msgspec.json.decode(self._seen_path.read_bytes(), type=Seen)

    def _pump(self) -> bool:
        """Wait until bytes come or a key is nearly due; return whether the app still runs."""
        wait_s = 0.5
        if self._due:
            wait_s = max(0.0, min(wait_s, (self._due[0][0] - time.monotonic_ns() - SPIN_NS) / 1e9))
        ready, _, _ = select.select([self._fd], [], [], wait_s)
        if not ready:
            return True
        try:
            got = os.read(self._fd, 65536)
        except OSError:  # Linux: the last process on the other side has closed it.
            return False
        self._take_in(got, time.monotonic_ns())
        return got != b""

    def _take_in(self, got: bytes, read_ns: int) -> None:
        """Look for new stimuli and for questions to the terminal."""
        text = self._tail + got
        for found in MARKER.finditer(text):
            number = int(found.group(1))
            if number in self._delays_ns and number not in self._read_ns:
                self._read_ns[number] = read_ns
                self._due.append((read_ns + self._delays_ns[number], number))
        if text.count(_SYNC_QUERY) > self._tail.count(_SYNC_QUERY):
            os.write(self._fd, _SYNC_REPLY)
        self._tail = text[-_TAIL:]
        self._words = (self._words + got)[-8 * _LAST_WORDS :]

    def _answer(self, due_ns: int, number: int) -> None:
        """Write the key at its time."""
        while (now_ns := time.monotonic_ns()) < due_ns:
            pass
        os.write(self._fd, ANSWER_KEY.encode())
        time.sleep(REST_S)
        self.trials.append(RobotTrial(number=number, read_ns=self._read_ns[number], written_ns=now_ns))

    def _last_words(self) -> str:
        words = _CONTROL.sub("", self._words.decode(errors="replace")).strip()
        return f"Its last words:\n{words[-_LAST_WORDS:]}"


def run_plan(plan: Plan, on_trial: Callable[[], None] = lambda: None) -> tuple[list[RobotTrial], Seen]:
    """Run a plan; return what the robot did and what the app saw. Call it in the main thread.

    Raises:
        TimingError: it could not be carried out.
    """
    remove_left_behind()
    private = tempfile.TemporaryDirectory(prefix=prefix_of("timing"))
    with private as folder, Robot(plan, Path(folder)) as robot:
        seen = robot.run(START_UP_S + plan.longest_s, on_trial)
        return robot.trials, seen


def _program(plan: Plan) -> str:
    return "arl_tui.timing.bare" if plan.condition == "bare reader" else "arl_tui.timing.subject"


def _environment() -> dict[str, str]:
    """Return an environment in which the app behaves as in a plain local terminal, drawing as live sessions
    do.
    """
    environment = {
        **os.environ,
        "TERM": "xterm-256color",
        "COLORTERM": "truecolor",
        "TEXTUAL_DISABLE_KITTY_KEY": "1",
        "TEXTUAL_FPS": FRAMES_PER_S,
        "PYTHONPATH": os.pathsep.join(filter(None, [str(REPOSITORY), os.environ.get("PYTHONPATH")])),
    }
    for name in ("TMUX", "STY", "SSH_CONNECTION", "NO_COLOR", "TEXTUAL_DRIVER"):
        environment.pop(name, None)
    return environment
