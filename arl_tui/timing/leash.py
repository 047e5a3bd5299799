"""A child that cannot outlive its parent, nor run for ever."""

import ctypes
import os
import signal
import sys

_PR_SET_PDEATHSIG = 1


def tie_to_parent(parent: int, longest_s: float) -> None:
    """Have this process killed when its parent ends (Linux), and after `longest_s` seconds in any case
    (POSIX).

    Args:
        parent: process id of the parent; if it is gone already, this process leaves at once.
        longest_s: seconds, rounded up.
    """
    signal.alarm(int(longest_s) + 1)
    if sys.platform == "linux":
        # No thread of the parent but the one that started us counts: it must be the parent's main thread.
        ctypes.CDLL(None, use_errno=True).prctl(_PR_SET_PDEATHSIG, signal.SIGKILL)
    if os.getppid() != parent:
        raise SystemExit("the process that started this one has gone")
