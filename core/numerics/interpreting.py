"""Kernels as plain Python until they are compiled, and how far the compiling is.

Compiling everything that a session runs takes seconds; its first game can be played by the very same
functions, run by Python instead. Both give the same bits (tested, on Linux, where both call the C library's
functions; elsewhere nothing is interpreted). A watched game asks for a decision every few tenths of a second,
and Python makes one in milliseconds.

A kernel's twin is its own code object with other globals: there, every kernel is its twin, too.
"""

import json
import sys
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from dataclasses import dataclass
from types import FunctionType
from typing import Any

from core.numerics.kernel_folder import JIT_DISABLED, READY, kernel_files

if not JIT_DISABLED:
    from core.numerics.kernel_dispatch import ENTRY, PART, Kernel, by_name

CAN_INTERPRET = sys.platform == "linux" and not JIT_DISABLED
"""Whether plain Python is known to give the bits of compiled code here."""
OPTIMISED = 0.35
"""What optimising a piece of code takes, as a fraction of what writing its parts took (measured)."""

_twins: dict[str, Callable[..., Any]] = {}
_globals: dict[int, dict[str, Any]] = {}
_met: dict[str, tuple["Kernel", tuple[Any, ...]]] = {}
"""Entries that Python has asked for while kernels were interpreted, and the types of the first call's
arguments."""


@dataclass(frozen=True, slots=True)
class Progress:
    """How far compiling is."""

    compiled: int
    """Kernels of which there is compiled code."""
    needed: int
    """Kernels that are needed, >= compiled."""
    fraction: float
    """Fraction of the work that is done, in [0, 1]: kernels weighted by their length, and whole pieces by
    their parts."""


def twin(kernel: "Kernel") -> Callable[..., Any]:
    """Return a kernel as plain Python, down to the last kernel it calls."""
    if kernel.in_python is not None:
        return kernel.in_python
    found = _twins.get(kernel.name)
    if found is None:
        function = kernel.py_func
        found = FunctionType(
            function.__code__,
            _twin_globals(function.__globals__),
            function.__name__,
            function.__defaults__,
            function.__closure__,
        )
        _twins[kernel.name] = found
    return found


def _twin_globals(names: dict[str, Any]) -> dict[str, Any]:
    found = _globals.get(id(names))
    if found is None:
        found = _globals[id(names)] = dict(names)
        for name, value in names.items():
            if isinstance(value, Kernel):
                found[name] = twin(value)
    return found


@contextmanager
def interpreting() -> Iterator[None]:
    """Let Python run kernels in which it finds no compiled code in this process; nothing waits for a
    compiler.
    """
    start_interpreting()
    try:
        yield
    finally:
        stop_interpreting()


def start_interpreting() -> None:
    """Do what `interpreting` does, until `stop_interpreting`."""
    if CAN_INTERPRET:
        Kernel.fallback = _stand_in


def is_interpreting() -> bool:
    """Return whether Python stands in for kernels that are not compiled yet."""
    return not JIT_DISABLED and Kernel.fallback is not None


def stop_interpreting() -> None:
    """Compile kernels, or load them, from the next call on."""
    if not JIT_DISABLED:
        Kernel.fallback = None


def _stand_in(kernel: "Kernel", arguments: tuple[Any, ...]) -> Callable[..., Any]:
    if kernel.name not in _met:
        _met[kernel.name] = kernel, tuple(kernel.typeof_pyval(argument) for argument in arguments)
    return twin(kernel)


def load_interpreted() -> None:
    """Load all that has been interpreted so far, and compile what is not there; Python goes on meanwhile."""
    for kernel, types in list(_met.values()):
        kernel.compile(types)


# --- how far compiling is -----------------------------------------------------------------------------------


def progress() -> Progress:
    """Return how far compiling is of what has been interpreted so far: a look at the folder, no more."""
    if JIT_DISABLED or not _met:
        return Progress(0, 0, 1.0)
    needed: dict[str, float] = {}
    for kernel, _ in list(_met.values()):
        reached = _reached(kernel)
        parts = {f"{part.name}.{PART}": _length(part) for part in reached if part is not kernel}
        needed |= parts
        needed[f"{kernel.name}.{ENTRY}"] = _length(kernel) + OPTIMISED * sum(parts.values())
    there = Kernel.files.names()
    done = {name: weight for name, weight in needed.items() if name in there}
    return Progress(len(done), len(needed), sum(done.values()) / sum(needed.values()))


def _reached(kernel: "Kernel") -> list["Kernel"]:
    """Return a kernel and all kernels that it calls, directly or not."""
    seen: dict[str, Kernel] = {}
    waiting = [kernel]
    while waiting:
        found = waiting.pop()
        if found.name not in seen:
            seen[found.name] = found
            names = found.py_func.__globals__
            called = (names.get(name) for name in found.py_func.__code__.co_names)
            waiting.extend(other for other in called if isinstance(other, Kernel))
    return list(seen.values())


def _length(kernel: "Kernel") -> float:
    return float(len(kernel.py_func.__code__.co_code))


def kernel_notes() -> list[str]:
    """Return why programs are slower than they could be, one line per reason
    (`core.numerics.kernel_files`).
    """
    return [] if JIT_DISABLED else list(Kernel.files.notes)


# --- what a purpose needs -----------------------------------------------------------------------------------


def entries_at_hand() -> list[str]:
    """Return the names of the files of all entries this process has compiled or loaded."""
    if JIT_DISABLED:
        return []
    return [
        Kernel.files.path(f"{kernel.name}.{ENTRY}", kernel._key(ENTRY, args)).name
        for kernel in list(by_name.values())
        for args in list(kernel.overloads)
    ]


def note_ready(purpose: str) -> None:
    """Write down that everything a purpose needs is compiled: the entries at hand."""
    if not JIT_DISABLED:
        kernel_files().save(READY, purpose, json.dumps(entries_at_hand()).encode())
