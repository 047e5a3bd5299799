"""The one place where numba is imported: sets the cache folder first, then offers the `kernel` decorator.

Every compiled function of the project is decorated with `kernel`, so that all of them release the GIL, are
cached on disk, and keep IEEE arithmetic (no fast-math: sums are the same on every CPU).

Numba notices when the file of a compiled function changes, but not when a function it calls in another file does, or a
table. A stale kernel would give results that no source explains. So the cache folder is named after a digest
of all sources that may hold or feed a kernel: other sources, other kernels.
"""

import hashlib
import os
import shutil
import tempfile
from collections.abc import Callable
from pathlib import Path
from typing import Any, TypeVar, cast

Function = TypeVar("Function", bound=Callable[..., Any])

KEPT_CACHES = 4
"""Folders of compiled code that are kept: those of the sources used last."""


def _sources_digest() -> str:
    """Return a digest of every source file that may hold or feed a kernel.

    All of `core`, and of `studies` the files with kernels: those take constants only from `core` and each other.
    """
    root = Path(__file__).resolve().parents[1]
    digest = hashlib.sha256()
    for package in ("core", "studies"):
        for path in sorted((root / package).rglob("*.py")):
            source = path.read_bytes()
            if package == "core" or b"core.compiled" in source:
                digest.update(path.relative_to(root).as_posix().encode() + b"\0" + source + b"\0")
    return digest.hexdigest()[:16]


def _cache_folder() -> str:
    """Return a writable folder for compiled code; a temporary one where the user's cache is read-only."""
    base = Path(os.environ.get("XDG_CACHE_HOME") or Path.home() / ".cache") / "arl-tui" / "kernels"
    folder = base / _sources_digest()
    try:
        folder.mkdir(parents=True, exist_ok=True)
        with tempfile.TemporaryFile(dir=folder):
            folder.touch()
    except OSError:
        return tempfile.mkdtemp(prefix="arl-tui-kernels-")
    _forget_old_caches(base)
    return str(folder)


def _forget_old_caches(base: Path) -> None:
    folders = sorted((path for path in base.iterdir() if path.is_dir()), key=_last_used, reverse=True)
    for old in folders[KEPT_CACHES:]:
        shutil.rmtree(old, ignore_errors=True)


def _last_used(folder: Path) -> float:
    try:
        return folder.stat().st_mtime
    except OSError:  # another process has just removed it
        return 0.0


# Before numba is imported: it reads the variable once (and refuses to cache in a read-only installation).
os.environ.setdefault("NUMBA_CACHE_DIR", _cache_folder())

import numba


def kernel(function: Function) -> Function:
    """Compile `function` on its first call; released GIL, cached on disk, no fast-math."""
    return cast(Function, numba.njit(cache=True, nogil=True)(function))


JIT_DISABLED: bool = os.environ.get("NUMBA_DISABLE_JIT", "0") not in ("", "0")
"""True under NUMBA_DISABLE_JIT=1, where kernels run as plain Python."""


def specialised(function: Function, *arguments: Any) -> Function:
    """Return a kernel compiled for arguments of these types, without the look-up of types at every call.

    The look-up takes half a millisecond for tuples of many arrays. Nobody checks any more that arguments
    are of these types: pass what you passed here, with other contents.
    """
    if JIT_DISABLED:
        return function
    compiled, typeof = cast(Any, function), cast(Any, numba.typeof)
    types = tuple(typeof(argument) for argument in arguments)
    compiled.compile(types)
    return cast(Function, compiled.get_overload(types))
