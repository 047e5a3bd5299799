"""Temporary files that say in their names which process made them.

A program that is killed cannot remove its files. The next one recognises them by their names and removes
them. Rescue copies of recordings have other names: they are never removed (`arl_tui.recordings`).
"""

import atexit
import contextlib
import os
import re
import shutil
import sys
import tempfile
from pathlib import Path
from typing import Final, Literal

Kind = Literal["worker", "watch", "timing", "copy"]
"""Error output of a learner's process; a viewer's folder; a folder of `arl timing`; a recording that a viewer
has unpacked or put right."""
_OURS: Final = re.compile(r"arl-(worker|watch|timing|copy)-(\d+)-")
_COPY_OF_EARLIER_VERSIONS: Final = re.compile(r"arl-[0-9a-f]{24}\.jsonl")


def prefix_of(kind: Kind) -> str:
    """Return how the names of this process's temporary files of a kind begin."""
    return f"arl-{kind}-{os.getpid()}-"


def is_of_this_process(path: Path) -> bool:
    """Return whether this process, or its parent, has made a temporary file: it stays while this one runs."""
    found = _OURS.match(path.name)
    return found is not None and int(found[2]) in (os.getpid(), os.getppid())


def own_number() -> int:
    """Return the number of the user who runs this program; 0 on Windows."""
    return 0 if sys.platform == "win32" else os.getuid()


def is_own(path: Path) -> bool:
    """Return whether a file is of the user who runs this program.

    Raises:
        OSError: there is no such file.
    """
    return path.lstat().st_uid == own_number()


def remove_at_end(path: Path) -> None:
    """Remove a file when this program ends, if it is there then."""
    atexit.register(path.unlink, missing_ok=True)


def remove_left_behind() -> int:
    """Remove what killed programs have left in the folder for temporary files; return how many went.

    Files of other users, and of programs that run, stay. Nothing is done on Windows.
    """
    if sys.platform == "win32":
        return 0
    removed = 0
    with contextlib.suppress(OSError):  # the folder cannot be listed
        for path in Path(tempfile.gettempdir()).iterdir():
            with contextlib.suppress(OSError):  # removed by another program meanwhile
                if _is_left_behind(path.name) and is_own(path):
                    _remove(path)
                    removed += 1
    return removed


def _is_left_behind(name: str) -> bool:
    found = _OURS.match(name)
    if found is None:
        return _COPY_OF_EARLIER_VERSIONS.fullmatch(name) is not None
    return not is_running(int(found[2]))


def _remove(path: Path) -> None:
    if path.is_dir() and not path.is_symlink():
        shutil.rmtree(path)
    else:
        path.unlink()


def is_running(pid: int) -> bool:
    """Return whether there is a process of this number, of any user (POSIX)."""
    try:
        os.kill(pid, 0)
    except (ProcessLookupError, OverflowError):
        return False
    except OSError:
        return True  # another user's
    return True
