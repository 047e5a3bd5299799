"""The one place where numba is imported: sets the cache folder first, then offers the decorators.

Every compiled function of the project is decorated with `kernel` or `inner_kernel`, so that all of them release the GIL,
are cached on disk, and keep IEEE arithmetic (no fast-math: sums are the same on every CPU).

Numba notices when the file of a compiled function changes, but not when a function it calls in another file does, or a
table. A stale kernel would give results that no source explains. So the cache folder is named after a digest
of all sources that may hold or feed a kernel: other sources, other kernels.

Compiling everything takes a minute or two, so processes share the work: while one compiles a kernel, others that need it
wait, and load it from the cache.
"""

import hashlib
import os
import shutil
import sys
import tempfile
from collections.abc import Callable, Iterator
from contextlib import contextmanager, suppress
from pathlib import Path
from typing import Any, TypeVar, cast

Function = TypeVar("Function", bound=Callable[..., Any])

KEPT_CACHES = 4
"""Folders of compiled code that are kept: those of the sources used last."""


def _sources_digest() -> str:
    """Return a digest of every source file that may hold or feed a kernel.

    All of `core`, and of `studies` the files with kernels: those take constants only from `core` and each other.
    """
    root = Path(__file__).resolve().parents[2]
    digest = hashlib.sha256()
    for package in ("core", "studies"):
        for path in sorted((root / package).rglob("*.py")):
            source = path.read_bytes()
            if package == "core" or b"core.numerics.compiled" in source:
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
from numba.core.compiler_lock import global_compiler_lock

if sys.platform != "win32":
    import fcntl

ALWAYS: dict[str, Any] = {"cache": True, "nogil": True, "no_cfunc_wrapper": True}
"""How numba compiles all kernels; a wrapper for callers in C, of which there are none, would take it an eighth longer."""
INNER: dict[str, Any] = {"_nrt": False, "forceinline": True, "error_model": "numpy"}
"""How numba compiles inner kernels: without reference counts, into their callers, divisions without exceptions."""
JIT_DISABLED: bool = os.environ.get("NUMBA_DISABLE_JIT", "0") not in ("", "0")
"""True under NUMBA_DISABLE_JIT=1, where kernels run as plain Python."""


_at_hand: set[str] = set()
"""Names of the kernels that have been compiled, or loaded from the cache, in this process."""


def kernels_at_hand() -> int:
    """Return how many kernels have been compiled, or loaded from the cache, in this process so far."""
    return len(_at_hand)


def kernel(function: Function) -> Function:
    """Compile `function` on its first call; released GIL, cached on disk, no fast-math."""
    return _compiled(function)


def inner_kernel(function: Function) -> Function:
    """Compile a part of other kernels: it becomes one piece with its callers, and counts no references.

    Several times as fast for small functions that get rows of arrays (`docs/decisions/inner-kernels.md`). In return it
    allocates no array and returns none, a division by zero gives inf or nan, and Python may call it
    (tests do) unless it takes a Generator, of which every such call would keep a reference for good.
    """
    return _compiled(function, **INNER)


def _compiled(function: Function, **options: Any) -> Function:
    compiled: Any = numba.njit(**ALWAYS, **options)(function)
    if not JIT_DISABLED:
        compiled.compile = _one_process_at_a_time(
            compiled.compile, f"{function.__module__}.{function.__qualname__}"
        )
    return cast(Function, compiled)


def _one_process_at_a_time(compile_it: Callable[[Any], Any], name: str) -> Callable[[Any], Any]:
    """Return `compile_it` such that processes with the same cache take turns, kernel by kernel.

    A kernel's callees are compiled within its own turn. Kernels do not call each other in circles, so whoever waits holds
    only callers of what it waits for, and nobody waits forever. Threads of a process take turns by numba's own lock, which
    comes first.
    """
    lock_file = Path(os.environ["NUMBA_CACHE_DIR"]) / f"{name}.lock"

    def compile_in_turn(signature: Any) -> Any:
        # Constants in a call would make kernels of their own, of which the optimiser makes the same as of one.
        if isinstance(signature, tuple):
            unliteral = cast(Any, numba.types.unliteral)
            signature = tuple(unliteral(argument) for argument in signature)
        with global_compiler_lock, _turn(lock_file):
            compiled = compile_it(signature)
        _at_hand.add(name)
        return compiled

    return compile_in_turn


@contextmanager
def _turn(lock_file: Path) -> Iterator[None]:
    """Wait until no other process holds the file, and hold it; where files cannot be held, go on at once."""
    if sys.platform == "win32":  # every process compiles for itself
        yield
        return
    try:
        held = lock_file.open("wb")
    except OSError:  # the folder of old sources may have been removed
        yield
        return
    with held:
        with suppress(OSError):
            fcntl.flock(held, fcntl.LOCK_EX)
        yield


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
