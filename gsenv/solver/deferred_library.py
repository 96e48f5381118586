"""Machine code is made once, for the kernels that Python calls.

numba optimises each function together with all that it calls and translates it to machine code before it compiles
the caller, where the same happens again; the functions of a step are nested ten deep.  A `DeferredLibrary` does
neither until a pointer to its code is needed.  Until then it holds one function, and its caller links it.

The cache stores the machine code of such a kernel without the code that callers link, which takes twice the space
and is seldom wanted: a caller makes it anew.
"""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager
from importlib import import_module
from operator import attrgetter
from typing import Any

from llvmlite import binding
from numba.core import config
from numba.core.codegen import JITCodeLibrary
from numba.core.environment import lookup_environment
from numba.core.runtime import rtsys

_MACHINE_CODE = "machine code"  # the kind of a cache entry
_ENVIRONMENT = "_ZN08NumbaEnv"  # prefix of the global variables that point to a function's globals
_DYNAMIC = "numba.dynamic.globals"  # prefix of addresses that are valid in this process only


class StaleEntryError(LookupError):
    """A cache entry calls code that no longer exists under that name."""


class DeferredLibrary(JITCodeLibrary):
    """The code of one function and the libraries of the functions that it calls."""

    kernel: tuple[Any, tuple[Any, ...]] | None = None
    """The dispatcher and the argument types of a kernel, None for other functions."""

    is_machine_code = False
    """Whether it was loaded without code that a caller can link."""

    @property
    def codegen(self) -> Any:
        """The code generator; of an incomplete library an object whose ``set_env`` does nothing."""
        return self._codegen if self._finalized else self

    def set_env(self, name: str, environment: Any) -> None:
        """Do nothing: the global variable has no address yet. ``finalize`` sets it."""

    @property
    def has_dynamic_globals(self) -> bool:
        """Whether the code holds addresses that another process cannot use."""
        libraries = [self, *self._callees(beyond_kernels=False)]
        return any(_has_dynamic_globals(library._final_module) for library in libraries)

    def kernel_name(self) -> tuple[str, str, tuple[Any, ...]] | None:
        """Return module, name and argument types of a kernel that an import finds, None for other functions."""
        if self.kernel is None:
            return None
        dispatcher, arguments = self.kernel
        module, name = dispatcher.__module__, dispatcher.__qualname__
        try:
            found = attrgetter(name)(import_module(module))
        except (ImportError, AttributeError):
            return None
        return (module, name, arguments) if found is dispatcher else None

    def add_linking_library(self, library: Any) -> None:
        """Add a callee, which stays incomplete."""
        self._linking_libraries.append(library)

    def _get_module_for_linking(self) -> Any:
        """Return the code for a caller; of an incomplete library its own function alone."""
        if self.is_machine_code:
            return self._linkable_again()
        if self._finalized:
            return super()._get_module_for_linking()
        module = self._final_module.clone()
        for function in module.functions:
            if not function.is_declaration and function.linkage == binding.Linkage.external:
                function.linkage = "linkonce_odr"  # several callers may link it
        return module

    def _linkable_again(self) -> Any:
        """Return the code of this kernel and of all that it calls, compiled once more or from the cache."""
        assert self.kernel is not None
        dispatcher, arguments = self.kernel
        library = dispatcher.compile_inner(arguments).library
        module = library._get_module_for_linking()
        for callee in library._callees():
            module.link_in(callee._get_module_for_linking(), preserve=True)
        return module

    def finalize(self) -> None:
        """Link the callees, direct and indirect, optimise, and translate to machine code."""
        self._linking_libraries = list(self._callees())
        super().finalize()
        for variable in self._final_module.global_variables:
            if variable.name.startswith(_ENVIRONMENT):
                environment = lookup_environment(variable.name)
                if environment is not None:
                    self.codegen.set_env(variable.name, environment)

    def _optimize_final_module(self) -> None:
        with _superword_parallel():
            super()._optimize_final_module()

    def get_pointer_to_function(self, name: str) -> int:
        """Return the address of a function, 0 where this library does not define it."""
        if not self._finalized:
            if not _defines(self._final_module, name):
                return 0
            self.finalize()
        return int(super().get_pointer_to_function(name))

    def serialize_using_object_code(self) -> Any:
        """Return what the cache stores: machine code, or of an incomplete library its code and its callees' names."""
        if self._finalized:
            return self._serialize_machine_code()
        module, kernels = self._get_module_for_linking(), []
        own = {function.name for function in module.functions if not function.is_declaration}
        for library in self._callees(beyond_kernels=False):
            kernel = library.kernel_name() if isinstance(library, DeferredLibrary) else None
            if kernel is not None:
                kernels.append(kernel)
            elif library is not rtsys.library:
                module.link_in(library._get_module_for_linking(), preserve=True)
        for function in module.functions:
            if not function.is_declaration and function.name not in own:
                function.linkage = "internal"  # numba names helpers by a number that another process gives to others
        return self.name, "deferred", (module.as_bitcode(), kernels)

    def _serialize_machine_code(self) -> Any:
        if self.kernel is None or not self.kernel[0].has_lasting_symbol:
            return super().serialize_using_object_code()
        module = self._final_module
        named = (*module.functions, *module.global_variables)
        symbols = [value.name for value in named if not value.is_declaration]
        return self.name, _MACHINE_CODE, (self._get_compiled_object(), symbols)

    @classmethod
    def _load_machine_code(cls, codegen: Any, state: Any) -> Any:
        name, _, (code, symbols) = state
        library = codegen.create_library(name)
        library.is_machine_code = True
        library.enable_object_caching()
        library._set_compiled_object(code)
        library._finalize_final_module()
        codegen._engine._defined_symbols.update(symbols)
        return library

    @classmethod
    def _unserialize(cls, codegen: Any, state: Any) -> Any:
        name, kind, data = state
        if kind == _MACHINE_CODE:
            return cls._load_machine_code(codegen, state)
        if kind != "deferred":
            return super()._unserialize(codegen, state)
        library = codegen.create_library(name)
        code, kernels = data
        library._final_module = binding.parse_bitcode(code)
        library._linking_libraries = [rtsys.library, *(_compiled(*kernel) for kernel in kernels)]
        missing = library.undefined_functions()
        if missing:
            raise StaleEntryError(f"no callee defines {missing[0]}")
        return library

    def undefined_functions(self) -> list[str]:
        """Return the names of compiled functions that this code calls and no callee defines."""
        callees = [library._final_module for library in self._linking_libraries]
        called = [function.name for function in self._final_module.functions if function.is_declaration]
        return [
            name for name in called if name.startswith("_ZN") and not any(_defines(module, name) for module in callees)
        ]

    def _verify_declare_only_symbols(self) -> None:
        """Raise AssertionError where a function is called and not linked; numba checks its own names only."""
        for function in self._final_module.functions:
            if function.is_declaration and function.name.startswith("_ZN"):
                raise AssertionError(f"{self.name} calls {function.name}, which is not linked")

    def _callees(self, beyond_kernels: bool = True) -> list[Any]:
        """Return the libraries that this code calls, directly or not, each after all that call it.

        The linker drops a function that nothing linked so far calls, so callers must come first.
        Without ``beyond_kernels``, the callees of kernels that can be imported are left out.
        """
        found: dict[Any, None] = {}  # each before all that call it
        seen: set[Any] = set()

        def visit(library: Any) -> None:
            if library in seen:
                return
            seen.add(library)
            if isinstance(library, DeferredLibrary) and not library._finalized:
                if beyond_kernels or library.kernel_name() is None:
                    for callee in library._linking_libraries:
                        visit(callee)
            found[library] = None

        for callee in self._linking_libraries:
            visit(callee)
        return list(reversed(found))


