"""The one place where kernels are decorated.

Every compiled function is decorated with `kernel`, `inner_kernel` or `called_kernel`, so that all of them
release the GIL, are kept on disk (`core.numerics.kernel_folder`), and keep IEEE arithmetic (no fast-math:
sums are the same on every CPU).
"""

from collections.abc import Callable
from typing import Any, TypeVar, cast

from core.numerics.kernel_folder import JIT_DISABLED

Function = TypeVar("Function", bound=Callable[..., Any])

ALWAYS: dict[str, Any] = {"nopython": True, "nogil": True, "no_cfunc_wrapper": True, "boundscheck": None}
"""How all kernels are compiled; a wrapper for callers in C, of which there are none, would take it an eighth
longer."""
INNER: dict[str, Any] = {"_nrt": False, "forceinline": True, "error_model": "numpy"}
"""How inner kernels are compiled: without reference counts, into their callers, divisions without
exceptions."""
CALLED: dict[str, Any] = INNER | {"forceinline": False}
"""How called kernels are compiled: as inner ones, and each stays a function."""

if not JIT_DISABLED:
    import numba

    from core.numerics.kernel_dispatch import Kernel


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


def called_kernel(function: Function) -> Function:
    """Compile a part of other kernels as `inner_kernel` does, but as a function that they call.

    For large parts of several entries, and for what is called seldom. An optimiser takes much longer for one
    large function than for the same code in a few, and play loses some 2 % (`docs/decisions/cold-start.md`).
    """
    return _compiled(function, called=True, **CALLED)


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


def _compiled(function: Function, *, called: bool = False, **options: Any) -> Function:
    if JIT_DISABLED:
        return function
    compiled = Kernel(function, targetoptions=ALWAYS | options)
    compiled.stays_a_function = called
    return cast(Function, compiled)


def specialised(function: Function, *arguments: Any) -> Function:
    """Return a kernel compiled for arguments of these types, without the look-up of types at every call.

    The look-up takes half a millisecond for tuples of many arrays. Nobody checks any more that arguments
    are of these types: pass what you passed here, with other contents.
    """
    if JIT_DISABLED:
        return function
    typeof = cast(Any, numba.typeof)
    return cast(Function, cast(Any, function).compile(tuple(typeof(argument) for argument in arguments)))
