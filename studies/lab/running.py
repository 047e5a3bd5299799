"""One sitting of a participant at a time: a lock that the system frees however the program ends."""

import os
import sys
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

from studies.lab.enrolment import NotNow

if sys.platform != "win32":
    import fcntl

NAME = ".running"


@contextmanager
def only_sitting(folder: Path, code: str) -> Iterator[None]:
    """Hold a participant's folder while the block runs.

    Args:
        folder: of the participant; made where it is missing.
        code: of the participant.

    Raises:
        NotNow: another sitting of this participant is running.
    """
    folder.mkdir(mode=0o700, parents=True, exist_ok=True)
    handle = os.open(folder / NAME, os.O_CREAT | os.O_RDWR, 0o600)
    try:
        if sys.platform != "win32":
            try:
                fcntl.flock(handle, fcntl.LOCK_EX | fcntl.LOCK_NB)
            except BlockingIOError as error:
                raise NotNow(
                    f"a sitting of {code} is running already, in another window or on another computer: end "
                    f"it there first"
                ) from error
        yield
    finally:
        os.close(handle)
