"""Input, output and error output: closed, full, or no terminal."""

import errno
import os
import sys
from typing import TextIO

DISK_ERRORS = (errno.ENOSPC, errno.EDQUOT, errno.EFBIG, errno.EIO, errno.EROFS)
"""A disk is full, a quota used up, a file too large, or the disk failed. The system names no file when that
happens to an open one."""


def why_not_drawable() -> str:
    """Return why nothing can be drawn here or no key be read, in words; "" where both are possible."""
    if not (sys.stdin.isatty() and sys.stdout.isatty()):
        return "needs a terminal to draw in and a keyboard"
    if not sys.stderr.isatty():
        return "draws on the error output, which goes elsewhere here: leave out `2>`"
    if os.environ.get("TERM") == "dumb":
        return (
            "needs a terminal to draw in, and this one cannot draw (TERM=dumb; consoles of editors say so): "
            "open a terminal window"
        )
    return ""


def stand_in_for_closed_ones() -> None:
    """Open what was closed (`<&-`, `>&-`, `2>&-`) on the null device.

    Otherwise the next file that is opened gets the number of the closed stream, and what a child process or a
    library prints ends up in it: in a recording.
    """
    for descriptor, name, mode in ((0, "stdin", "r"), (1, "stdout", "w"), (2, "stderr", "w")):
        try:
            os.fstat(descriptor)
        except OSError:
            opened = os.open(os.devnull, os.O_RDWR)
            if opened != descriptor:
                os.dup2(opened, descriptor)
                os.close(opened)
            os.set_inheritable(descriptor, True)
        if getattr(sys, name) is None:
            stream = open(descriptor, mode, encoding="utf-8", closefd=False)  # noqa: SIM115 - until the end
            setattr(sys, name, stream)
            setattr(sys, f"__{name}__", stream)


def let_go_of_full_ones() -> None:
    """Let output go nowhere if the disk behind it is full: Python would report it again at its end."""
    for stream in (sys.stdout, sys.stderr):
        if _is_full(stream):
            nowhere = os.open(os.devnull, os.O_WRONLY)
            os.dup2(nowhere, stream.fileno())
            os.close(nowhere)


def _is_full(stream: TextIO) -> bool:
    try:
        stream.flush()
    except OSError as error:
        return error.errno in DISK_ERRORS
    except ValueError:  # it is closed
        return False
    return False
