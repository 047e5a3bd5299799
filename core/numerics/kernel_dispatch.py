"""How kernels are compiled: each once as a part of others, and as a whole piece of code only where Python
calls it.

Numba compiles every function into native code of its own, with a wrapper for Python, although most of ours
are only ever called by other kernels and become one piece with them. Here a kernel that another one calls
becomes a *part*: its types are inferred and its LLVM code is written and simplified, no more. A kernel that
Python calls becomes an *entry*: all parts it reaches are linked into one module, which is optimised and
turned into native code once. Parts and entries are kept on disk apart (`core.numerics.kernel_files`), so an
entry that comes later does not begin anew (`docs/decisions/cold-start.md`, with the figures).
"""

import gc
import hashlib
import importlib
import pickle
import sys
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any, cast

import llvmlite
import numba
from llvmlite import binding as llvm
from numba.core import compiler, types, typing
from numba.core.codegen import JITCodeLibrary
from numba.core.compiler_lock import global_compiler_lock
from numba.core.dispatcher import _FunctionCompiler
from numba.core.registry import CPUDispatcher
from numba.core.serialize import dumps
from numba.core.sigutils import normalize_signature

from core.numerics.kernel_folder import kernel_files
from core.numerics.kernel_libraries import EntryLibrary, PartLibrary, Types

PART, ENTRY = "part", "entry"

by_name: dict[str, "Kernel"] = {}
"""Every kernel of this process by its name."""


class _Flags(compiler.Flags):
    """Numba's, compared by what is set: it compares all 40 options at every look-up of a type, a tenth of all
    time.
    """

    __slots__ = ()

    def __eq__(self, other: object) -> bool:
        return self is other or (isinstance(other, _Flags) and self._values == other._values)

    def __hash__(self) -> int:
        return hash(_Flags)


class _Compiler(_FunctionCompiler):
    """Numba's, told what to compile into."""

    def part(self, args: Types, library: PartLibrary) -> Any:
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


class _Part:
    """A compiled part; numba finds its implementation by this object."""

    def __init__(self, signature: Any, fndesc: Any, library: PartLibrary) -> None:
        self.signature, self.fndesc, self.library = signature, fndesc, library


class Kernel(CPUDispatcher):
    """A compiled function: numba's dispatcher, with parts, entries and files of our own."""

    files = kernel_files()
    """Where compiled code is kept."""
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
        self._compiler = _Compiler(py_func, self.targetdescr, self.targetoptions, self.locals, pipeline_class)
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
        library = PartLibrary(self.targetctx.codegen(), self.py_func.__qualname__)
        library.owner = (self.name, args)
        with _no_collections():
            result = self._compiler.part(args, library)
            library.environment = result.environment
            library._ensure_finalized()
            part = _Part(result.signature, result.fndesc, library)
            self._save_part(args, part)
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
        with _no_collections():
            result = self._compiler.entry(args, library)
            engine = library.codegen._engine
            for part in library._linking_libraries:
                if isinstance(part, PartLibrary) and engine.is_symbol_defined(part.environment.env_name):
                    library.codegen.set_env(part.environment.env_name, part.environment)
            self._save_entry(args, result)
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

    def _save_part(self, args: Types, part: _Part) -> None:
        library = part.library
        if self._source is None or library.has_dynamic_globals:
            return
        _forget_types(part.fndesc)
        calls = [called.owner for called in library.parts]
        bitcode = library._final_module.as_bitcode()
        content = (
            library.name,
            bitcode,
            calls,
            part.fndesc,
            library.environment,
            part.signature,
            library._reload_init,
        )
        self._save(PART, args, content)

    def _load_part(self, args: Types) -> _Part | None:
        content = self._load(PART, args)
        if content is None:
            return None
        name, bitcode, calls, fndesc, environment, signature, reload_init = content
        for run in reload_init:
            run()
        library = PartLibrary(self.targetctx.codegen(), name)
        library.owner, library.environment = (self.name, args), environment
        library._reload_init.update(reload_init)
        library._final_module = llvm.parse_bitcode(bitcode)
        for called, with_types in calls:
            library._linking_libraries.append(kernel_named(called).part(with_types).library)
        library.seal()
        return _Part(signature, fndesc, library)

    def _save_entry(self, args: Types, result: Any) -> None:
        library = result.library
        if self._source is None or library.has_dynamic_globals:
            return
        _forget_types(result.fndesc)
        module = library._final_module
        defined = [f.name for f in module.functions if not f.is_declaration]
        defined += [g.name for g in module.global_variables if not g.is_declaration]
        content = (
            library.name,
            library._get_compiled_object(),
            defined,
            result.fndesc,
            result.environment,
            result.signature,
            result.reload_init,
            tuple(result._find_referenced_environments()),
        )
        self._save(ENTRY, args, content)

    def _load_entry(self, args: Types) -> Any:
        content = self._load(ENTRY, args)
        if content is None:
            return None
        name, code, defined, fndesc, environment, signature, reload_init, environments = content
        for run in reload_init:
            run()
        codegen = self.targetctx.codegen()
        library = EntryLibrary(codegen, name)
        library.enable_object_caching()
        library._set_compiled_object(code)
        library._finalize_final_module()
        codegen._engine._defined_symbols.update(defined)
        entry_point = self.targetctx.get_executable(library, fndesc, environment)
        for referenced in environments:
            codegen.set_env(referenced.env_name, referenced)
        return compiler.compile_result(
            target_context=self.targetctx,
            typing_context=self.typingctx,
            library=library,
            environment=environment,
            entry_point=entry_point,
            fndesc=fndesc,
            signature=signature,
            objectmode=False,
            lifted=(),
            reload_init=reload_init,
            metadata={},
        )


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


@contextmanager
def _no_collections() -> Iterator[None]:
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
