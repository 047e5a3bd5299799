"""Compiled code on disk: one file per piece, whose checksum is verified before anything of it is loaded.

Loading native code that was cut or changed can end the process, so a file whose checksum is wrong counts as
absent: its code is compiled again and the file is replaced. Whatever is wrong with the folder (full,
unwritable, another user's), programs get slower and go on. `notes` says why, one line per reason.

Numba's own cache has no checksum, one index per kernel that may contradict its data files, and no answer to a
full disk (numba issues 10434, 9348, 10128, 5566).
"""

import atexit
import hashlib
import os
import shutil
import stat
import sys
import tempfile
import warnings
import weakref
from collections.abc import Iterator
from contextlib import contextmanager, suppress
from pathlib import Path

if sys.platform != "win32":
    import fcntl

MAGIC = b"arl kernel 1\n"
SUFFIX = ".kernel"
IN_USE = "in-use"
"""File that every program with open compiled code holds, shared; a program that removes the folder holds
it alone."""
KEPT_FOLDERS = 4
"""Folders of compiled code that are kept: those of the sources used last."""
OLD_FORMAT_S = 86_400.0
"""A folder of an earlier version has no `IN_USE` file: it is removed when it has not been used for so long,
seconds."""
NO_FILE = "<arl>"
"""Where warnings come from, in the place of a source file."""
_DIGEST_BYTES = 32
_OURS_ONLY = stat.S_IWGRP | stat.S_IWOTH


class KernelCacheWarning(UserWarning):
    """Compiled code cannot be kept, or what was kept cannot be used; programs go on and are slower."""


class KernelFiles:
    """The folder of compiled code of one state of the sources.

    Nothing is created before the first `save` or `turn`.
    """

    def __init__(self, folder: Path, *, pruned: bool) -> None:
        """Take a folder.

        Args:
            folder: of this state of the sources; others lie beside it.
            pruned: remove the folders beside it that were used longest ago when this one is made.
        """
        self.folder = folder
        self.notes: list[str] = []
        """Why programs are slower than they could be: one line per reason."""
        self._pruned = pruned
        self._in_use: object = None
        self._opened = False

    # --- files ----------------------------------------------------------------------------------------------

    def path(self, name: str, key: str) -> Path:
        """Return the file of one piece of code.

        Args:
            name: of the kernel.
            key: everything else that decides about the code, as text.
        """
        return self.folder / f"{name}-{hashlib.sha256(key.encode()).hexdigest()[:20]}{SUFFIX}"

    def load(self, name: str, key: str) -> bytes | None:
        """Return what was saved; None where nothing was, or where it cannot be trusted."""
        path = self.path(name, key)
        try:
            with path.open("rb") as file:
                status = os.fstat(file.fileno())
                content = file.read()
        except FileNotFoundError:
            return None
        except OSError as error:
            self.note(f"compiled code in {self.folder} cannot be read ({error.strerror}): compiling anew")
            return None
        if not _is_ours(status):
            self.note(f"compiled code in {self.folder} is another user's: compiling anew")
            return None
        self._hold()
        payload = _verified(content)
        if payload is None:
            self.note(f"compiled code in {self.folder} is damaged ({path.name}): compiling it anew")
        return payload

    def save(self, name: str, key: str, payload: bytes) -> None:
        """Keep a piece of code; where that is impossible, say so once and go on."""
        self._open()
        path = self.path(name, key)
        try:
            handle, part = tempfile.mkstemp(prefix=".part-", dir=self.folder)
            try:
                with os.fdopen(handle, "wb") as file:
                    file.write(MAGIC + hashlib.sha256(payload).digest() + payload)
                os.replace(part, path)
            except OSError:
                with suppress(OSError):
                    os.unlink(part)
                raise
        except OSError as error:
            self.note(f"compiled code cannot be kept in {self.folder} ({error.strerror}): starts stay slow")

    def names(self) -> set[str]:
        """Return the names of the kernels of which there is code, without looking into the files."""
        try:
            entries = os.listdir(self.folder)
        except OSError:
            return set()
        return {entry.rpartition("-")[0] for entry in entries if entry.endswith(SUFFIX)}

    @contextmanager
    def turn(self, name: str) -> Iterator[None]:
        """Wait until no other process holds this name, and hold it; where files cannot be held, go on at
        once.
        """
        self._open()
        if sys.platform == "win32":  # every process compiles for itself
            yield
            return
        try:
            held = (self.folder / f"{name}.lock").open("wb")
        except OSError:  # unwritable, or just removed
            yield
            return
        with held:
            with suppress(OSError):
                fcntl.flock(held, fcntl.LOCK_EX)
            yield

    def note(self, line: str) -> None:
        """Say once why programs are slower."""
        if line not in self.notes:
            self.notes.append(line)
            # Without a place in the source, which tells a user nothing: one line. Python prints the source,
            # too, where it finds a file of this name.
            warnings.warn_explicit(line, KernelCacheWarning, NO_FILE, 1)

    # --- the folder -----------------------------------------------------------------------------------------

    def _open(self) -> None:
        """Make the folder, for its owner alone; a temporary one in its place where that is impossible."""
        if self._opened and self.folder.is_dir():
            return
        self._opened = True
        is_new = not self.folder.is_dir()
        try:
            _make_private(self.folder)
            with tempfile.TemporaryFile(dir=self.folder):
                self._hold()
        except OSError as error:
            self._replace(error.strerror or str(error))
            return
        if is_new and self._pruned:
            forget_old_folders(self.folder.parent)

    def _replace(self, reason: str) -> None:
        refused = self.folder
        self.folder = Path(tempfile.mkdtemp(prefix="arl-tui-kernels-"))
        # Programs started by this one share it.
        os.environ["NUMBA_CACHE_DIR"] = str(self.folder)
        atexit.register(shutil.rmtree, self.folder, ignore_errors=True)
        self.note(f"compiled code cannot be kept in {refused} ({reason}): starts stay slow")

    def _hold(self) -> None:
        """Hold the folder against removal while this program runs, and note when it was used."""
        if self._in_use is not None or sys.platform == "win32":
            return
        with suppress(OSError):
            in_use = os.open(self.folder / IN_USE, os.O_RDWR | os.O_CREAT, 0o600)
            self._in_use = weakref.finalize(self, os.close, in_use)
            fcntl.flock(in_use, fcntl.LOCK_SH | fcntl.LOCK_NB)
            os.utime(self.folder)


