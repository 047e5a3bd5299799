"""Child processes that do not outlive the process that started them."""

import ctypes
import os
import signal
import sys
import threading
import time

LOOK_S = 1.0
"""How often a child looks whether its parent is still there, seconds."""
_PR_SET_PDEATHSIG = 1


def leave_with(parent: int, *, started_by_main_thread: bool = False, longest_s: float | None = None) -> None:
    """End this process when its parent has gone, however the parent ended: a killed parent leaves no
    processes behind.

    A thread looks once a second. It cannot look while compiled code runs that keeps the interpreter's lock;
    on Linux the kernel ends the process at once where it is asked to.

    Args:
        parent: process id of the parent, taken before this process was started.
        started_by_main_thread: the parent's main thread has started this process. Only then is the kernel
            asked (Linux): it counts the end of the thread that started a process as the end of the parent.
        longest_s: seconds after which this process is ended in any case, rounded up (POSIX); None: never.
    """
    if longest_s is not None:
        signal.alarm(int(longest_s) + 1)
    if started_by_main_thread and sys.platform == "linux":
        ctypes.CDLL(None, use_errno=True).prctl(_PR_SET_PDEATHSIG, signal.SIGKILL)

    def watch() -> None:
        while os.getppid() == parent:
            time.sleep(LOOK_S)
        os._exit(1)

    if os.getppid() != parent:
        os._exit(1)  # it had gone before the kernel was asked

    threading.Thread(target=watch, name="leave-with-parent", daemon=True).start()
