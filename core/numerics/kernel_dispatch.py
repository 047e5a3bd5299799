"""How kernels are compiled: each once as a part of others, and as a whole piece of code only where Python
calls it.

Numba compiles every function into native code of its own, with a wrapper for Python, although most of ours
are only ever called by other kernels and become one piece with them. Here a kernel that another one calls
becomes a *part*: its types are inferred and its LLVM code is written and simplified, no more. A kernel that
Python calls becomes an *entry*: all parts it reaches are linked into one module, which is optimised and
turned into native code once. A *called* kernel (`core.numerics.compiled.called_kernel`) is turned into native
code once for all entries that call it. All are kept on disk apart (`core.numerics.kernel_files`), so an entry
that comes later does not begin anew (`docs/decisions/cold-start.md`, with the figures).
"""

import hashlib
import importlib
import pickle
import sys
from collections.abc import Callable
from pathlib import Path
from typing import Any, cast

import llvmlite
import numba
from llvmlite import binding as llvm
from numba.core import compiler, types, typing
from numba.core.compiler_lock import global_compiler_lock
from numba.core.registry import CPUDispatcher
from numba.core.serialize import dumps
from numba.core.sigutils import normalize_signature

from core.numerics.kernel_compiler import KernelCompiler, no_collections
from core.numerics.kernel_folder import kernel_files
from core.numerics.kernel_libraries import CalledLibrary, EntryLibrary, NativeLibrary, PartLibrary, Types

PART, ENTRY = "part", "entry"

by_name: dict[str, "Kernel"] = {}
"""Every kernel of this process by its name."""


class _Part:
    """A compiled part; numba finds its implementation by this object."""

    def __init__(self, signature: Any, fndesc: Any, library: PartLibrary | CalledLibrary) -> None:
        self.signature, self.fndesc, self.library = signature, fndesc, library


