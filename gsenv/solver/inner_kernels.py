"""numba's dispatcher, without what only Python needs in kernels that only kernels call.

numba makes a wrapper for Python of every function that it compiles, and machine code of its own.  Of the 300
functions of a step Python calls one: without the other wrappers and their machine code (`deferred_library`) a first
step compiles in less than half of the time.  A kernel that is compiled for another kernel and is called from Python
later is compiled once more, with its wrapper.
"""

from __future__ import annotations

from typing import Any

from numba.core import sigutils
from numba.core.bytecode import FunctionIdentity
from numba.core.compiler import Compiler, Flags
from numba.core.compiler_lock import global_compiler_lock
from numba.core.registry import CPUDispatcher
from numba.core.types.misc import unliteral
from numba.core.typing import make_concrete_template
from numba.core.untyped_passes import ExtractByteCode

from .deferred_library import deferred

symbol_ids: dict[Any, int] = {}
"""Of functions that can be imported: what tells its symbol from those of other functions, equal in every process."""


class _KernelFlags(Flags):
    """Flags of a kernel, whose symbol does not depend on whether it has a wrapper for Python."""

    def get_mangle_string(self) -> str:
        plain = Flags(self)
        plain.discard("no_cpython_wrapper")
        return str(plain.get_mangle_string())


class _KernelCompiler(Compiler):
    """numba's compiler with symbols that are equal in every process: cached callers refer to callees by symbol."""

    def __init__(self, *arguments: Any) -> None:
        super().__init__(*arguments)
        self.state.flags = _KernelFlags(self.state.flags)

    def compile_extra(self, function: Any) -> Any:
        self.state.func_id = FunctionIdentity.from_function(function)
        self.state.func_id.unique_id = symbol_ids.get(function, self.state.func_id.unique_id)
        ExtractByteCode().run_pass(self.state)
        self.state.lifted = ()
        self.state.lifted_from = None
        return self._compile_bytecode()


class KernelDispatcher(CPUDispatcher):
    """A kernel; ``inner`` while it is compiled for another kernel."""

    _depth = 0  # of compilations inside one another, in this process; guarded by numba's compiler lock

    def __init__(self, function: Any, options: dict[str, Any]) -> None:
        target_options = {**options, "nopython": True, "boundscheck": None}
        super().__init__(py_func=function, locals={}, targetoptions=target_options, pipeline_class=_KernelCompiler)
        self.inner = False
        self._options = dict(self._compiler.targetoptions)
        self._inner_overloads: set[tuple[Any, ...]] = set()
        self._machine_code: dict[tuple[Any, ...], Any] = {}  # results for Python, while `overloads` has inner ones

    def get_call_template(self, arguments: Any, keywords: Any) -> Any:
        """Numba's, for exactly these types: a record never stands for another one with the same first fields.

        A constant argument has the type of a variable; otherwise the kernel would be compiled for each constant.
        """
        plain = tuple(unliteral(argument) for argument in arguments)
        named = {name: unliteral(kind) for name, kind in keywords.items()}
        template, signature, folded, rest = super().get_call_template(plain, named)
        result = self.overloads.get(tuple(folded))
        if result is not None:
            template = make_concrete_template(template.__name__, template.key, [result.signature])
        return template, signature, folded, rest

    def compile(self, signature: Any) -> Any:
        """Compile for these types, or load from the cache; returns the entry point, null of an inner kernel."""
        with global_compiler_lock:
            inner = KernelDispatcher._depth > 0
            arguments = tuple(sigutils.normalize_signature(signature)[0])
            if not inner and arguments in self._inner_overloads:
                self._inner_overloads.remove(arguments)
                del self.overloads[arguments]
                if arguments in self._machine_code:
                    self.overloads[arguments] = self._machine_code.pop(arguments)
            elif inner and arguments in self.overloads and self.overloads[arguments].library.is_machine_code:
                self._machine_code[arguments] = self.overloads.pop(arguments)
            before = self.inner
            self._become(inner)
            KernelDispatcher._depth += 1
            try:
                with deferred(self.targetdescr.target_context.codegen()):
                    return super().compile(signature)
            finally:
                KernelDispatcher._depth -= 1
                self._become(before)

    def compile_inner(self, arguments: tuple[Any, ...]) -> Any:
        """Compile for these types as for another kernel; returns numba's result."""
        with global_compiler_lock:
            KernelDispatcher._depth += 1
            try:
                self.compile(arguments)
            finally:
                KernelDispatcher._depth -= 1
            return self.overloads[arguments]

    @property
    def has_lasting_symbol(self) -> bool:
        """Whether every process gives this kernel's code the same name."""
        return self.py_func in symbol_ids

    def _become(self, inner: bool) -> None:
        self.inner = inner
        self._compiler.targetoptions = {**self._options, "no_cpython_wrapper": inner}

    def add_overload(self, result: Any) -> None:
        """Make a compiled function known to kernels and, unless it is inner, to Python."""
        arguments = tuple(result.signature.args)
        result.library.kernel = self, arguments
        if not self.inner:
            super().add_overload(result)
            return
        self._inner_overloads.add(arguments)
        self.overloads[arguments] = result
