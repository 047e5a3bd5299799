"""The one place where kernels are decorated, and where the folder of compiled code is chosen.

Every compiled function of the project is decorated with `kernel` or `inner_kernel`, so that all of them
release the GIL, are kept on disk, and keep IEEE arithmetic (no fast-math: sums are the same on every CPU).

A stale kernel would give results that no source explains. So the folder of compiled code is named after a
digest of all sources that may hold or feed a kernel: other sources, other kernels. Importing this module
creates nothing.
"""

import hashlib
import os
from collections.abc import Callable
from pathlib import Path
from typing import Any, TypeVar, cast

Function = TypeVar("Function", bound=Callable[..., Any])

ALWAYS: dict[str, Any] = {"nopython": True, "nogil": True, "no_cfunc_wrapper": True, "boundscheck": None}
"""How all kernels are compiled; a wrapper for callers in C, of which there are none, would take it an eighth
longer."""
INNER: dict[str, Any] = {"_nrt": False, "forceinline": True, "error_model": "numpy"}
"""How inner kernels are compiled: without reference counts, into their callers, divisions without
exceptions."""
JIT_DISABLED: bool = os.environ.get("NUMBA_DISABLE_JIT", "0") not in ("", "0")
"""True under NUMBA_DISABLE_JIT=1, where kernels run as plain Python."""


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


if not JIT_DISABLED:
    import numba

    from core.numerics.kernel_dispatch import Kernel
    from core.numerics.kernel_files import KernelFiles

    _folder, _pruned = cache_folder(sources_digest())
    Kernel.files = KernelFiles(_folder, pruned=_pruned)


def kernel(function: Function) -> Function:
    """Compile `function` on its first call; released GIL, kept on disk, no fast-math."""
    return _compiled(function)


def inner_kernel(function: Function) -> Function:
    """Compile a part of other kernels: it becomes one piece with its callers, and counts no references.

    Several times as fast for small functions that get rows of arrays (`docs/decisions/inner-kernels.md`). In
    return it allocates no array and returns none, a division by zero gives inf or nan, and Python may call it
    (tests do) unless it takes a Generator, of which every such call would keep a reference for good.
    """
    return _compiled(function, **INNER)


def kernel_with_twin(function: Function, in_python: Callable[..., Any]) -> Function:
    """Compile `function`; where kernels run as plain Python, `in_python` stands for it.

    Args:
        function: cannot run as plain Python, because its arithmetic means something else there.
        in_python: gives the same results.
    """
    if JIT_DISABLED:
        return cast(Function, in_python)
    compiled = _compiled(function)
    cast(Any, compiled).in_python = in_python
    return compiled


def _compiled(function: Function, **options: Any) -> Function:
    if JIT_DISABLED:
        return function
    return cast(Function, Kernel(function, targetoptions=ALWAYS | options))


def specialised(function: Function, *arguments: Any) -> Function:
    """Return a kernel compiled for arguments of these types, without the look-up of types at every call.

    The look-up takes half a millisecond for tuples of many arrays. Nobody checks any more that arguments
    are of these types: pass what you passed here, with other contents.
    """
    if JIT_DISABLED:
        return function
    typeof = cast(Any, numba.typeof)
    return cast(Function, cast(Any, function).compile(tuple(typeof(argument) for argument in arguments)))