class Kernel(CPUDispatcher):
    """A compiled function: numba's dispatcher, with parts, entries and files of our own."""

    files = kernel_files()
    """Where compiled code is kept."""
    stays_a_function = False
    """As a part it is native code of its own, which its callers call."""
    fallback: Callable[["Kernel", Types], Callable[..., Any] | None] | None = None
    """What Python runs in place of an entry that is not compiled yet; nothing waits for a compiler then."""

    def __init__(
        self,
        py_func: Callable[..., Any],
        locals: Any = None,
        targetoptions: Any = None,
        pipeline_class: Any = compiler.Compiler,
    ) -> None:
        super().__init__(py_func, locals, targetoptions, pipeline_class)
        self._compiler = KernelCompiler(
            py_func, self.targetdescr, self.targetoptions, self.locals, pipeline_class
        )
        self.in_python: Callable[..., Any] | None = None
        """What stands for it in plain Python, where that is not the function itself."""
        line = py_func.__code__.co_firstlineno
        self.name = f"{py_func.__module__}.{py_func.__qualname__}.{line}".replace("<", "").replace(">", "")
        self._parts: dict[Types, _Part] = {}
        self._source = _source_key(py_func)
        by_name[self.name] = self

    # --- what numba asks for --------------------------------------------------------------------------------

    def compile(self, sig: Any) -> Any:
        """Return the entry for these argument types, from memory, disk or the compiler."""
        args = _plain(normalize_signature(sig)[0])
        with global_compiler_lock:
            found = self.overloads.get(args)
            if found is None:
                with self._compiling_counter:
                    found = self._entry(args)
                self.add_overload(found)
            return found.entry_point

    def get_call_template(self, args: Types, kws: Any) -> Any:
        """Return the type of a call by another kernel, which makes this one a part of it."""
        pysig, folded = self._compiler.fold_argument_types(args, kws)
        self.part(_plain(folded))
        name = self.py_func.__name__
        signatures = [part.signature for part in self._parts.values()]
        template = typing.make_concrete_template(f"CallTemplate({name})", key=name, signatures=signatures)
        return template, pysig, folded, {}

    def get_overload(self, sig: Any) -> Any:
        """Return by what numba finds the implementation of a part."""
        return self._parts[tuple(normalize_signature(sig)[0])]

    def _compile_for_args(self, *args: Any, **kws: Any) -> Any:
        if Kernel.fallback is not None:
            stand_in = Kernel.fallback(self, args)
            if stand_in is not None:
                self._types_active_call.clear()
                return stand_in
        return super()._compile_for_args(*args, **kws)

    # --- parts and entries ----------------------------------------------------------------------------------

    def part(self, args: Types) -> _Part:
        """Return this kernel as a part of others, from memory, disk or the compiler."""
        found = self._parts.get(args)
        if found is None:
            found = self._load_part(args)
            if found is None:
                with self.files.turn(f"{self.name}.{PART}"):
                    found = self._load_part(args) or self._new_part(args)
            self._parts[args] = found
            self.targetctx.insert_user_function(found, found.fndesc, [found.library])
        return found

    def _new_part(self, args: Types) -> _Part:
        library: PartLibrary | CalledLibrary
        name, codegen = self.py_func.__qualname__, self.targetctx.codegen()
        library = CalledLibrary(codegen, name) if self.stays_a_function else PartLibrary(codegen, name)
        library.owner = (self.name, args)
        library.enable_object_caching()
        with no_collections():
            result = self._compiler.part(args, library)
            library.environment, library.symbol = result.environment, result.fndesc.llvm_func_name
            library._ensure_finalized()
            part = _Part(result.signature, result.fndesc, library)
            if isinstance(library, CalledLibrary):
                _tell(library, result.environment)
                self._save_native(PART, args, library, result)
            else:
                self._save_part(args, part, library)
        return part

    def _entry(self, args: Types) -> Any:
        found = self._load_entry(args)
        if found is None:
            with self.files.turn(f"{self.name}.{ENTRY}"):
                found = self._load_entry(args)
                if found is None:
                    self._cache_misses[args] += 1
                    return self._new_entry(args)
        self._cache_hits[args] += 1
        self.targetctx.insert_user_function(found.entry_point, found.fndesc, [found.library])
        return found

    def _new_entry(self, args: Types) -> Any:
        library = EntryLibrary(self.targetctx.codegen(), self.py_func.__qualname__)
        library.enable_object_caching()
        with no_collections():
            result = self._compiler.entry(args, library)
            self._save_native(ENTRY, args, library, result)
        return result

    # --- files ----------------------------------------------------------------------------------------------

    def _key(self, kind: str, args: Types) -> str:
        codegen = self.targetctx.codegen()
        return repr((kind, [str(a) for a in args], codegen.magic_tuple(), VERSIONS, self._source))

    def _load(self, kind: str, args: Types) -> Any:
        if self._source is None:
            return None
        # Types known to numba only after its extensions are.
        self.targetctx.refresh()
        payload = self.files.load(f"{self.name}.{kind}", self._key(kind, args))
        if payload is None:
            return None
        return pickle.loads(payload)

    def _save(self, kind: str, args: Types, content: tuple[Any, ...]) -> None:
        self.files.save(f"{self.name}.{kind}", self._key(kind, args), dumps(content))

    def _save_part(self, args: Types, part: _Part, library: PartLibrary) -> None:
        if self._source is None or library.has_dynamic_globals:
            return
        _forget_types(part.fndesc)
        content = (
            library.name,
            library._final_module.as_bitcode(),
            [(*called.owner, called.symbol) for called in library.parts],
            part.fndesc,
            library.environment,
            part.signature,
            library._reload_init,
        )
        self._save(PART, args, content)

    def _load_part(self, args: Types) -> _Part | None:
        if self.stays_a_function:
            return self._load_called(args)
        content = self._load(PART, args)
        if content is None:
            return None
        name, bitcode, calls, fndesc, environment, signature, reload_init = content
        parts = _at_hand(calls)
        if parts is None:
            return None
        for run in reload_init:
            run()
        library = PartLibrary(self.targetctx.codegen(), name)
        library.owner, library.environment = (self.name, args), environment
        library.symbol = fndesc.llvm_func_name
        library._reload_init.update(reload_init)
        library._final_module = llvm.parse_bitcode(bitcode)
        library._linking_libraries += [part.library for part in parts]
        library.seal()
        return _Part(signature, fndesc, library)

    def _load_called(self, args: Types) -> _Part | None:
        library = CalledLibrary(self.targetctx.codegen(), self.py_func.__qualname__)
        found = self._load_native(PART, args, library)
        if found is None:
            return None
        fndesc, environment, signature, _ = found
        library.owner, library.environment = (self.name, args), environment
        library.symbol = fndesc.llvm_func_name
        _tell(library, environment)
        return _Part(signature, fndesc, library)

    def _save_native(self, kind: str, args: Types, library: NativeLibrary, result: Any) -> None:
        """Keep native code, and tell its parts' environments to it."""
        for part in library._linking_libraries:
            if isinstance(part, PartLibrary):
                _tell(library, part.environment)
        if self._source is None or library.has_dynamic_globals:
            return
        _forget_types(result.fndesc)
        module = library._final_module
        defined = [f.name for f in module.functions if not f.is_declaration]
        defined += [g.name for g in module.global_variables if not g.is_declaration]
        content = (
            [(*called.owner, called.symbol) for called in library.called],
            library._get_compiled_object(),
            defined,
            result.fndesc,
            result.environment,
            result.signature,
            result.reload_init,
            tuple(result._find_referenced_environments()),
        )
        self._save(kind, args, content)

    def _load_native(
        self, kind: str, args: Types, library: NativeLibrary
    ) -> tuple[Any, Any, Any, set[Any]] | None:
        """Load native code into a library; return its description, environment, signature, and what runs
        before.
        """
        content = self._load(kind, args)
        if content is None:
            return None
        calls, code, defined, fndesc, environment, signature, reload_init, environments = content
        called = _at_hand(calls)
        if called is None:
            return None
        for run in reload_init:
            run()
        codegen = library.codegen
        library.called = tuple(cast(CalledLibrary, part.library) for part in called)
        library.enable_object_caching()
        library._set_compiled_object(code)
        library._finalize_final_module()
        codegen._engine._defined_symbols.update(defined)
        for referenced in environments:
            codegen.set_env(referenced.env_name, referenced)
        return fndesc, environment, signature, reload_init

    def _load_entry(self, args: Types) -> Any:
        library = EntryLibrary(self.targetctx.codegen(), self.py_func.__qualname__)
        found = self._load_native(ENTRY, args, library)
        if found is None:
            return None
        fndesc, environment, signature, reload_init = found
        return compiler.compile_result(
            target_context=self.targetctx,
            typing_context=self.typingctx,
            library=library,
            environment=environment,
            entry_point=self.targetctx.get_executable(library, fndesc, environment),
            fndesc=fndesc,
            signature=signature,
            objectmode=False,
            lifted=(),
            reload_init=reload_init,
            metadata={},
        )


