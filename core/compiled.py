"""The one place where numba is imported: sets the cache folder first, then offers the `kernel` decorator.

Every compiled function of the project is decorated with `kernel`, so that all of them release the GIL, are
cached on disk, and keep IEEE arithmetic (no fast-math: sums are the same on every CPU).
"""

import os
import tempfile
from collections.abc import Callable
from pathlib import Path
from typing import Any, TypeVar, cast

Function = TypeVar("Function", bound=Callable[..., Any])


def _cache_folder() -> str:
    """Return a writable folder for compiled code; a temporary one where the user's cache is read-only."""
    base = os.environ.get("XDG_CACHE_HOME") or str(Path.home() / ".cache")
    folder = Path(base) / "arl-tui" / "kernels"
    try:
        folder.mkdir(parents=True, exist_ok=True)
        with tempfile.TemporaryFile(dir=folder):
            return str(folder)
    except OSError:
        return tempfile.mkdtemp(prefix="arl-tui-kernels-")


# Before numba is imported: it reads the variable once (and refuses to cache in a read-only installation).
os.environ.setdefault("NUMBA_CACHE_DIR", _cache_folder())

import numba


def kernel(function: Function) -> Function:
    """Compile `function` on its first call; released GIL, cached on disk, no fast-math."""
    return cast(Function, numba.njit(cache=True, nogil=True)(function))


JIT_DISABLED: bool = os.environ.get("NUMBA_DISABLE_JIT", "0") not in ("", "0")
"""True under NUMBA_DISABLE_JIT=1, where kernels run as plain Python."""
