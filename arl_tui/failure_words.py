"""What the system refuses, in words: which file, why, and what to do."""

import errno
import os
from collections.abc import Sequence
from pathlib import Path
from traceback import extract_tb

import click

from arl_tui.standard_streams import DISK_ERRORS
from core.system.bounded_read import EndlessFileError
from core.system.foreign_text import printable_lines

NO_MEMORY = "there is not enough memory for this: name fewer or smaller files, or close other programs"


def in_words(error: OSError, to_write: Sequence[Path]) -> str | None:
    """Return what a system's error means for a user; None where it is none of files and folders.

    Args:
        error: of the system; it need not name the file.
        to_write: paths that the command was to write.
    """
    if error.errno in DISK_ERRORS:
        return disk_failed(error, to_write)
    if "temporary directory" in str(error):  # `tempfile` says where it looked
        return f"{error.strerror}: make room in one of these folders, or let TMPDIR name another"
    if error.filename is None and error.errno == errno.ENOENT and not _here():
        return "the folder in which this command was started is not there any more: `cd` to another one"
    if error.filename is None or error.errno == errno.EPIPE:
        return None
    if isinstance(error, EndlessFileError):
        return str(error)
    return (
        f"{error.filename}: {error.strerror}. Name another file or folder, or see to it that you may use "
        "this one"
    )


def disk_failed(error: OSError, to_write: Sequence[Path] = ()) -> str:
    """Return what could not be written, why, and what to do; arguments as for `in_words`."""
    where, rest = error.filename, ""
    if where is None:
        named = [str(path) for path in to_write if path.exists()]
        printing = extract_tb(error.__traceback__)[-1].filename == click.utils.__file__  # `click.echo`
        where = "what is printed" if printing else " or ".join(named) or "a file"
        rest = "The file that was being written is not whole. "
    return printable_lines(
        f"{where} could not be written: {error.strerror}. {rest}Make room, or name another place, and run "
        f"the command again"
    )


def _here() -> bool:
    try:
        os.getcwd()
    except OSError:
        return False
    return True
