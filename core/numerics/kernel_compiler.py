"""Numba's compiler, told what to compile into: parts, which are linked, and entries, which Python calls."""

import gc
from collections.abc import Iterator
from contextlib import contextmanager
from typing import Any

from numba.core import compiler
from numba.core.codegen import JITCodeLibrary
from numba.core.dispatcher import _FunctionCompiler

from core.numerics.kernel_libraries import CalledLibrary, EntryLibrary, PartLibrary, Types


class _Flags(compiler.Flags):
    """Numba's, compared by what is set: it compares all 40 options at every look-up of a type, a tenth of all
    time.
    """

    __slots__ = ()

    def __eq__(self, other: object) -> bool:
        return self is other or (isinstance(other, _Flags) and self._values == other._values)

    def __hash__(self) -> int:
        return hash(_Flags)


class KernelCompiler(_FunctionCompiler):
    """Numba's, told what to compile into."""

    def part(self, args: Types, library: PartLibrary | CalledLibrary) -> Any:
        """Compile a part."""
        return self._into(args, library, no_compile=True, no_cpython_wrapper=True)

    def entry(self, args: Types, library: EntryLibrary) -> Any:
        """Compile an entry."""
        return self._into(args, library, no_compile=False, no_cpython_wrapper=False)

    def _into(self, args: Types, library: JITCodeLibrary, **how: bool) -> Any:
        flags = _Flags()
        self.targetdescr.options.parse_as_flags(flags, self.targetoptions)
        for name, value in how.items():
            setattr(flags, name, value)
        return compiler.compile_extra(
            self.targetdescr.typing_context,
            self.targetdescr.target_context,
            self.py_func,
            args=args,
            return_type=None,
            flags=flags,
            locals=self.locals,
            library=library,
            pipeline_class=self.pipeline_class,
        )


@contextmanager
def no_collections() -> Iterator[None]:
    """Keep Python from looking for garbage: a compiler makes many objects, and most of them stay until it has
    ended.
    """
    was_enabled = gc.isenabled()
    gc.disable()
    try:
        yield
    finally:
        if was_enabled:
            gc.enable()
