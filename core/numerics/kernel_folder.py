"""Where compiled code of these sources is kept, and what of it is ready. Loads no compiler: screens ask this.

A stale kernel would give results that no source explains. So the folder of compiled code is named after a
digest of all sources that may hold or feed a kernel: other sources, other kernels. Importing this module
creates nothing.
"""

import hashlib
import json
import os
from contextlib import suppress
from functools import cache
from pathlib import Path

from core.numerics.kernel_files import KernelFiles

JIT_DISABLED: bool = os.environ.get("NUMBA_DISABLE_JIT", "0") not in ("", "0")
"""True under NUMBA_DISABLE_JIT=1, where kernels run as plain Python."""
READY = "ready"
"""Name of the notes on what has been compiled."""


def sources_digest() -> str:
    """Return a digest of every source file that may hold or feed a kernel.

    All of `core`, and of `studies` the files with kernels: those take constants only from `core` and each
    other.
    """
    root = Path(__file__).resolve().parents[2]
    digest = hashlib.sha256()
    for package in ("core", "studies"):
        for path in sorted((root / package).rglob("*.py")):
            source = path.read_bytes()
            if package == "core" or b"core.numerics.compiled" in source:
                digest.update(path.relative_to(root).as_posix().encode() + b"\0" + source + b"\0")
    return digest.hexdigest()[:16]


def cache_folder(digest: str) -> tuple[Path, bool]:
    """Return where compiled code of these sources belongs, and whether old folders beside it may be removed.

    `NUMBA_CACHE_DIR` decides where it is set, and nothing beside it is touched; else it is the user's cache.
    The folder is this user's alone, also where several users share the place.
    """
    owner = f"-{os.getuid()}" if hasattr(os, "getuid") else ""
    chosen = os.environ.get("NUMBA_CACHE_DIR")
    if chosen:
        return Path(chosen).absolute() / f"arl-{digest}{owner}", False
    base = Path(os.environ.get("XDG_CACHE_HOME") or Path.home() / ".cache")
    return base / "arl-tui" / "kernels" / f"{digest}{owner}", True


@cache
def kernel_files() -> KernelFiles:
    """Return the compiled code of these sources: one object in a process."""
    folder, pruned = cache_folder(sources_digest())
    return KernelFiles(folder, pruned=pruned)


def is_ready(purpose: str) -> bool:
    """Return whether all that a purpose needs is compiled, by what `core.numerics.interpreting.note_ready`
    wrote down.

    Args:
        purpose: what is to be run, as text: everything that decides about it.
    """
    if JIT_DISABLED:
        return True
    files = kernel_files()
    written = files.load(READY, purpose)
    if written is None:
        return False
    with suppress(ValueError):
        return all((files.folder / name).exists() for name in json.loads(written))
    return False
