"""numba's dispatcher, without the part that only Python needs in kernels that only kernels call.

numba makes a wrapper for Python of every function that it compiles, in machine code of its own.  Of the 300
functions of a step Python calls one: without the other wrappers a first step compiles in two thirds of the time.
A kernel that is compiled for another kernel and is called from Python later is compiled once more, with its wrapper.
"""

from __future__ import annotations

from typing import Any

from numba.core import sigutils
from numba.core.compiler_lock import global_compiler_lock
from numba.core.registry import CPUDispatcher
from numba.core.types.misc import unliteral


class KernelDispatcher(CPUDispatcher):
    """A kernel; ``inner`` while it is compiled for another kernel."""

    _depth = 0  # of compilations inside one another, in this process; guarded by numba's compiler lock

    def __init__(self, function: Any, options: dict[str, Any]) -> None:
        super().__init__(py_func=function, locals={}, targetoptions={**options, "nopython": True, "boundscheck": None})
        self.inner = False
        self._options = dict(self._compiler.targetoptions)
        self._inner_overloads: set[tuple[Any, ...]] = set()

    def get_call_template(self, arguments: Any, keywords: Any) -> Any:
        """Numba's, but a constant argument has the type of a variable: it would be compiled for each constant."""
        plain = tuple(unliteral(argument) for argument in arguments)
        return super().get_call_template(plain, {name: unliteral(kind) for name, kind in keywords.items()})

    def compile(self, signature: Any) -> Any:
        """Compile for these types, or load from the cache; returns the entry point, null of an inner kernel."""
        with global_compiler_lock:
            inner = KernelDispatcher._depth > 0
            arguments = tuple(sigutils.normalize_signature(signature)[0])
            if not inner and arguments in self._inner_overloads:
                self._inner_overloads.remove(arguments)
                del self.overloads[arguments]
            before = self.inner
            self._become(inner)
            KernelDispatcher._depth += 1
            try:
                return super().compile(signature)
            finally:
                KernelDispatcher._depth -= 1
                self._become(before)

    def _become(self, inner: bool) -> None:
        self.inner = inner
        self._compiler.targetoptions = {**self._options, "no_cpython_wrapper": inner}

    def add_overload(self, result: Any) -> None:
        """Make a compiled function known to kernels and, unless it is inner, to Python."""
        if not self.inner:
            super().add_overload(result)
            return
        arguments = tuple(result.signature.args)
        self._inner_overloads.add(arguments)
        self.overloads[arguments] = result