def _is_ours(status: os.stat_result) -> bool:
    """Return whether only this user (or the system's) could have written a file."""
    if sys.platform == "win32":
        return True
    return status.st_uid in (os.geteuid(), 0) and not status.st_mode & _OURS_ONLY


def _verified(content: bytes) -> bytes | None:
    """Return a file's payload; None where the file is not what was written."""
    begin = len(MAGIC) + _DIGEST_BYTES
    payload = content[begin:]
    written = content[len(MAGIC) : begin]
    whole = content.startswith(MAGIC) and hashlib.sha256(payload).digest() == written
    return payload if whole else None


def _make_private(folder: Path) -> None:
    """Make a folder and what is missing above it, for its owner alone.

    Raises:
        OSError: it cannot be made, or belongs to another user.
    """
    missing = [folder, *(parent for parent in folder.parents if not parent.exists())]
    for part in reversed(missing):
        part.mkdir(mode=0o700, exist_ok=True)
    status = folder.stat()
    if sys.platform != "win32" and status.st_uid != os.geteuid():
        raise PermissionError(0, "the folder is another user's")
    if stat.S_IMODE(status.st_mode) != 0o700:
        folder.chmod(0o700)


def forget_old_folders(base: Path) -> int:
    """Remove the folders used longest ago, but none that a running program holds; return how many went."""
    if sys.platform == "win32":
        return 0
    try:
        folders = sorted((path for path in base.iterdir() if path.is_dir()), key=_last_used, reverse=True)
    except OSError:
        return 0
    return sum(_forget(old, now=_last_used(folders[0])) for old in folders[KEPT_FOLDERS:])


def _forget(old: Path, *, now: float) -> bool:
    """Remove a folder unless a program uses it; return whether it went."""
    if not (old / IN_USE).exists():
        if now - _last_used(old) < OLD_FORMAT_S:
            return False
        shutil.rmtree(old, ignore_errors=True)
        return True
    try:
        with (old / IN_USE).open("ab") as in_use:
            fcntl.flock(in_use, fcntl.LOCK_EX | fcntl.LOCK_NB)
            # Under another name first: a program that starts now makes a new folder instead of finding half
            # of this one.
            doomed = old.with_name(f".{old.name}-{os.getpid()}")
            old.rename(doomed)
            shutil.rmtree(doomed, ignore_errors=True)
    except OSError:  # in use, or gone already
        return False
    return True


def _last_used(folder: Path) -> float:
    try:
        return folder.stat().st_mtime
    except OSError:  # another process has just removed it
        return 0.0