@contextmanager
def _superword_parallel() -> Iterator[None]:
    """Let LLVM compute several numbers of straight code at once (SLP); results keep their bits.

    numba leaves it off. Larsen, Amarasinghe, "Exploiting superword level parallelism", PLDI 2000.
    """
    before = config.SLP_VECTORIZE
    config.SLP_VECTORIZE = 1
    try:
        yield
    finally:
        config.SLP_VECTORIZE = before


@contextmanager
def deferred(codegen: Any) -> Iterator[None]:
    """Make `DeferredLibrary` the class of all libraries that are created in the `with` block."""
    before = codegen._library_class
    codegen._library_class = DeferredLibrary
    try:
        yield
    finally:
        codegen._library_class = before


def _defines(module: Any, name: str) -> bool:
    try:
        return not module.get_function(name).is_declaration
    except NameError:
        return False


def _has_dynamic_globals(module: Any) -> bool:
    return any(variable.name.startswith(_DYNAMIC) for variable in module.global_variables)


def _compiled(module: str, name: str, arguments: tuple[Any, ...]) -> Any:
    """Return the library of a kernel for these argument types, from the cache if it is there."""
    dispatcher = attrgetter(name)(import_module(module))
    dispatcher.compile(arguments)
    return dispatcher.overloads[arguments].library
