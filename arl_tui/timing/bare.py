"""The least program that could be tested: writes a marker, waits for a key, without any screen library.

Its errors are what this machine and its pseudo-terminals add to all participants' times. Run by the robot as
`python -m arl_tui.timing.bare PLAN SEEN PARENT`; writes what it saw to the file SEEN.
"""

import os
import select
import sys
import termios
import time
import tty
from pathlib import Path

import msgspec

from arl_tui.timing.plan import ANSWER_KEY, GAP_S, START_UP_S, TIME_OUT_S, Answered, Plan, Seen, marker
from core.system.processes import leave_with

TIME_OUT_NS = round(TIME_OUT_S * 1e9)


def run(plan: Plan, in_fd: int, out_fd: int) -> Seen:
    """Run the trials of a plan in a raw terminal."""
    answers = []
    began_ns = time.monotonic_ns()
    for trial in plan.trials:
        time.sleep(GAP_S + trial.foreperiod_ms / 1000)
        termios.tcflush(in_fd, termios.TCIFLUSH)  # Pressed before there was anything to see.
        flushed_ns = time.monotonic_ns()
        os.write(out_fd, marker(trial.number).encode())
        answers.append(
            Answered(
                number=trial.number, flushed_ns=flushed_ns, key_ns=_key_time(in_fd, flushed_ns + TIME_OUT_NS)
            )
        )
    return Seen(answers=tuple(answers), board_frames=0, duration_ns=time.monotonic_ns() - began_ns)


def _key_time(fd: int, until_ns: int) -> int | None:
    """Return when the answer was read; None where it did not come in time."""
    while (left_ns := until_ns - time.monotonic_ns()) > 0:
        ready, _, _ = select.select([fd], [], [], left_ns / 1e9)
        if not ready:
            return None
        keys = os.read(fd, 64)
        now_ns = time.monotonic_ns()
        if ANSWER_KEY.encode() in keys:
            return now_ns
        if not keys:
            raise SystemExit("the terminal has gone")
    return None


def main(plan_path: str, seen_path: str, parent: str) -> None:
    """Run a plan from a file and write what was seen to another."""
    plan = msgspec.json.decode(Path(plan_path).read_bytes(), type=Plan)
    leave_with(int(parent), started_by_main_thread=True, longest_s=START_UP_S + plan.longest_s)
    in_fd, out_fd = sys.stdin.fileno(), sys.stdout.fileno()
    tty.setraw(in_fd)
    Path(seen_path).write_bytes(msgspec.json.encode(run(plan, in_fd, out_fd)))


if __name__ == "__main__":
    main(*sys.argv[1:])
