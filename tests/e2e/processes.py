"""The processes of a program under test: which there are, and whether they are gone."""

import time
from contextlib import suppress
from pathlib import Path


def is_running(pid: int) -> bool:
    """Return whether a process exists and is more than an entry that nobody has collected."""
    try:
        state = Path(f"/proc/{pid}/stat").read_text().rpartition(")")[2].split()[0]
    except (FileNotFoundError, ProcessLookupError):
        return False
    return state != "Z"


def children(pid: int) -> set[int]:
    """Return the process ids of all children, whichever thread has started them."""
    found: set[int] = set()
    for task in Path(f"/proc/{pid}/task").glob("*/children"):
        with suppress(FileNotFoundError, ProcessLookupError):
            found |= {int(child) for child in task.read_text().split()}
    return found


def descendants(pid: int) -> set[int]:
    """Return the process ids of all children, their children, and so on."""
    found = children(pid)
    return found.union(*(descendants(child) for child in found))


def worker_of(pid: int) -> int:
    """Return the process id of the worker: the child that runs `spawn_main` (another one tracks
    resources)."""
    for child in descendants(pid):
        if b"spawn_main" in Path(f"/proc/{child}/cmdline").read_bytes():
            return child
    raise AssertionError(f"{pid} has no worker among {descendants(pid)}")


def left_after(pids: set[int], patience_s: float) -> set[int]:
    """Return those processes that still run after so many seconds; at once when none does."""
    end = time.monotonic() + patience_s
    while (left := {pid for pid in pids if is_running(pid)}) and time.monotonic() < end:
        time.sleep(0.02)
    return left


def memory_of(pid: int) -> int:
    """Return the bytes of memory that are a process's own (neither files nor shared with others)."""
    for line in Path(f"/proc/{pid}/status").read_text().splitlines():
        if line.startswith("RssAnon:"):
            return int(line.split()[1]) * 1024
    raise AssertionError(f"no memory of {pid}")
