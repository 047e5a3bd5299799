"""A file that a program is writing now, told from one that it left behind.

The program holds a lock on the file, which the system takes back when the program ends, however it ends.
"""

import sys
from contextlib import suppress
from pathlib import Path
from typing import IO

if sys.platform != "win32":
    import fcntl


def hold(file: IO[bytes]) -> None:
    """Tell other programs that this one is writing a file, until it is closed (where there are locks)."""
    if sys.platform != "win32":
        with suppress(OSError):
            fcntl.flock(file, fcntl.LOCK_EX | fcntl.LOCK_NB)


def is_held(path: Path) -> bool:
    """Return whether a program is writing a file; False where that is not known."""
    if sys.platform == "win32" or not path.is_file():
        return False
    try:
        with path.open("rb") as file:
            fcntl.flock(file, fcntl.LOCK_SH | fcntl.LOCK_NB)
    except BlockingIOError:
        return True
    except OSError:
        return False
    return False
