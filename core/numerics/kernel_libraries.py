"""What the code of kernels is collected in: of parts, which are linked into others, and of entries, which are
run.
"""

from typing import Any

from llvmlite import binding as llvm
from numba.core.codegen import JITCodeLibrary

Types = tuple[Any, ...]
"""Numba types of a kernel's arguments."""


class PartLibrary(JITCodeLibrary):
    """LLVM code of a part: linked into entries, never turned into native code by itself."""

    owner: tuple[str, Types] = ("", ())
    """Name and argument types of the kernel."""
    symbol = ""
    """Under which its callers find it; another one each time it is compiled."""
    environment: Any = None

    def _optimize_functions(self, ll_module: Any) -> None:
        """Simplify cheaply: the optimisation that counts is the entry's."""
        ll_module.data_layout = self._codegen._data_layout
        passes, builder = self._codegen._function_pass_manager(opt=1)
        for function in ll_module.functions:
            if not function.is_declaration:
                passes.run(function, builder)

    def finalize(self) -> None:
        """Take in what numba compiled for this function alone, and leave other kernels' parts outside."""
        self._raise_if_finalized()
        for library in dict.fromkeys(self._linking_libraries):
            if not isinstance(library, PartLibrary | CalledLibrary):
                self._reload_init.update(library._reload_init)
                self._final_module.link_in(library._get_module_for_linking(), preserve=True)
        self.seal()

    def seal(self) -> None:
        """Let the module be linked into several entries."""
        for function in self._final_module.functions:
            if not function.is_declaration and function.linkage == llvm.Linkage.external:
                function.linkage = "linkonce_odr"
        self._finalize_dynamic_globals()
        self._shared_module = self._final_module
        self._finalized = True

    @property
    def parts(self) -> "list[PartLibrary | CalledLibrary]":
        """The parts this one calls."""
        libraries = dict.fromkeys(self._linking_libraries)
        return [library for library in libraries if isinstance(library, PartLibrary | CalledLibrary)]


class NativeLibrary(JITCodeLibrary):
    """Native code of a kernel and of all parts it reaches, but for those that are native code already."""

    called: "tuple[CalledLibrary, ...]" = ()
    """Native code that this code calls. It must be loaded before this is."""

    def finalize(self) -> None:
        """Link all parts in, optimise once, and compile."""
        reached = _reached(self._linking_libraries)
        self.called = tuple(library for library in reached if isinstance(library, CalledLibrary))
        self._linking_libraries = [library for library in reached if not isinstance(library, CalledLibrary)]
        super().finalize()


class EntryLibrary(NativeLibrary):
    """What Python calls."""


class CalledLibrary(NativeLibrary):
    """What several entries call: compiled once for all of them."""

    owner: tuple[str, Types] = ("", ())
    symbol = ""
    environment: Any = None


def _reached(libraries: list[Any]) -> dict[Any, None]:
    """Return libraries and the parts that these call, directly or not, each once, in a fixed order."""
    seen: dict[Any, None] = {}
    waiting = list(reversed(libraries))
    while waiting:
        library = waiting.pop()
        if library not in seen:
            seen[library] = None
            if isinstance(library, PartLibrary):
                waiting.extend(reversed(library.parts))
    return seen