def _tell(library: NativeLibrary, environment: Any) -> None:
    """Tell native code its environment, unless it does without."""
    if library.codegen._engine.is_symbol_defined(environment.env_name):
        library.codegen.set_env(environment.env_name, environment)


def _at_hand(calls: list[tuple[str, Types, str]]) -> list[_Part] | None:
    """Return the parts that kept code calls; None where one of them has been compiled anew since.

    Code that was linked to another one of its name would jump into nothing.
    """
    found = [(kernel_named(name).part(args), symbol) for name, args, symbol in calls]
    whole = all(part.library.symbol == symbol for part, symbol in found)
    return [part for part, _ in found] if whole else None


VERSIONS = (numba.__version__, llvmlite.__version__, sys.implementation.cache_tag)


def kernel_named(name: str) -> Kernel:
    """Return the kernel of this name; its module is imported."""
    if name not in by_name:
        module = name
        while name not in by_name and "." in module:
            module = module.rpartition(".")[0]
            try:
                importlib.import_module(module)
            except ImportError:
                continue
            break
    return by_name[name]


def _plain(args: Types) -> Types:
    """Return types without constants: the optimiser makes the same of a kernel per constant as of one for
    all.
    """
    unliteral = cast(Any, types).unliteral
    return tuple(unliteral(argument) for argument in args)


def _source_key(function: Callable[..., Any]) -> str | None:
    """Return what of a function's source is not in the name of the folder; None where its code cannot be
    kept.
    """
    code = cast(Any, function).__code__
    if cast(Any, function).__closure__ is not None:
        return None
    if function.__module__.split(".")[0] in ("core", "studies"):
        return ""
    try:
        return hashlib.sha256(Path(code.co_filename).read_bytes()).hexdigest()
    except OSError:
        return None


def _forget_types(fndesc: Any) -> None:
    """Numba does this too before it keeps a description: these cannot be pickled, and nobody needs them any
    more.
    """
    fndesc.typemap = fndesc.calltypes = None
